"""The tracking observer as the program that runs: a plain reference beside it, what it must never
do, what its design promises."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.observer_composition import observer_program, tracking_facts
from frictool.control.compiled_program import compile_program, control_step, start_at
from frictool.control.number_format import machine_in
from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import NoSolutionError
from frictool.observe.design.friction_map import friction_at
from frictool.observe.design.tracking import bandwidth_of, design_tracking, gains, spread
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverRun
from frictool.typing import Vector
from studies.rigs.clutch_fleet import believed, clutch
from tests.observe.plain_tracking import PlainTracking

FROM = Provenance("drawn", "0.1.0")
PERIOD = 1e-3
EMPS = load(Path(__file__).parents[2] / "configs/emps/published.yaml", Model)


def drawn(seed: int) -> Observer:
    """An observer of another cell, bandwidth, backlash, viscous friction and offset than the
    clutch's."""
    draw = np.random.Generator(np.random.PCG64([seed, 91]))
    found = design_tracking(
        clutch(), FROM, float(draw.uniform(50.0, 900.0)), cell=float(draw.choice([0.0, 0.5, 1.0]))
    )
    tracking = found.tracking
    assert tracking is not None
    gap = tracking.backlash if draw.random() < 0.7 else None
    viscous, offset = float(draw.choice([0.0, 4e-4])), float(draw.choice([0.0, 0.01]))
    friction = msgspec.structs.replace(found.friction, viscous=viscous, offset=offset)
    return msgspec.structs.replace(
        found, friction=friction, tracking=msgspec.structs.replace(tracking, backlash=gap)
    )


def moves(seed: int, samples: int) -> tuple[Vector, Vector]:
    """Counted positions (n,) of strokes with rests, and efforts (n,) that push, hold and rest."""
    draw, step = np.random.Generator(np.random.PCG64([seed, 92])), clutch().bench.encoder.resolution
    t = np.arange(samples) * PERIOD
    strokes = 31.5 + 20.0 * np.sin(2.0 * np.pi * float(draw.uniform(1.0, 3.0)) * t)
    resting = np.floor(t / 0.15).astype(int) % 2 == 0
    held = np.where(
        resting, strokes[np.maximum.accumulate(np.where(~resting, np.arange(samples), 0))], strokes
    )
    return np.floor(held / step) * step, draw.uniform(-0.4, 0.4, samples) * np.repeat(
        draw.integers(0, 2, samples // 20 + 1), 20
    )[:samples]


def along(observer: Observer, positions: Vector, efforts: Vector) -> Vector:
    """(n, 3) of position, velocity, friction."""
    time: Vector = PERIOD * np.arange(positions.size, dtype=np.float64)
    found = ObserverRun(observer).take(MotionBlock(time, positions, efforts, follows=False))
    return np.column_stack([found.position, found.velocity, found.friction])


def facts_of(observer: Observer) -> PlainTracking:
    assert observer.tracking is not None
    return PlainTracking(tracking_facts(observer, observer.tracking), 0.0)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 9999), st.integers(0, 9999))
def test_the_program_is_the_plain_observer(design: int, seed: int) -> None:
    observer, (positions, efforts) = drawn(design), moves(seed, 500)
    plain = facts_of(observer)
    plain.x = float(positions[0])
    np.testing.assert_allclose(
        along(observer, positions, efforts), plain.run(positions, efforts), rtol=1e-9, atol=1e-9
    )


def test_every_branch_of_the_reference_is_taken() -> None:
    seen: set[str] = set()
    for seed in range(4):
        plain, (positions, efforts) = facts_of(drawn(seed)), moves(seed, 500)
        plain.x = float(positions[0])
        plain.run(positions, efforts)
        seen |= plain.branches
    assert seen == {"carried", "loose", "stays", "stops", "breaks away", "slips"}


@settings(max_examples=20, deadline=None)
@given(st.floats(-0.99, 0.99), st.floats(5.0, 58.0))
def test_an_axis_below_its_breakaway_that_shows_no_count_has_no_speed(
    part: float, place: float
) -> None:
    """Exactly, for as long as it lasts."""
    observer = design_tracking(clutch(), FROM)
    assert observer.tracking is not None
    assert observer.tracking.backlash is not None
    level = observer.tracking.breakaway_ratio * min(observer.tracking.backlash.friction, 0.05)
    found = along(observer, np.full(3000, place), np.full(3000, part * level))
    assert not found[:, 1].any()
    assert not found[:, 2].any()


def test_a_drive_beyond_the_model_s_breakaway_without_a_count_is_held_by_the_disturbance() -> None:
    """A worn axis stands more than the model says: no burst of speed after the first."""
    found = along(design_tracking(clutch(), FROM), np.full(4000, 30.0), np.full(4000, 0.2))
    assert np.max(np.abs(found[:400, 1])) > 1.0
    assert not found[1000:, 1].any()


