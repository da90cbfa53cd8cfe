"""The velocity along logs of spread clutches: beside (5.70) at its best, in whatever pieces, from
nothing that comes later, covered."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, lfilter, sosfiltfilt

from frictool.errors import NoSolutionError
from frictool.observe.design.error_gains import error_gains
from frictool.observe.design.tracking import gains
from frictool.observe.motion_block import MotionBlock
from frictool.observe.velocity import VelocityEstimator
from frictool.observe.velocity_errors import ORDER, VelocityErrors
from frictool.typing import Matrix
from studies.rigs.clutch_fleet import (
    Loop,
    Run,
    Unit,
    believed,
    clutch,
    run,
    spread,
    steps,
    targets,
    with_encoder,
)

PERIOD = 1e-3
SECONDS = 6.0


@functools.cache
def log_of(seed: int, loop: Loop) -> Run:
    """Some seconds of a clutch that is spread, worn, and believed to be 20 % lighter."""
    reference = steps(SECONDS) if seed % 2 == 0 else targets(seed, SECONDS)
    return run(spread(seed, wear=1.0 + 0.25 * (seed % 3)), reference, seed, loop)


def cut(piece: MotionBlock, ends: list[int]) -> Iterator[MotionBlock]:
    for low, high in pairwise([0, *ends, piece.time.size]):
        part = slice(low, high)
        velocity = None if piece.velocity is None else piece.velocity[part]
        yield MotionBlock(
            piece.time[part], piece.position[part], piece.effort[part], low > 0, velocity
        )


def taken(pieces: Iterator[MotionBlock], **given: Any) -> tuple[Matrix, dict[str, Any]]:
    """(3, n) and the figures."""
    estimator = VelocityEstimator(believed(), **given)
    found = np.concatenate([estimator.take(piece) for piece in pieces], axis=1)
    return found, estimator.figures()


@pytest.mark.parametrize("loop", ["speed", "linear"])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_it_is_twice_as_near_as_the_low_pass_that_is_best_for_the_log(
    seed: int, loop: Loop
) -> None:
    """With the inertia, the friction and the gap off, and noise on the drive."""
    log = log_of(seed, loop)
    found, figures = taken(iter(log.pieces))
    assert figures["velocity_rms_true"] < 0.5 * figures["velocity_rms_filter_true"]
    assert figures["velocity_rms"] < 0.5 * figures["velocity_rms_filter"]
    assert figures["velocity_rms_true"] == pytest.approx(
        float(np.sqrt(np.mean((found[0] - log.velocity) ** 2))), rel=1e-9
    )


def test_the_intervals_cover_the_true_velocity() -> None:
    """95 % are asked for; moving and at rest, over all of these plants."""
    covered, moving, wider = [], [], []
    for seed in range(4):
        for loop in ("speed", "linear"):
            log = log_of(seed, loop)
            found, _ = taken(iter(log.pieces))
            inside = (found[1] <= log.velocity) & (log.velocity <= found[2])
            covered.append(inside.mean())
            moving.append(inside[log.velocity != 0.0].mean())
            wider.append(np.mean(found[2, log.velocity != 0.0] - found[1, log.velocity != 0.0]))
    assert 0.93 <= np.mean(covered) <= 0.995
    assert np.mean(moving) >= 0.93
    assert max(wider) < 40.0  # rad/s; a count in one sample is 112


@pytest.mark.parametrize("inertia", [0.9, 1.0])
@pytest.mark.parametrize("noise", [0.0, 0.5])
@pytest.mark.parametrize("counts", [256.0, 4096.0, 1e5])
def test_the_intervals_cover_whatever_encoder_and_drive_noise(
    counts: float, noise: float, inertia: float
) -> None:
    """The noise is nowhere stated: how far the positions miss the predicted ones shows it. No
    interval is wider than a count needs."""
    model, unit = with_encoder(clutch(), counts), Unit(inertia=inertia, counts=counts)
    inside, wide, off = [], [], []
    for seed, loop in ((0, "speed"), (1, "linear")):
        log = run(unit, steps(SECONDS) if seed == 0 else targets(seed, SECONDS), seed, loop, noise)
        estimator = VelocityEstimator(model)
        found = np.concatenate([estimator.take(piece) for piece in log.pieces], axis=1)
        moving = log.velocity != 0.0
        inside.append(((found[1] <= log.velocity) & (log.velocity <= found[2]))[moving].mean())
        wide.append(0.5 * np.mean((found[2] - found[1])[moving]))
        off.append(np.sqrt(np.mean((found[0] - log.velocity)[moving] ** 2)))
    assert 0.93 <= np.mean(inside) <= 0.995
    assert np.mean(wide) < 3.5 * np.mean(off)


def test_the_gains_of_the_error_are_those_of_a_simulated_error() -> None:
    """White rounding and white acceleration through the observer's linear error, one sample after
    another."""
    period, inertia, draw = 1e-3, 2e-5, np.random.default_rng(4)
    for bandwidth in (50.0, 400.0, 1000.0):
        one, two, three = gains(bandwidth, period, inertia)
        found = error_gains((one, two, three), inertia, period)
        for rounding in (True, False):
            x = v = d = 0.0
            misses, velocities = [], []
            for noise in draw.normal(0.0, 1.0, 60_000):
                miss = (noise if rounding else 0.0) - x
                misses.append(miss)
                x, v, d = x + one * miss, v + two * miss, d + three * miss
                velocities.append(v)
                acceleration = d / inertia + (0.0 if rounding else noise)
                x, v = x + period * v + 0.5 * period**2 * acceleration, v + period * acceleration
            ratio = np.std(velocities) if rounding else np.std(velocities) / np.std(misses)
            assert ratio == pytest.approx(found.rounding if rounding else found.misfit, rel=0.05)


def test_an_observer_whose_error_grows_is_refused() -> None:
    with pytest.raises(NoSolutionError, match="does not decay"):
        error_gains((0.1, 5000.0, 0.0), 2e-5, 1e-3)


@settings(max_examples=10, deadline=None)
@given(st.lists(st.integers(1, 2999), min_size=1, max_size=6, unique=True))
def test_pieces_of_a_log_are_the_log(ends: list[int]) -> None:
    whole = next(cut(log_of(0, "linear").pieces[0], [3000]))
    one, figures = taken(iter([whole]))
    other, others = taken(cut(whole, sorted(ends)))
    assert np.array_equal(one, other)
    assert figures == pytest.approx(others, rel=1e-9)


@settings(max_examples=10, deadline=None)
@given(st.integers(100, 2000), st.integers(0, 99))
def test_nothing_that_comes_later_changes_what_was_found(sample: int, seed: int) -> None:
    piece = next(cut(log_of(0, "speed").pieces[0], [2500]))
    draw = np.random.Generator(np.random.PCG64([seed, 93]))
    later = np.arange(piece.time.size) > sample
    effort = piece.effort + later * draw.normal(0.0, 0.3, later.size)
    position = piece.position + later * draw.normal(0.0, 3.0, later.size)
    one, _ = taken(iter([piece]))
    other, _ = taken(iter([replace(piece, effort=effort, position=position)]))
    assert np.array_equal(one[:, : sample + 1], other[:, : sample + 1])
    assert not np.array_equal(one, other)


def test_over_a_gap_it_begins_at_rest_where_the_log_goes_on() -> None:
    first, second = cut(log_of(1, "speed").pieces[0], [2100])
    alone, _ = taken(iter([replace(second, follows=False)]))
    estimator = VelocityEstimator(believed())
    estimator.take(first)
    assert np.array_equal(estimator.take(replace(second, follows=False)), alone)


def test_another_confidence_is_another_width_of_the_same_velocity() -> None:
    piece = log_of(0, "speed").pieces[0]
    narrow, _ = taken(iter([piece]), confidence=0.5)
    wide, _ = taken(iter([piece]), confidence=0.95)
    assert np.array_equal(narrow[0], wide[0])
    moving = narrow[0] != 0.0
    ratio = (wide[2] - wide[0])[moving] / (narrow[2] - narrow[0])[moving]
    assert ratio == pytest.approx(1.959964 / 0.6744898, rel=1e-6)


def test_the_figures_are_those_of_the_whole_log_at_once() -> None:
    """Blocks with what the filter remembers beside them against scipy over everything, and the bank
    against lfilter."""
    log, step = log_of(0, "linear"), 5
    position, velocity = (
        np.tile(log.pieces[0].position, 4),
        np.tile(log.velocity, 4),
    )  # longer than a block
    estimate = velocity + 1.0
    figures = VelocityErrors(40.0, PERIOD)
    for low in range(0, position.size, position.size // step):
        part = slice(low, low + position.size // step)
        figures.take(position[part], estimate[part], velocity[part], low > 0)
    found = figures.figures()
    reference = sosfiltfilt(
        butter(ORDER, 40.0, fs=1.0 / PERIOD, output="sos"),
        np.gradient(position, PERIOD),
        padlen=figures.overlap,
    )
    assert found["velocity_rms"] == pytest.approx(
        float(np.sqrt(np.mean((estimate - reference) ** 2))), rel=1e-6
    )
    assert found["velocity_rms_true"] == pytest.approx(1.0)
    x = 2.0 * math.pi * found["filter_cutoff_hz"] * PERIOD
    shown = np.diff(position, prepend=position[0]) / PERIOD
    for _ in range(found["filter_order"]):
        shown = lfilter([x / (2.0 + x), x / (2.0 + x)], [1.0, -(2.0 - x) / (2.0 + x)], shown)
    assert found["velocity_rms_filter"] == pytest.approx(
        float(np.sqrt(np.mean((shown - reference) ** 2))), rel=1e-6
    )


def test_a_log_too_short_to_compare_has_no_figures() -> None:
    estimator = VelocityEstimator(believed())
    estimator.take(MotionBlock(PERIOD * np.arange(4.0), np.zeros(4), np.zeros(4), follows=False))
    assert estimator.figures()["velocity_rms"] is None


def test_a_drive_without_a_lag_is_held_from_its_sample_on() -> None:
    """The same efforts are then another motion: half a sample is not taken off a drive that
    jumps."""
    model = believed()
    actuator = msgspec.structs.replace(model.bench.actuator, loop_time_constant_s=0.0)
    held = msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, actuator=actuator)
    )
    piece = log_of(0, "speed").pieces[0]
    mean = VelocityEstimator(model).take(replace(piece, effort=piece.effort))
    shifted = 0.5 * (piece.effort + np.append(piece.effort[1:], piece.effort[-1]))
    assert np.array_equal(VelocityEstimator(held).take(replace(piece, effort=shifted))[0], mean[0])


@pytest.mark.parametrize("period", [1e-4, 1e-3, 0.1, 10.0])
def test_searched_cutoffs_begin_far_below_the_sample_rate(period: float) -> None:
    searched = VelocityErrors(0.1 / period, period).tried
    assert searched[0] <= 0.01 / period
    assert np.all(np.diff(searched) > 0.0)
    assert searched[-1] == pytest.approx(1.0 / (math.pi * period))
