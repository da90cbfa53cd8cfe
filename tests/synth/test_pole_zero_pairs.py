"""Second-order sections against those of scipy, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
import scipy

from frictool.synth.pole_zero_pairs import paired_sections, section_response
from frictool.typing import ComplexVector


def _drawn(rng: np.random.Generator, count: int) -> ComplexVector:
    """Real numbers, some at 0, and pairs of conjugates that may differ by one rounding."""
    values: list[complex] = []
    while len(values) < count:
        if count - len(values) >= 2 and rng.random() < 0.5:
            one = rng.uniform(0.1, 1.2) * np.exp(1j * rng.uniform(0.01, 3.1))
            values += [one, one.conjugate() * (1.0 + rng.choice([0.0, np.finfo(float).eps]))]
        else:
            values.append(complex(rng.choice([rng.uniform(-1.5, 1.5), 0.0, 0.5])))
    return rng.permutation(np.array(values, dtype=np.complex128))


@pytest.mark.parametrize("seed", range(50))
def test_sections_are_those_of_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(20):
        zeros, poles = (_drawn(rng, int(count)) for count in rng.integers(0, 9, 2))
        gain = float(rng.normal())
        sections = paired_sections(zeros, poles, gain)
        assert np.array_equal(sections, scipy.signal.zpk2sos(zeros, poles, gain))
    angles = np.geomspace(1e-3, np.pi, 50)
    expected = scipy.signal.sosfreqz(sections, worN=angles)[1]
    assert section_response(sections, angles) == pytest.approx(expected, rel=1e-7)
