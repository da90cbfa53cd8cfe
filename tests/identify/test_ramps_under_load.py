"""Breakaway ramps of an axis with gravity: the load of the sliding log is kept, a declared load is
fitted or widens the interval, and a ripple that the model lacks widens it by its amplitude."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.load_terms import LoadTerms
from frictool.documents.quantity import Quantity
from frictool.identify.breakaway.breakaway import breakaway
from frictool.identify.breakaway.breakaway_fit import BreakawayFit
from frictool.identify.breakaway.onset_load import NO_LOAD, OnsetLoad
from frictool.identify.breakaway.position_law import (
    BreakawayPositions,
    choose_structure,
    fit_polynomials,
)
from frictool.identify.breakaway.unknown_load import load_slope
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.identification import Identification, identify_records
from frictool.identify.methods import DEFAULT, IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.ripple_search import missing_ripples
from frictool.plant.axis import AxisParameters
from frictool.plant.axis_friction_laws import AxisLaws, FrictionPositionShape
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from tests.support.linear_axis import PERIOD
from tests.support.loaded_axis import COUNT, Loaded, loaded_axis
from tests.support.stribeck_rigs import Ramps, play

LONGEST = 190  # characters of a message
RATIO = 1.3  # breakaway over Coulomb friction
USUAL = IdentificationSettings()
TILT = 0.15  # relative change of the breakaway at 1 rad
TILTED = FrictionPositionShape(-1.0, 1.0, ((1.0, TILT), (1.0, TILT)), ((1.0, TILT), (1.0, TILT)))


def gravity_of(axis: Loaded) -> PositionLoad:
    """Return the gravity of an axis."""
    known = (axis.truth[f"gravity_{name}"] for name in ("sine", "cosine"))
    return PositionLoad(harmonics=(LoadHarmonic(1.0, *known),))


def ramps_of(
    truth: dict[str, float],
    load: PositionLoad,
    ramps: Ramps | None = None,
    laws: AxisLaws | None = None,
    seed: int = 1,
) -> MotionRecord:
    """Return ramps of an axis over +-0.6 rad; the breakaway is RATIO times the Coulomb friction."""
    strength = RATIO * truth["coulomb"]
    axis = AxisParameters(
        truth["inertia"],
        truth["viscous"],
        truth["coulomb"],
        strength,
        offset=truth["offset"],
        encoder_step=COUNT,
    )
    axis = axis if laws is None else axis._replace(laws=laws)
    ramps = ramps or Ramps(strength, 400, 2e-3 * strength, span=0.6)
    position, effort = play(axis, ramps, 80_000, seed, load)
    time = np.arange(position.size) * PERIOD
    return make_record("ramps", time, position, effort, COUNT, 0.0)


def declared(bench: Bench, most: float | None = None) -> Bench:
    size = None if most is None else Quantity(most, unit="N m")
    return msgspec.structs.replace(bench, load=LoadTerms(("offset", "gravity"), most=size))


def identify(records: list[MotionRecord], bench: Bench) -> Identification:
    return identify_records(records, [], bench, DEFAULT, USUAL)


@cache
def heavy(seed: int) -> tuple[Loaded, MotionRecord]:
    """Return an axis with gravity that the bench does not declare, and its ramps."""
    axis = loaded_axis(seed, "gravity", known=False)
    return axis, ramps_of(axis.truth, gravity_of(axis))


@pytest.mark.parametrize("seed", [2, pytest.param(1, marks=pytest.mark.accept)])
def test_ramps_alone_separate_a_declared_gravity_from_the_breakaway(seed: int) -> None:
    axis, ramps = heavy(seed)
    truth = RATIO * axis.truth["coulomb"]
    one = identify([ramps], declared(axis.bench)).identified["breakaway"]
    assert one.low <= truth <= one.high
    assert one.half_width < 0.1 * truth


def test_an_undeclared_gravity_is_a_doubt_about_the_breakaway() -> None:
    axis, ramps = heavy(2)
    found = identify([ramps], axis.bench)
    assert "load" in found.doubts["breakaway"]
    assert found.doubts["breakaway"] in found.warnings
    certain = found.without_doubts()
    assert (certain.identified, certain.laws) == ({}, None)
    assert not identify([ramps], declared(axis.bench)).doubts


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.accept) for seed in (2, 4, 5))]
)
def test_ramps_whose_breakaway_varies_leave_the_gravity_of_a_sliding_log(seed: int) -> None:
    """Friction over position is no reason to take gravity out of the model."""
    axis = loaded_axis(seed, "gravity", known=False)
    ramps = ramps_of(axis.truth, gravity_of(axis), laws=AxisLaws(shape=TILTED))
    found = identify([axis.record, ramps], axis.bench)
    for name in ("inertia", "viscous", "coulomb"):
        one = found.identified[name]
        assert one.low <= axis.truth[name] <= one.high, name
    assert found.laws is not None
    assert found.laws.load is not None
    gravity = found.laws.load.gravity
    assert gravity is not None
    for part in ("sine", "cosine"):
        low, high = getattr(gravity, part).interval
        assert low <= axis.truth[f"gravity_{part}"] <= high
    assert found.ramp is not None
    law = found.ramp.by_position
    assert law is not None
    mean = RATIO * axis.truth["coulomb"] * (1.0 + TILT * 0.5 * (law.low + law.high))
    for powers, level in zip(law.powers, (law.forward, law.backward), strict=True):
        assert powers[1] == pytest.approx(TILT * powers[0], rel=0.1)
        assert level.low <= mean <= level.high
        assert level.half_width < 0.1 * mean
    assert not any("breakaway" in warning for warning in found.warnings)


def test_an_offset_that_changes_between_the_logs_is_no_friction_by_direction() -> None:
    axis = loaded_axis(5, "gravity", known=False)
    shifted = axis.truth | {"offset": 0.0}
    ramps = ramps_of(shifted, gravity_of(axis), laws=AxisLaws(shape=TILTED))
    found = identify([axis.record, ramps], axis.bench)
    assert found.ramp is not None
    assert found.ramp.by_position is not None
    assert not found.ramp.by_position.common
    (doubt,) = (one for one in found.warnings if "or the offset differs by" in one)
    assert doubt == found.doubts["breakaway"]
    assert len(doubt) <= LONGEST


@pytest.mark.parametrize("seed", [2, pytest.param(1, marks=pytest.mark.accept)])
def test_ramps_in_one_direction_need_the_largest_load(seed: int) -> None:
    axis, ramps = heavy(seed)
    turn = slice(0, int(np.argmax(ramps.position > 0.6)))
    forward = make_record(
        "up", ramps.time[turn], ramps.position[turn], ramps.effort[turn], COUNT, 0.0
    )
    mechanics = msgspec.structs.replace(axis.bench.mechanics, offset=Quantity(0.0, unit="N m"))
    bench = msgspec.structs.replace(axis.bench, mechanics=mechanics)
    with pytest.raises(UnusableLogs, match="from the declared gravity: fewer than 5") as error:
        identify([forward], declared(bench))
    assert len(str(error.value)) <= LONGEST
    most = 1.1 * float(np.hypot(*gravity_of(axis).harmonics[0][1:]))
    one = identify([forward], declared(bench, most)).identified["breakaway"]
    truth = RATIO * axis.truth["coulomb"]
    assert one.low <= truth <= one.high
    assert 0.8 * most < one.half_width < 1.5 * most


def test_the_uncertainty_of_the_subtracted_load_widens_the_interval() -> None:
    """An error of the load adds to the breakaway of one direction, and cancels in the mean of both
    directions at the same positions."""
    axis, ramps = heavy(2)
    half = slice(0, int(np.argmax(ramps.position)))
    forward = make_record(
        "up", ramps.time[half], ramps.position[half], ramps.effort[half], COUNT, 0.0
    )
    known = {
        name: Interval(axis.truth[name], axis.truth[name], axis.truth[name])
        for name in ("inertia", "viscous", "coulomb")
    } | {"offset": Interval(0.0, 0.0, 0.0)}
    gravity = gravity_of(axis)
    ends = tuple(
        PositionLoad(harmonics=(LoadHarmonic(1.0, 0.0, cosine),)) for cosine in (-1.0, 1.0)
    )
    widths = []
    for one in (forward, ramps):
        log = replace(one, effort=one.effort - gravity.at(one.position))
        widths.append(
            [
                breakaway([log], axis.bench, known, 0.95, load=load).interval.half_width
                for load in (NO_LOAD, OnsetLoad(errors=(ends,)))
            ]
        )
    assert widths[0][1] > widths[0][0] + 0.2
    assert widths[1][1] < widths[1][0] + 0.1


def rippled(seed: int, number: float) -> tuple[Loaded, PositionLoad, float]:
    """Return an axis with a ripple of 8 % of the Coulomb friction, and the ripple's amplitude."""
    axis = loaded_axis(seed, "", known=False)
    amplitude = 0.08 * axis.truth["coulomb"]
    ripple = PositionLoad(harmonics=(LoadHarmonic(number, amplitude, 0.0),))
    effort = axis.record.effort + ripple.at(axis.record.position)
    return replace(axis, record=replace(axis.record, effort=effort)), ripple, amplitude


