"""Negative on an arc, against the norm and against dense points of the arc."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.lmi.arc_negativity import is_negative_on
from frictool.plant.lti import Lti
from frictool.verify.hinf_norm import norm


def _system(seed: int, n: int = 5, m: int = 2) -> Lti:
    random = np.random.default_rng(seed)
    a = random.normal(size=(n, n))
    a *= 0.95 / np.max(np.abs(np.linalg.eigvals(a)))
    return Lti(
        a, random.normal(size=(n, m)), random.normal(size=(m, n)), random.normal(size=(m, m)), 1.0
    )


def _level(gamma: float, m: int = 2) -> np.ndarray:
    return np.diag([1.0] * m + [-(gamma**2)] * m).astype(complex)


@pytest.mark.parametrize("seed", range(12))
def test_a_bound_above_the_norm_holds_on_every_arc_and_one_below_only_away_from_the_peak(
    seed: int,
) -> None:
    system = _system(seed)
    peak, where = norm(system)
    for start, stop in ((0.0, np.pi), (0.0, 0.3), (0.3, 2.0), (2.0, np.pi)):
        assert is_negative_on(system, _level(1.001 * peak), start, stop)
        assert is_negative_on(system, _level(0.999 * peak), start, stop) == (
            not start <= where <= stop
        )


@pytest.mark.parametrize("seed", range(30))
def test_a_complex_form_said_to_be_negative_is_so_at_dense_points(seed: int) -> None:
    random, system = np.random.default_rng(seed), _system(seed)
    half = random.normal(size=(4, 4)) + 1j * random.normal(size=(4, 4))
    pi = half + half.conj().T - np.diag([0.0, 0.0, 1.0, 1.0]) * random.uniform(5.0, 60.0)
    agreed = {True: 0, False: 0}
    for start in np.linspace(0.0, np.pi, 16)[:-1]:
        stop = start + np.pi / 15
        m = np.concatenate(
            [
                system.response(np.linspace(start, stop, 400)),
                np.broadcast_to(np.eye(2), (400, 2, 2)),
            ],
            axis=1,
        )
        largest = np.linalg.eigvalsh(m.conj().transpose(0, 2, 1) @ pi @ m)[:, -1].max()
        said = is_negative_on(system, pi, start, stop)
        if abs(largest) > 1e-3:
            assert said == (largest < 0.0)
            agreed[said] += 1
    assert sum(agreed.values()) >= 14
