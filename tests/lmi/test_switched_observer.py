"""Gains of switched observers: closed forms, the norm of one mode, what switches and decays cost,
refusals, random systems simulated."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from frictool.errors import NoSolutionError
from frictool.lmi.switched_observer_gains import (
    ObserverMode,
    SwitchedGains,
    proved_gamma,
    switched_gains,
)
from frictool.plant.lti import Lti
from frictool.typing import Matrix
from frictool.verify.hinf_norm import norm

ALL = [(0, 0), (0, 1), (1, 0), (1, 1)]


def _random(random: np.random.Generator, n: int = 2, outputs: int = 1) -> ObserverMode:
    a = random.normal(size=(n, n))
    a *= random.uniform(0.3, 1.2) / np.max(np.abs(np.linalg.eigvals(a)))
    weight = np.diag(random.uniform(0.1, 1.0, size=n))
    return ObserverMode(a, random.normal(size=(outputs, n)), random.normal(size=(n, 1)), weight)


def _loop(mode: ObserverMode, gains: Matrix) -> Lti:
    return Lti(
        mode.a - gains @ mode.c,
        mode.q,
        mode.weight,
        np.zeros((len(mode.weight), mode.q.shape[1])),
        1.0,
    )


@given(st.floats(-2.0, 2.0), st.floats(0.05, 20.0), st.floats(0.05, 20.0))
@settings(max_examples=15, deadline=None)
def test_a_scalar_is_deadbeat(a: float, q: float, weight: float) -> None:
    """z(1) = weight q Delta(0) whatever the gain, and L = a leaves nothing after it."""
    mode = ObserverMode(np.array([[a]]), np.array([[1.0]]), np.array([[q]]), np.array([[weight]]))
    found = switched_gains({0: mode}, [(0, 0)])
    assert weight * q <= found.gamma <= 1.01 * weight * q
    assert found.gains[0][0, 0] == pytest.approx(a, abs=0.01)


@pytest.mark.parametrize("seed", range(4))
def test_of_one_mode_it_is_the_best_norm_of_any_gain(seed: int) -> None:
    """With one mode nothing is lost in (6.6): no gain that a search finds has a smaller norm."""
    mode = _random(np.random.default_rng(seed))
    found = switched_gains({0: mode}, [(0, 0)])
    own = norm(_loop(mode, found.gains[0]))[0]

    def value(gains: Matrix) -> float:
        loop = _loop(mode, gains[:, None])
        return float(norm(loop)[0]) if loop.stable else 1e6

    searched = min(
        minimize(value, start, method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-8}).fun
        for start in (found.gains[0][:, 0], np.zeros(2))
    )
    assert own <= found.gamma * (1.0 + 1e-6)
    assert searched == pytest.approx(found.smallest_gamma, rel=5e-3)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.accept) for seed in (1, 2))]
)
def test_what_is_asked_beyond_costs(seed: int) -> None:
    random = np.random.default_rng(seed)
    modes = {0: _random(random, 3, 2), 1: _random(random, 3, 2)}
    each = max(switched_gains({0: mode}, [(0, 0)]).smallest_gamma for mode in modes.values())
    allowed = [
        switched_gains(modes, switches).smallest_gamma
        for switches in (ALL[:1] + ALL[3:], ALL[:2] + ALL[3:], ALL)
    ]
    assert allowed[0] == pytest.approx(each, rel=1e-3)
    assert allowed[0] <= allowed[1] * (1.0 + 1e-3)
    assert allowed[1] <= allowed[2] * (1.0 + 1e-3)
    decayed = [switched_gains(modes, ALL, decay).gamma for decay in (1.0, 0.9, 0.7)]
    assert decayed[0] <= 1.01 * decayed[1]
    assert decayed[1] <= 1.01 * decayed[2]
    assert switched_gains(modes, ALL, 0.9).smallest_gamma == pytest.approx(allowed[2], rel=1e-3)


def test_gamma_has_the_units_of_the_channels_and_none_of_the_states() -> None:
    random = np.random.default_rng(7)
    modes = {0: _random(random, 3), 1: _random(random, 3)}
    gamma = switched_gains(modes, ALL, 0.95).gamma
    scaled = {
        i: replace(mode, q=1e4 * mode.q, weight=1e-7 * mode.weight, c=1e5 * mode.c)
        for i, mode in modes.items()
    }
    assert switched_gains(scaled, ALL, 0.95).gamma == pytest.approx(1e-3 * gamma, rel=1e-2)
    t = np.diag([1e-4, 1.0, 1e3])
    assert switched_gains(
        {i: mode.in_states(t) for i, mode in modes.items()}, ALL, 0.95
    ).gamma == pytest.approx(gamma, rel=1e-2)


def _literal(
    mode: ObserverMode, p_i: Matrix, p_j: Matrix, gains: Matrix, gamma: float, decay: float
) -> Matrix:
    """(6.9) as it is printed, with the decay."""
    loop = mode.a - gains @ mode.c
    corner = loop.T @ p_j @ loop - decay**2 * p_i + mode.weight.T @ mode.weight
    side = loop.T @ p_j @ mode.q
    return np.block(
        [[corner, side], [side.T, mode.q.T @ p_j @ mode.q - gamma**2 * np.eye(mode.q.shape[1])]]
    )


@pytest.mark.parametrize("seed", range(3))
def test_what_is_proved_is_the_edge_of_the_inequality_as_it_is_printed(seed: int) -> None:
    random = np.random.default_rng(seed)
    modes = {0: _random(random), 1: _random(random)}
    found = switched_gains(modes, ALL, 0.97)
    posed = {i: mode.in_states(found.t) for i, mode in modes.items()}
    gains = {i: np.linalg.solve(found.t, each) for i, each in found.gains.items()}

    def largest(gamma: float) -> float:
        return max(
            float(
                np.linalg.eigvalsh(
                    _literal(posed[i], found.p[i], found.p[j], gains[i], gamma, 0.97)
                )[-1]
            )
            for i, j in ALL
        )

    assert largest(found.gamma * (1.0 + 1e-6)) < 0.0 < largest(found.gamma * (1.0 - 1e-6))
    assert found.gamma == proved_gamma(modes, ALL, found.gains, found.p, found.t, 0.97)
    worse = {i: 3.0 * each for i, each in found.gains.items()}
    assert proved_gamma(modes, ALL, worse, found.p, found.t, 0.97) > found.gamma


def _simulated(
    modes: dict[int, ObserverMode], found: SwitchedGains, random: np.random.Generator
) -> tuple[float, bool]:
    """The largest |z|/|Delta| along random switching sequences, and whether e' P e fell by the
    decay at every free sample."""
    gain, falls = 0.0, True
    for _ in range(4):
        e, free, seen, entered, now = (
            np.zeros(len(modes[0].a)),
            random.normal(size=len(modes[0].a)),
            0.0,
            0.0,
            int(random.integers(2)),
        )
        for _ in range(100):
            then, delta = int(random.integers(2)), random.normal(size=1)
            loop = modes[now].a - found.gains[now] @ modes[now].c
            seen, entered = (
                seen + float(np.sum((modes[now].weight @ e) ** 2)),
                entered + float(delta @ delta),
            )
            after = loop @ free
            falls &= bool(
                found.value(then, after)
                <= found.decay**2 * found.value(now, free) * (1.0 + 1e-6) + 1e-280
            )
            e, free, now = loop @ e + modes[now].q @ delta, after, then
        gain = max(gain, np.sqrt(seen / entered))
    return float(gain), falls


@pytest.mark.parametrize("decay", [1.0, 0.95, 0.8])
def test_any_two_systems_are_certified_and_keep_it_or_are_refused(decay: float) -> None:
    """Most pairs of random systems have gains with which they may switch at will."""
    certified = 0
    for seed, n, outputs in product(range(2), (1, 2, 3), (1, 2)):
        random = np.random.default_rng(seed)
        modes = {0: _random(random, n, outputs), 1: _random(random, n, outputs)}
        try:
            found = switched_gains(modes, ALL, decay)
        except NoSolutionError:
            continue
        certified += 1
        _keeps_what_is_certified(modes, found, random)
    assert certified >= 9


def _keeps_what_is_certified(
    modes: dict[int, ObserverMode], found: SwitchedGains, random: np.random.Generator
) -> None:
    gain, falls = _simulated(modes, found, random)
    assert falls
    assert gain <= found.gamma
    assert all(_loop(mode, found.gains[i]).stable for i, mode in modes.items())
    for i, j in product(modes, modes):
        both = (modes[j].a - found.gains[j] @ modes[j].c) @ (
            modes[i].a - found.gains[i] @ modes[i].c
        )
        assert np.max(np.abs(np.linalg.eigvals(both))) < 1.0


def test_a_mode_that_sees_nothing_of_what_stays_is_named() -> None:
    seen = ObserverMode(
        np.array([[1.0, 0.1], [0.0, 1.0]]), np.array([[1.0, 0.0]]), np.ones((2, 1)), np.eye(2)
    )
    blind = replace(seen, a=np.diag([0.5, 1.0]))
    with pytest.raises(
        NoSolutionError, match=r"^mode 1: the state with the pole 1 is not observable"
    ):
        switched_gains({0: seen, 1: blind}, ALL)
    fading = replace(seen, a=np.diag([0.5, 0.9]))
    assert np.isfinite(switched_gains({0: seen, 1: fading}, ALL).gamma)


def test_switches_without_common_gains_are_refused_and_so_is_a_decay_that_cannot_be() -> None:
    """A motion that may turn at any sample: friction of a known sign that is corrected two samples
    late."""
    modes = {
        index: ObserverMode(
            np.array([[1.0, 1.0, 0.0], [0.0, 1.0, -sign], [0.0, 0.0, 1.0]]),
            np.eye(1, 3),
            np.array([[0.0], [1.0], [0.0]]),
            np.eye(3),
        )
        for index, sign in ((0, -1.0), (1, 1.0))
    }
    with pytest.raises(NoSolutionError, match="allow fewer switches"):
        switched_gains(modes, ALL)
    assert np.isfinite(switched_gains(modes, [(0, 0), (1, 1)]).gamma)
    with pytest.raises(NoSolutionError, match=r"decay of 1e-06 per sample.*decay nearer to 1"):
        switched_gains(modes, [(0, 0), (1, 1)], 1e-6)
    for decay in (0.0, -1.0, 1.5, np.nan):
        with pytest.raises(ValueError, match="allowed: above 0 and at most 1"):
            switched_gains(modes, [(0, 0)], decay)