@pytest.mark.parametrize(
    ("number", "seed"),
    [
        (160.0, 1),
        (500.0, 1),
        *(
            pytest.param(number, seed, marks=pytest.mark.accept)
            for number in (60.0, 160.0, 300.0, 500.0)
            for seed in (1, 4, 5)
            if (number, seed) not in ((160.0, 1), (500.0, 1))
        ),
    ],
)
def test_a_ripple_is_in_the_model_or_missing(seed: int, number: float) -> None:
    """Smoothing windows may hide a ripple from the model, but not from the search."""
    axis, _, amplitude = rippled(seed, number)
    fit = run(DEFAULT, [axis.record], axis.bench, USUAL)
    if fit.load is not None and fit.load.ripple is not None:
        assert fit.load.ripple.cycles == pytest.approx(number, abs=0.5)
    else:
        missing = missing_ripples(fit, [axis.record], axis.bench, USUAL)
        (one,) = (ripple for ripple in missing if abs(ripple.number - number) < 0.5)
        assert one.amplitude == pytest.approx(amplitude, rel=0.2)


@pytest.mark.parametrize("seed", [1, pytest.param(4, marks=pytest.mark.accept)])
def test_a_ripple_that_the_windows_hide_widens_the_interval_of_local_ramps(seed: int) -> None:
    """Ramps within a quarter of a period all begin at about the same phase of the ripple."""
    axis, ripple, amplitude = rippled(seed, 500.0)
    strength = RATIO * axis.truth["coulomb"]
    local = Ramps(strength, 4, 2e-3 * strength, span=15.0 * COUNT)
    ramps = ramps_of(axis.truth, ripple, local)
    one = identify([axis.record, ramps], axis.bench).identified["breakaway"]
    assert one.low <= strength <= one.high
    assert one.half_width > 0.8 * amplitude


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.accept) for seed in (2, 3, 4))]
)
def test_no_ripple_is_missing_where_none_acts(seed: int) -> None:
    axis = loaded_axis(seed, "", known=False)
    fit = run(DEFAULT, [axis.record], axis.bench, USUAL)
    assert missing_ripples(fit, [axis.record], axis.bench, USUAL) == ()


@pytest.mark.parametrize(
    ("tilt", "slope", "expected"),
    [(0.0, 0.9, 0.9), (0.9, 0.0, None)],  # a spring of 0.9 N m/rad; friction that rises
)
def test_a_load_is_told_from_friction_over_position(
    tilt: float, slope: float, expected: float | None
) -> None:
    """A load adds to the breakaway in one direction and reduces it in the other."""
    draw = np.random.default_rng(3)
    position = np.tile(np.linspace(-1.0, 1.0, 30), 2)
    direction = np.repeat([1.0, -1.0], 30)
    friction = 12.0 + tilt * position + slope * direction * position
    friction += 1e-2 * draw.standard_normal(position.size)
    where = BreakawayPositions(position, direction, -1.0, 1.0)
    structure = choose_structure(where, friction)
    fit = BreakawayFit(structure, None, fit_polynomials(where, friction, structure), friction)
    found = load_slope(where, fit, loaded_axis(1, "", known=False).bench)
    assert found is None if expected is None else found == pytest.approx(expected, rel=0.05)