@settings(max_examples=20, deadline=None)
@given(st.floats(-300.0, 300.0).filter(lambda v: abs(v) > 20.0), st.floats(0.0, 1.0))
def test_a_constant_speed_is_found_within_what_a_count_in_the_observer_s_time_is(
    speed: float, phase: float
) -> None:
    observer, step = design_tracking(clutch(), FROM), clutch().bench.encoder.resolution
    assert observer.tracking is not None
    place = 30.0 + np.cumsum(np.full(400, speed * PERIOD)) * (
        1.0 if abs(speed) * 0.4 < 30.0 else 30.0 / (abs(speed) * 0.4)
    )
    true = (place[1] - place[0]) / PERIOD
    positions = np.floor(place / step + phase) * step
    efforts = np.sign(speed) * friction_at(observer.friction, 1 if speed > 0.0 else -1, place)
    efforts += 3.81e-4 * np.sign(speed) * max(0.0, abs(true) - 260.0)
    found = along(observer, positions, efforts)
    rms = float(np.sqrt(np.mean((found[200:, 1] - true) ** 2)))
    assert rms < 0.3 * step * observer.tracking.bandwidth_rad_s
    assert (
        abs(float(np.mean(found[200:, 1])) - true) < 0.05 * step * observer.tracking.bandwidth_rad_s
    )


def test_a_perfect_encoder_and_the_true_model_leave_no_error() -> None:
    """An axis without backlash that the observer's own equations move; the cell as fine as the
    encoder."""
    encoder = msgspec.structs.replace(
        EMPS.bench.encoder, step=msgspec.structs.replace(EMPS.bench.encoder.step, value=1e-12)
    )
    model = msgspec.structs.replace(
        EMPS, bench=msgspec.structs.replace(EMPS.bench, encoder=encoder)
    )
    observer = design_tracking(model, FROM, 300.0)
    plain = facts_of(observer)
    efforts, positions, speeds = 200.0 * np.sin(np.arange(2000) * 0.01), [], []
    for effort in efforts:
        positions.append(plain.x)
        speeds.append(plain.v)
        plain.step(plain.x, float(effort))
    found = along(observer, np.array(positions), efforts)
    assert max(map(abs, speeds)) > 0.1
    np.testing.assert_allclose(found[:, 1], speeds, atol=1e-9)


@pytest.mark.parametrize("number", ["float", "q31"])
def test_other_number_formats_find_the_same_speed_but_for_rounding(number: str) -> None:
    observer = design_tracking(clutch(), FROM)
    program, (positions, _) = observer_program(observer).program, moves(3, 500)
    double, other = compile_program(program), machine_in(program, number)
    for one in (double, other):
        start_at(one, float(positions[0]))
    apart = [
        abs(control_step(double, 0.0, float(y), 0.0) - control_step(other, 0.0, float(y), 0.0))
        for y in positions
    ]
    assert max(apart) < {"float": 0.01, "q31": 0.01}[number]


@settings(max_examples=30, deadline=None)
@given(st.floats(1.0, 999.0), st.floats(1e-5, 1e3))
def test_the_error_in_slip_has_three_poles_where_the_bandwidth_says(
    bandwidth: float, inertia: float
) -> None:
    one, two, three = gains(bandwidth, PERIOD, inertia)
    a = np.array(
        [[1.0, PERIOD, 0.5 * PERIOD**2 / inertia], [0.0, 1.0, PERIOD / inertia], [0.0, 0.0, 1.0]]
    )
    corrected = a @ (np.eye(3) - np.outer([one, two, three], [1.0, 0.0, 0.0]))
    pole = math.exp(-bandwidth * PERIOD)
    np.testing.assert_allclose(np.poly(corrected), np.poly([pole] * 3), atol=1e-9)


def test_the_rule_follows_encoder_and_intervals() -> None:
    model, unsure = clutch(), believed()
    assert bandwidth_of(model) < bandwidth_of(unsure)  # a wider inertia
    fine = msgspec.structs.replace(model.bench.encoder, counts_per_revolution=4.0 * 56.0)
    finer = msgspec.structs.replace(model, bench=msgspec.structs.replace(model.bench, encoder=fine))
    assert bandwidth_of(finer) == pytest.approx(2.0 * bandwidth_of(model))
    assert bandwidth_of(EMPS) == pytest.approx(1.0 / PERIOD)  # 50 nm: as fast as the period lets it
    assert bandwidth_of(model, drive_noise=5.0) > bandwidth_of(model)
    part, friction = spread(model)
    assert (part, friction) == pytest.approx((0.21 / 1.32, 0.081))


def test_what_the_model_says_of_knees_backlash_and_breakaway_is_taken_over() -> None:
    tracking = design_tracking(clutch(), FROM).tracking
    assert tracking is not None
    assert [(knee.above.value, knee.steeper) for knee in tracking.knees] == [(260.0, 3.81e-4)]
    assert tracking.backlash is not None
    assert (tracking.backlash.width, tracking.backlash.friction) == (3.0, 0.05)
    assert tracking.breakaway_ratio == pytest.approx(1.1, rel=1e-3)
    plain = design_tracking(EMPS, FROM).tracking
    assert plain is not None
    assert plain.backlash is None
    assert plain.knees == ()


@pytest.mark.parametrize("bandwidth", [0.0, -1.0, 1000.1])
def test_a_bandwidth_that_the_period_cannot_have_is_refused_in_a_line(bandwidth: float) -> None:
    with pytest.raises(NoSolutionError, match="allowed: above 0 and at most 1000 rad/s"):
        design_tracking(clutch(), FROM, bandwidth)


def test_the_document_is_read_as_it_was_written(tmp_path: Path) -> None:
    observer = design_tracking(clutch(), FROM)
    (tmp_path / "observer.yaml").write_text(to_yaml(observer))
    assert load(tmp_path / "observer.yaml", Observer) == observer
