"""Gains that pass little of the measurement's noise: a scalar in closed form, what they give for
it, noise simulated, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.errors import NoSolutionError
from frictool.lmi.quiet_observer_gains import quiet_gains
from frictool.lmi.switched_observer_gains import ObserverMode, proved_gamma, switched_gains

NOISE = {0: np.array([1.0]), 1: np.array([1.0])}
ALL = [(0, 0), (0, 1), (1, 0), (1, 1)]


def _axis(sign: float) -> ObserverMode:
    """Position, speed, and a friction that is not known, in samples; `sign` of the motion."""
    a = np.array([[1.0, 1.0, 0.0], [0.0, 1.0, -sign], [0.0, 0.0, 1.0]])
    return ObserverMode(a, np.eye(1, 3), np.array([[0.0], [1.0], [0.0]]), np.diag([0.01, 1.0, 0.1]))


def _random(random: np.random.Generator) -> ObserverMode:
    a = random.normal(size=(2, 2))
    a *= random.uniform(0.5, 1.1) / np.max(np.abs(np.linalg.eigvals(a)))
    return ObserverMode(
        a,
        random.normal(size=(1, 2)),
        random.normal(size=(2, 1)),
        np.diag(random.uniform(0.1, 1.0, size=2)),
    )


@given(
    st.floats(0.8, 0.97) | st.floats(1.05, 2.0),
    st.floats(0.1, 10.0),
    st.floats(0.1, 10.0),
    st.floats(1.5, 4.0),
)
@settings(max_examples=15, deadline=None)
def test_a_scalar_in_closed_form(a: float, q: float, weight: float, factor: float) -> None:
    """Gamma is weight q/(1 - |r|), at most factor weight q, and nu is weight (a - r)/(1 - |r|), r =
    a - L: for a < 1 the slowest r that gamma allows has the smallest nu, for a > 1 r = 0."""
    mode = ObserverMode(np.array([[a]]), np.array([[1.0]]), np.array([[q]]), np.array([[weight]]))
    found = quiet_gains({0: mode}, [(0, 0)], {0: NOISE[0]}, 1.0, factor)
    left = 1.0 - 1.0 / factor if a < 1.0 else 0.0
    assert found.gains.gamma <= factor * weight * q * (1.0 + 1e-6)
    assert found.noise_gain == pytest.approx(weight * (a - left) / (1.0 - left), rel=0.03)
    assert found.gains.gains[0][0, 0] == pytest.approx(a - left, rel=0.1)


@pytest.mark.parametrize("seed", range(3))
def test_less_noise_for_more_gamma(seed: int) -> None:
    random = np.random.default_rng(seed)
    modes = {0: _random(random), 1: _random(random)}
    strict = switched_gains(modes, ALL, 0.98)
    found = [quiet_gains(modes, ALL, NOISE, 0.98, factor) for factor in (1.2, 2.0, 5.0)]
    for quiet, factor in zip(found, (1.2, 2.0, 5.0), strict=True):
        assert quiet.gains.smallest_gamma <= strict.gamma * (
            1.0 + 1e-6
        )  # a slack in place of lemma 6.2.1 loses less
        assert quiet.gains.gamma <= factor * quiet.gains.smallest_gamma
        assert (
            proved_gamma(modes, ALL, quiet.gains.gains, quiet.gains.p, quiet.gains.t, 0.98)
            == quiet.gains.gamma
        )
    assert found[0].noise_gain >= found[1].noise_gain * 0.999
    assert found[1].noise_gain >= found[2].noise_gain * 0.999
    passed = {i: replace(mode, q=-strict.gains[i]) for i, mode in modes.items()}
    assert found[2].noise_gain <= proved_gamma(
        passed, ALL, strict.gains, strict.p, strict.t, 1.0
    ) * (1.0 + 1e-6)


def test_noise_along_random_switches_stays_below_what_is_proved() -> None:
    modes, random = (
        {
            0: _axis(1.0),
            1: replace(_axis(1.0), a=_axis(1.0).a * np.array([[1, 1, 1], [1, 1, 1.4], [1, 1, 1]])),
        },
        np.random.default_rng(3),
    )
    quiet, strict = quiet_gains(modes, ALL, NOISE, 0.99, 4.0), switched_gains(modes, ALL, 0.99)
    seen = []
    for gains in (quiet.gains.gains, strict.gains):
        worst = 0.0
        for _ in range(10):
            e, out, entered = np.zeros(3), 0.0, 0.0
            for _ in range(500):
                now, w = int(random.integers(2)), float(random.normal())
                out, entered = out + float(np.sum((modes[now].weight @ e) ** 2)), entered + w * w
                e = (modes[now].a - gains[now] @ modes[now].c) @ e - gains[now][:, 0] * w
            worst = max(worst, np.sqrt(out / entered))
        seen.append(worst)
    assert seen[0] <= quiet.noise_gain
    assert seen[0] < 0.7 * seen[1]


def test_what_has_no_solution_is_refused() -> None:
    with pytest.raises(NoSolutionError, match="decay nearer to 1"):
        quiet_gains(
            {0: _axis(1.0), 1: _axis(-1.0)}, ALL, NOISE, 1.0, 100.0
        )  # turns without 0: docs/theory/observers.md
    with pytest.raises(NoSolutionError, match=r"mode 1: .* not observable"):
        quiet_gains({0: _axis(1.0), 1: _axis(0.0)}, ALL, NOISE, 1.0, 2.0)
    for decay, factor in ((0.0, 2.0), (1.1, 2.0), (0.9, 1.0), (0.9, np.nan)):
        with pytest.raises(
            ValueError, match="allowed: a decay above 0 and at most 1, a factor above 1"
        ):
            quiet_gains({0: _axis(1.0)}, [(0, 0)], NOISE, decay, factor)


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_gains_and_noise_do_not_depend_on_the_unit_of_a_measurement(unit: float) -> None:
    """A mode measures, with its noise, in another unit than the other mode."""
    random = np.random.default_rng(0)
    modes = {0: _random(random), 1: _random(random)}
    plain = quiet_gains(modes, ALL, NOISE, 0.98, 2.0)
    other = {**modes, 1: replace(modes[1], c=unit * modes[1].c)}
    found = quiet_gains(other, ALL, {**NOISE, 1: unit * NOISE[1]}, 0.98, 2.0)
    assert found.noise_gain == pytest.approx(plain.noise_gain, rel=1e-3)
    np.testing.assert_allclose(found.gains.gains[0], plain.gains.gains[0], rtol=1e-2, atol=1e-4)
    np.testing.assert_allclose(
        unit * found.gains.gains[1], plain.gains.gains[1], rtol=1e-2, atol=1e-4
    )
