"""Tests of `excite --for`: the convex program, the limits, the promise and the refusals."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Bench
from frictool.documents.promise import Promise
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.errors import NoSolutionError
from frictool.identify.excite.bench_limits import check_reference, limits_of
from frictool.identify.excite.cramer_rao import (
    SLIDING,
    PlannedStroke,
    PriorAxis,
    SensorPrecision,
    information,
)
from frictool.identify.excite.precise_ramps import FEWEST_ONSETS, _onsets, precise_ramps
from frictool.identify.excite.precise_strokes import (
    QUANTILE,
    PrecisionRequest,
    precise_strokes,
    stroke_program,
)
from frictool.identify.excite.stroke_candidates import (
    EFFECTS,
    stroke_candidates,
    worst_axis,
    worst_sensing,
)
from frictool.identify.excite.stroke_design import (
    FEWEST_PAIRS,
    StrokeProgram,
    best_within,
    shortest,
)
from frictool.identify.excite.stroke_profile import unit_profile
from frictool.lmi.optimal_design import optimal_shares
from studies.command_line import CommandResult, run
from studies.rigs.identification_rigs import CLUTCH, EMPS, clutch
from tests.support.command_line import refused

WANTED = {"inertia": 0.002, "coulomb": 0.01}


def test_profile_starts_and_ends_at_rest_and_its_derivatives_agree() -> None:
    share = np.linspace(0.0, 1.0, 20_001)
    advance, speed, acceleration = unit_profile(share)
    assert advance[0] == 0.0
    assert advance[-1] == pytest.approx(1.0)
    assert abs(speed[[0, -1]]).max() < 1e-12
    np.testing.assert_allclose(np.gradient(advance, share)[1:-1], speed[1:-1], atol=1e-3)
    inside = np.abs(np.gradient(acceleration, share)) < 100.0
    np.testing.assert_allclose(np.gradient(speed, share)[inside], acceleration[inside], atol=5e-3)


def test_optimal_shares_of_a_known_design() -> None:
    # a line over [-1, 1]: half of the time at either end is optimal for both of its parameters
    places = np.linspace(-1.0, 1.0, 9)
    rows = np.column_stack((np.ones_like(places), places))
    rate = rows[:, :, None] * rows[:, None, :]
    shares = optimal_shares(rate, np.array([1.0, 1.0]), np.full(places.size, -math.inf))
    assert shares is not None
    np.testing.assert_allclose(shares[[0, -1]], 0.5, atol=1e-4)
    # with a mean cost of at most 0 the ends may take only half of the time
    cost = np.where(np.abs(places) == 1.0, 1.0, -1.0)
    limited = optimal_shares(rate, np.array([1.0, 1.0]), cost)
    assert limited is not None
    assert float(limited @ cost) <= 1e-6
    assert optimal_shares(rate[:1], np.array([1.0, 1.0]), cost[:1]) is None


@pytest.mark.parametrize("path", [CLUTCH, EMPS])
def test_whole_repetitions_meet_the_limits_and_none_is_superfluous(path: Path) -> None:
    bench = load(path, Bench)
    candidates = stroke_candidates(bench, None)
    program = stroke_program(bench, PrecisionRequest(WANTED), candidates)
    times = shortest(program)
    assert times is not None
    assert np.array_equal(times, np.rint(times))
    assert program.worst(times) <= 1.0
    axis = worst_axis(bench, EFFECTS)
    total = sum(
        (
            count * information([one.stroke], axis, worst_sensing(bench, None))
            for one, count in zip(candidates, times[:-1], strict=True)
            if count
        ),
        np.zeros((6, 6)),
    )
    deviation = np.sqrt(np.diag(np.linalg.inv(total)))
    for name in WANTED:
        row = SLIDING.index(name)
        assert deviation[row] ** 2 <= program.limit[row] * (1.0 + 1e-6)
    if times.sum() > FEWEST_PAIRS:
        for one in np.flatnonzero(times):
            fewer = times.copy()
            fewer[one] -= 1.0
            assert program.worst(fewer) > 1.0


def test_the_optimal_test_is_not_longer_than_one_kind_of_stroke() -> None:
    bench = clutch()
    request = PrecisionRequest(WANTED, robust=False)
    program = stroke_program(bench, request, stroke_candidates(bench, None, request.effects))
    times = shortest(program)
    assert times is not None
    single = np.array([program.worst(row) for row in np.eye(program.duration.size)])
    repetitions = np.maximum(np.ceil(single), FEWEST_PAIRS)
    alone = float(np.min(repetitions * program.duration))
    assert float(times @ program.duration) <= alone * (1.0 + 1e-9)


AXIS = PriorAxis(0.5, 2.0, 1.0)
SENSING = SensorPrecision(period=1e-3, step=1e-5, noise=0.01)
SHORT, LONG = PlannedStroke(1.0, 0.1), PlannedStroke(1.0, 0.5)


def test_information_of_strokes_adds_up_and_contains_that_without_effects() -> None:
    axis = replace(AXIS, effects=EFFECTS)
    mixed = information([replace(SHORT, times=3.0), LONG], axis, SENSING)
    parts = 3.0 * information([SHORT], axis, SENSING) + information([LONG], axis, SENSING)
    np.testing.assert_allclose(mixed, parts, rtol=1e-9, atol=1e-9 * np.abs(parts).max())
    plain = information([replace(SHORT, times=3.0), LONG], AXIS, SENSING)
    np.testing.assert_allclose(mixed[:4, :4], plain)
    with_effects = np.diag(np.linalg.inv(mixed))[:4]
    assert np.all(with_effects >= np.diag(np.linalg.inv(plain)) * (1.0 - 1e-9))


@pytest.mark.parametrize(
    ("effect", "twin"), [("spring", "inertia"), ("delay", "viscous"), ("delay", "inertia")]
)
def test_only_strokes_of_two_lengths_separate_an_effect_from_its_twin(
    effect: str, twin: str
) -> None:
    """Along a half sine, a is -(pi/D)^2 x, and du/dt is J (pi/D)^2 v less than B a."""
    axis = replace(AXIS, effects=(effect,))
    row = SLIDING.index(twin)
    limit = np.full(5, math.inf)
    limit[row] = 1.0
    candidates = np.array([information([one], axis, SENSING) for one in (SHORT, LONG)])
    durations = np.array([SHORT.duration, LONG.duration])
    program = StrokeProgram(candidates, durations, np.ones(2), limit)
    assert program.variances(np.array([8.0, 0.0]))[row] == math.inf
    assert program.variances(np.array([0.0, 8.0]))[row] == math.inf
    assert math.isfinite(program.variances(np.array([4.0, 4.0]))[row])


@pytest.mark.parametrize("path", [CLUTCH, EMPS])
def test_no_pair_of_strokes_is_more_precise_than_the_robust_mix(path: Path) -> None:
    bench = load(path, Bench)
    program = stroke_program(bench, PrecisionRequest(WANTED), stroke_candidates(bench, None))
    rate = program.information / program.duration[:, None, None]
    shares = optimal_shares(rate, program.limit, np.full(len(rate), -math.inf))
    assert shares is not None
    least = program.worst(shares / shares.sum() / program.duration)
    pairs = np.random.default_rng(8).integers(0, len(rate) - 1, (60, 2))
    for pair in pairs:
        mix = np.zeros(len(rate))
        np.add.at(mix, pair, 0.5)
        assert program.worst(mix / program.duration) >= least * (1.0 - 1e-4)


def test_a_robust_target_lies_between_the_request_and_the_highest_precision() -> None:
    request = PrecisionRequest({"inertia": 0.01, "coulomb": 0.04, "breakaway": 0.001})
    assert request.targets == pytest.approx({"inertia": 0.01, "coulomb": 0.02})
    plain = replace(request, robust=False)
    assert plain.targets == {"inertia": 0.01, "coulomb": 0.04}
    assert plain.effects == ()


def test_best_test_of_a_duration_uses_it_and_improves_with_it() -> None:
    bench = clutch()
    program = stroke_program(bench, PrecisionRequest(WANTED), stroke_candidates(bench, None))
    short, long = best_within(program, 5.0), best_within(program, 20.0)
    assert short is not None
    assert long is not None
    assert float(short @ program.duration) <= 5.0
    assert 15.0 <= float(long @ program.duration) <= 20.0
    assert program.worst(long) < 0.5 * program.worst(short)
    assert best_within(program, 0.01) is None


def test_rms_limit_adds_pauses() -> None:
    bench = clutch()
    free = precise_strokes(bench, PrecisionRequest(WANTED, robust=False))
    share = 0.5 * free.sequence.figures["largest_drive_rms_share"]
    limit = Quantity(share * bench.actuator.limit.value, unit="A")
    actuator = msgspec.structs.replace(bench.actuator, rms_limit=limit)
    cool = precise_strokes(
        msgspec.structs.replace(bench, actuator=actuator), PrecisionRequest(WANTED, robust=False)
    )
    assert cool.sequence.figures["largest_drive_rms_share"] <= share * (1.0 + 1e-9)
    assert cool.sequence.duration > free.sequence.duration
    assert cool.half_widths["inertia"] <= WANTED["inertia"] * bench.mechanics.inertia.value


@pytest.mark.parametrize("path", [CLUTCH, EMPS])
def test_strokes_are_within_the_limits_and_promise_what_is_wanted(path: Path) -> None:
    bench = load(path, Bench)
    request = PrecisionRequest(WANTED, robust=False)
    test = precise_strokes(bench, request)
    columns = test.sequence.columns
    check_reference(
        limits_of(bench),
        columns["reference"],
        columns["reference_velocity"],
        columns["reference_acceleration"],
    )
    for name, part in WANTED.items():
        assert 0.0 < test.bounds[name] <= test.half_widths[name]
        assert test.half_widths[name] <= part * getattr(bench.mechanics, name).value * (1 + 1e-9)
    again = precise_strokes(bench, request)
    assert np.array_equal(again.sequence.columns["reference"], columns["reference"])


def test_every_axis_of_the_intervals_gives_more_information_than_the_worst() -> None:
    bench = clutch()
    strokes = [one.stroke for one in stroke_candidates(bench, None)[::7]]
    worst = worst_axis(bench)
    sensing = worst_sensing(bench, None)
    known = bench.mechanics
    nominal_axis = replace(worst, inertia=known.inertia.value, viscous=known.viscous.value)
    nominal = information(strokes, nominal_axis, sensing)
    least = information(strokes, worst, sensing)
    scale = 1.0 / np.sqrt(np.diag(nominal))
    assert np.linalg.eigvalsh((nominal - least) * np.outer(scale, scale)).min() > -1e-9


def test_ramps_of_a_precision() -> None:
    bench = clutch()
    coarse = precise_ramps(bench, PrecisionRequest({"breakaway": 0.1}))
    fine = precise_ramps(bench, PrecisionRequest({"breakaway": 0.003}))
    assert fine.half_widths["breakaway"] <= 0.003 * 1.1 * 0.099 * (1.0 + 1e-9)
    assert fine.bounds["breakaway"] > 0.0
    assert fine.sequence.duration > coarse.sequence.duration
    with pytest.raises(NoSolutionError, match=r"time: breakaway=0\.3% needs ramps of"):
        precise_ramps(bench, PrecisionRequest({"breakaway": 0.003}, longest=10.0))
    with pytest.raises(NoSolutionError, match=r"resolution: the range of mechanics\.inertia"):
        precise_ramps(bench, PrecisionRequest({"breakaway": 1e-4}))


@pytest.mark.usefixtures("no_rehearsals")
def test_command_writes_test_ramps_and_promise(tmp_path: Path) -> None:
    test, ramps, promise = (tmp_path / name for name in ("test.mcap", "ramps.mcap", "promise.yaml"))
    shown = json.loads(
        run(
            *("excite", "--bench", CLUTCH, "--for", "coulomb=5%", "--for", "inertia=2%"),
            *(
                "--for",
                "breakaway=8%",
                "-o",
                test,
                "--ramps",
                ramps,
                "--promise",
                promise,
                "--json",
            ),
        ).stdout
    )
    document = load(promise, Promise)
    assert document.half_widths.inertia is not None
    assert document.half_widths.breakaway is not None
    assert document.half_widths.inertia.value == pytest.approx(shown["figures"]["promised_inertia"])
    assert shown["ramps"]["figures"]["promised_breakaway"] == pytest.approx(
        document.half_widths.breakaway.value
    )
    assert test.exists()
    assert ramps.exists()
    assert document.bounds.inertia is not None
    assert document.bounds.inertia.value < document.half_widths.inertia.value
    assert QUANTILE > 1.9


@pytest.mark.usefixtures("no_rehearsals")
def test_refusals_name_limit_and_remedy(tmp_path: Path) -> None:
    out = tmp_path / "test.mcap"

    def excite(*options: object) -> CommandResult:
        return run("excite", "--bench", CLUTCH, *options, "-o", out)

    impossible = excite("--for", "inertia=0.005%")
    refused(impossible, 4, "time: inertia=0.005% needs a test of", "allowed: at most 3600 s")
    assert "counts a revolution" in impossible.stderr
    assert not out.exists()
    assert excite().code == 2
    both = excite("--for", "inertia=5%", "--for", "breakaway=5%")
    assert both.code == 2
    assert "with --ramps FILE" in both.stderr
    short = excite("--for", "inertia=0.1%", "--duration", "5")
    assert short.code == 1
    assert "a test of 5 s is not precise enough: inertia" in short.stderr


@pytest.mark.parametrize("limit", [0.3, 0.5, 1.0, 1.001, 1.5, 3.0])
def test_the_fewest_ramps_whose_mean_is_precise_enough(limit: float) -> None:
    """n onsets average their scatter, and not the error that they have in common."""
    single, common = 4.0, 1.0

    def deviation(onsets: float) -> float:
        return math.sqrt(common**2 + (single**2 - common**2) / onsets)

    onsets = _onsets(single, common, limit)
    if limit <= common:
        assert onsets == math.inf
        return
    assert onsets % 2.0 == 0.0
    assert deviation(onsets) <= limit
    assert onsets == FEWEST_ONSETS or deviation(onsets - 2.0) > limit


def test_the_shortest_test_mixes_strokes_up_to_the_heating_of_the_drive() -> None:
    """Mean squares 0.5, 0.2 and 0 of strokes with information 1, 0.6 and 0 each second.

    A sixth of the first and five sixths of the second give the most information at 0.25: 0.667.
    """
    program = StrokeProgram(
        np.array([1.0, 0.6, 0.0])[:, None, None],
        np.ones(3),
        np.array([0.5, 0.2, 0.0]),
        np.array([1.0 / 400.0]),
        rms=0.5,
    )
    times = shortest(program)
    assert times is not None
    assert program.allowed(times)
    assert program.worst(times) <= 1.0
    assert 600.0 <= times @ program.duration <= 601.0
