"""Parts of a switched observer: friction over position as intervals, its modes, their
transitions."""

from __future__ import annotations

import itertools
from functools import lru_cache

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from frictool.adapters.axis_model import axis_of
from frictool.documents.model import Model
from frictool.documents.observer import FrictionMap
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Span
from frictool.documents.registry import load
from frictool.errors import NoSolutionError
from frictool.observe.design import additive, multiplicative
from frictool.observe.design.friction_map import friction_at, friction_map
from frictool.observe.design.mode_matrices import ModeConstants, subsystem
from frictool.observe.design.mode_transitions import switches
from frictool.observe.design.position_intervals import intervals, turning_points
from studies.rigs.clutch_model import ROOT
from tests.support.random_observer_models import largest_gain, random_model


@lru_cache
def _model() -> Model:
    return load(ROOT / "configs/clutch/nonlinear.yaml", Model)


def _map(
    forward: tuple[float, ...], backward: tuple[float, ...] = (1.0,), high: float = 1.0
) -> FrictionMap:
    return FrictionMap(Span(0.0, high, "rad"), forward, backward)


@given(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=6), st.integers(0, 8))
@example([0.0, 1.0, -1.0, 4.6e-42], 0)  # eigenvalues of a companion matrix lose these zeros
@settings(max_examples=60, deadline=None)
def test_friction_stays_between_the_ends_of_each_interval(powers: list[float], more: int) -> None:
    friction = _map((3.0 * len(powers), *powers[1:]))
    stretches = len(turning_points(friction, 1)) - 1
    found = intervals(friction, 1, stretches + more)
    assert found[0].low == 0.0
    assert found[-1].high == 1.0
    assert all(one.high == after.low for one, after in itertools.pairwise(found))
    for one in found:  # (6.17)
        inside = friction_at(friction, 1, np.linspace(one.low, one.high, 101))
        assert np.max(np.abs(inside - one.friction)) <= one.deviation + 1e-9
    if len(found) > 1:
        assert len(found) == stretches + more
    spread = float(
        np.sum(np.abs(np.diff(friction_at(friction, 1, np.array(turning_points(friction, 1))))))
    )
    assert (
        max(one.deviation for one in found) >= 0.5 * spread / len(found) - 1e-12
    )  # no edges could bring it below
    more_of_them = intervals(friction, 1, stretches + more + 1)
    assert max(one.deviation for one in more_of_them) <= max(one.deviation for one in found) + 1e-12


def test_edges_are_at_the_clutchs_extrema_and_too_few_are_refused() -> None:
    friction = friction_map(_model())
    for direction, powers in ((1, friction.forward), (-1, friction.backward)):
        slope = np.polynomial.Polynomial(powers).deriv()
        inner = turning_points(friction, direction)[1:-1]
        assert slope(np.array(inner)) == pytest.approx(0.0, abs=1e-9)
        edges = [one.low for one in intervals(friction, direction, 10)]
        assert all(any(edge == turn for edge in edges) for turn in inner)
    with pytest.raises(
        NoSolutionError,
        match=r"--intervals 2: .*the forward friction has an "
        r"extremum at 20\.\d+, 44\.\d+ rad.*at least 3",
    ):
        intervals(friction, 1, 2)


def test_friction_is_that_of_the_axis_in_slip() -> None:
    """The same levels and the same shape as the plant that the engine moves."""
    friction, axis = friction_map(_model()), axis_of(_model())
    assert axis.laws.shape is not None
    assert axis.laws.backward is not None
    places = np.linspace(0.0, 63.0, 2001)
    for side, direction, level in ((0, 1, axis.coulomb), (1, -1, axis.laws.backward.coulomb)):
        values = friction_at(friction, direction, places)
        assert np.trapezoid(values, places) / 63.0 == pytest.approx(level, rel=1e-5)
        shape = np.polynomial.polynomial.polyval(places, axis.laws.shape.coulomb[side])
        assert values / values[0] == pytest.approx(shape / shape[0], rel=1e-12)
    assert friction_at(friction, 1, 80.0) == friction_at(friction, 1, 63.0)


def test_the_switches_of_figure_6_3() -> None:
    found = set(switches(3, 2, "neighbours"))
    moving = {(1, 2), (2, 3), (-2, -1)}
    stay = {(i, i) for i in range(-2, 4)}
    assert found == moving | stay | {(i, 0) for i in range(-2, 4)} | {(0, i) for i in range(-2, 4)}
    wider = set(switches(3, 2, "direction"))
    assert wider == found | {(1, 3), (2, 1), (3, 1), (3, 2), (-1, -2)}
    assert not any(i * j < 0 for i, j in wider)


@pytest.mark.parametrize("wear", ["multiplicative", "additive"])
@pytest.mark.parametrize("direction", [-1, 1])
def test_friction_opposes_the_motion_and_rest_holds(wear: str, direction: int) -> None:
    facts = ModeConstants(wear, 1e-3, 2e-5, 1e-4, 1.0, (1.0, 100.0, 0.001))
    mode, rest = subsystem(facts, direction, 0.1, 0.01), subsystem(facts, 0, 0.0, 0.0)
    speed = 100.0 * direction
    before, worn = (mode.a @ np.array([0.0, speed, alpha]) for alpha in (1.0, 1.5))
    assert abs(worn[1]) < abs(before[1]) < abs(speed)
    step = 1e-3 / 2e-5 * (0.1 if wear == "multiplicative" else 1.0) * 0.5
    assert abs(before[1]) - abs(worn[1]) == pytest.approx(step)
    assert np.array_equal(rest.a, [[1.0, 1e-3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.array_equal(rest.c, [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("number", [0, pytest.param(22, marks=pytest.mark.accept)])
def test_drawn_models_keep_their_gamma(number: int) -> None:
    """A part of the check `observers: designs of drawn models`."""
    model, asked, is_additive = random_model(number)
    observer = (additive if is_additive else multiplicative).design(
        model, asked, Provenance("drawn", "0")
    )
    assert 0.01 < largest_gain(observer, sequences=4, samples=500) <= 1.0
