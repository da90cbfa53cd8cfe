"""The criteria on trajectories whose figures are known beforehand."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictool.compare import (
    drift_criterion,
    input_protocol,
    limit_cycle_criterion,
    presliding_criterion,
    stick_slip_criterion,
)
from frictool.compare.thesis_tables import TABLE_2_1, TABLE_3_2, table_differences
from frictool.compare.trajectory import LawTrajectory, Phases, slow_phases


def staircase(
    period: float, first: float, jump: float, slip: float, end: float = 60.0
) -> LawTrajectory:
    """Rests until `first`, then jumps `jump` in `slip` s once a period, at a constant speed."""
    starts = np.arange(first, end, period)
    time = np.arange(0.0, end + 5e-4, 1e-3)
    position, velocity = np.zeros_like(time), np.zeros_like(time)
    for start in starts:
        position += jump * np.clip((time - start) / slip, 0.0, 1.0)
        velocity[(time >= start) & (time < start + slip)] = jump / slip
    edges = [0.0, *(x for start in starts for x in (start, min(start + slip, end))), end]
    sticks = tuple((a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b > a)
    return LawTrajectory(time, position, velocity, np.zeros_like(time), sticks)


@given(st.floats(4.0, 7.0), st.floats(1.0, 8.0), st.floats(0.1, 1.0))
def test_a_staircase_gives_its_own_figures(period: float, first: float, jump: float) -> None:
    run = staircase(period, first, jump, 2.0)
    found = stick_slip_criterion.measure(run, 1e-3)
    assert found.sticks == len(np.arange(first, 60.0, period))
    assert found.first_breakaway_s == pytest.approx(first)
    assert found.period_s == pytest.approx(period)
    assert found.top_speed == pytest.approx(jump / 2.0)
    whole = staircase(period, first, jump, 2.0, first + 5 * period - 1e-9)
    moved = np.diff([whole.at(0.5 * (a + b)) for a, b in whole.sticks]).tolist()
    assert stick_slip_criterion.measure(whole, 1e-3).jump == pytest.approx(float(np.mean(moved)))
    assert moved == pytest.approx([jump] * len(moved))


def test_stick_slip_needs_the_sticks_and_the_period_of_the_reference() -> None:
    found = stick_slip_criterion.measure(staircase(6.5, 7.5, 0.65, 2.0), 1e-3)
    assert found.sticks == 9
    assert found.verdict(found) == found.verdict(replace(found, period_s=6.5 / 1.019)) == "+"
    once = replace(found, sticks=1, period_s=None, jump=None)
    assert (
        found.verdict(replace(found, period_s=6.5 / 1.021))
        == found.verdict(once)
        == once.verdict(found)
        == "-"
    )
    assert once.verdict(once) == "+"
    slow = stick_slip_criterion.measure(staircase(7.5, 7.5, 0.65, 2.0), 1e-3)
    assert slow.sticks == 7
    assert slow.verdict(replace(found, period_s=7.5)) == "-"


def test_a_mass_that_never_sticks_again_has_no_period() -> None:
    time = np.linspace(0.0, 60.0, 601)
    run = LawTrajectory(
        time,
        np.maximum(0.0, 0.1 * (time - 7.5)),
        np.where(time > 7.5, 0.1, 0.0),
        0.0 * time,
        ((0.0, 7.5),),
    )
    found = stick_slip_criterion.measure(run, 1e-3)
    assert (found.sticks, found.period_s, found.jump) == (1, None, None)
    assert found.stuck_share == pytest.approx(76 / 601)


def wave(amplitude: float, period: float, decay: float = 0.0) -> LawTrajectory:
    time = np.linspace(0.0, 300.0, 30001)
    position = 1.0 + amplitude * np.exp(-decay * time) * np.sin(2.0 * math.pi * time / period)
    return LawTrajectory(time, position, np.gradient(position, time), 0.0 * time, ())


@given(st.floats(0.01, 0.1), st.floats(20.0, 30.0))
def test_a_lasting_wave_gives_its_amplitude_and_period(amplitude: float, period: float) -> None:
    found = limit_cycle_criterion.measure(wave(amplitude, period), 1e-5)
    assert found.amplitude == pytest.approx(amplitude, rel=1e-3)
    assert found.period_s == pytest.approx(period, rel=1e-6)
    assert found.lasting == pytest.approx(1.0, rel=1e-3)
    assert found.verdict(found) == found.verdict(replace(found, period_s=period * 1.04)) == "+"
    assert found.verdict(replace(found, period_s=period * 1.06)) == "-"


def test_a_cycle_that_dies_out_has_no_period() -> None:
    found = limit_cycle_criterion.measure(wave(0.06, 24.0, 0.01), 1e-5)
    assert found.lasting < 0.9
    assert found.period_s is None
    assert found.verdict(replace(found, period_s=24.0)) == "-"
    assert found.verdict(found) == "+"  # as the reference, where that dies out too
    still = limit_cycle_criterion.measure(wave(9e-6, 24.0), 1e-5)
    assert (still.period_s, still.lasting) == (None, 0.0)


def loops(force: object, leak: float = 0.0) -> presliding_criterion.PreslidingResult:
    """The figures of a force over the path; `leak` is lost at each turning point."""
    path, turning = input_protocol.presliding_path(1e-5, 100)
    return presliding_criterion.measure(
        path,
        np.vectorize(force)(path / 1e-5) - leak * np.arange(path.size) / 100,
        turning,
        1.5,
        1e-5,
    )


def test_a_spring_complies_without_hysteresis_and_closes() -> None:
    found = loops(lambda z: 1.5 * z)
    assert found.closure == pytest.approx(0.0, abs=1e-12)
    assert found.area == pytest.approx(0.0, abs=1e-12)
    assert found.verdict == "±"
    assert presliding_criterion.RIGID.verdict == "-"


def test_a_masing_loop_has_its_closed_form_area() -> None:
    """A Masing loop of amplitude a on the virgin curve f: 8 int_0^a f - 4 a f(a); with f = 2 z -
    z^2 it is 4 a^3/3."""
    path, turning = input_protocol.presliding_path(1.0, 400)
    force = np.zeros(path.size)
    opened = 0.5 * np.linspace(0.0, 1.4, 401)
    branch = 2.0 * (2.0 * opened - opened**2) - (2.0 * 0.7 - 0.7**2)
    force[2800:3201], force[3200:3601] = -branch, branch  # the legs of the last outer loop
    assert presliding_criterion.measure(path, force, turning, 1.0, 1.0).area == pytest.approx(
        4.0 * 0.7**3 / 3.0, rel=1e-4
    )


def test_a_loop_that_does_not_close_is_told() -> None:
    found = loops(lambda z: 1.5 * z, leak=0.05)
    assert found.closure == pytest.approx(0.1 / 1.5)
    assert found.verdict == "±"


def test_drift_is_counted_over_194_cycles() -> None:
    assert drift_criterion.CYCLES == 194
    time = np.linspace(0.0, 102.0, 10201)
    run = LawTrajectory(time, 1e-6 * time, 1e-6 + 0.0 * time, 0.0 * time, ())
    found = drift_criterion.measure(run, 1e-5, 1.0)
    assert found.displacement == pytest.approx(97e-6)
    assert found.z_max_units == pytest.approx(9.7)
    assert (found.verdict, drift_criterion.DriftResult(9.9e-6, 0.99).verdict) == ("-", "+")


@given(st.lists(st.floats(0.2, 2.0), min_size=2, max_size=8))
def test_slow_phases_are_found_where_they_are(lengths: list[float]) -> None:
    """Speeds alternate between 0 and 1; phases shorter than 0.1 s are no stick."""
    edges = np.cumsum([0.0, *lengths])
    time = np.arange(0.0, edges[-1], 1e-3)
    velocity = (np.searchsorted(edges, time, side="right") - 1) % 2.0
    expected: Phases = tuple((a, b) for a, b in list(pairwise(edges))[::2])
    found = slow_phases(time, velocity, 0.5, 0.1)
    assert np.allclose(found, expected, atol=2e-3)
    assert slow_phases(time, np.cos(2.0 * np.pi * 10.0 * time), 0.5, 0.1) == ()


def test_differences_are_the_cells_that_differ() -> None:
    printed = {
        law: dict(
            zip(
                (*("stick_slip", "limit_cycle", "presliding", "drift"), "parameters"),
                cells,
                strict=True,
            )
        )
        for law, cells in TABLE_3_2.items()
    }
    printed["hybrid_c"]["parameters"] = "12"
    assert table_differences(printed, {}) == []
    printed["elasto_plastic"]["limit_cycle"] = "-"
    (found,) = table_differences(printed, {})
    assert (found.table, found.law, found.row, found.printed, found.computed) == (
        "3.2",
        "elasto_plastic",
        "limit_cycle",
        "+",
        "-",
    )
    printed["hybrid_c"]["parameters"] = "8"
    assert (
        len(table_differences(printed, {"coulomb": {"dynamic": "D"}, "stribeck": {"dynamic": "S"}}))
        == 3
    )
    assert len(TABLE_2_1) == 8
