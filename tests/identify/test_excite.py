"""Tests that `excite` writes: within every limit of the bench, what theory says of them, and what
the ramps give when they are played."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import structs

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.engine.axis_motion import advance
from frictool.errors import NoSolutionError
from frictool.identify.breakaway.breakaway import breakaway
from frictool.identify.breakaway.onset_detection import is_ramp
from frictool.identify.excite.bench_limits import BenchLimits, axis_known, limits_of, sensing_of
from frictool.identify.excite.cramer_rao import cramer_rao
from frictool.identify.excite.excitation_kinds import MAKERS, ExcitationSettings, excite
from frictool.identify.excite.excitation_sequence import ExcitationSequence
from frictool.identify.excite.half_sines import TOP_SHARE, reachable_speed
from frictool.identify.excite.multisine import crest, low_crest, schroeder
from frictool.identify.excite.picture import picture
from frictool.identify.excite.sine import best_stroke, condition
from frictool.identify.excite.sines import plan
from frictool.identify.fit_result import Interval
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.logs.log_reader import read_log
from frictool.plant.axis import rest
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH, EMPS, clutch, mass_bench
from studies.rigs.sample_logs import NOISE, TRUTH
from tests.support.command_line import refused

REFERENCES = ("sine", "sines", "speeds", "steps", "multisine")


@given(st.floats(1e-2, 1e3))
def test_condition_is_the_ratio_of_eigenvalues(speed: float) -> None:
    values = np.linalg.eigvalsh(
        [[0.5 * speed**2, 2.0 * speed / math.pi], [2.0 * speed / math.pi, 1.0]]
    )  # (4.29) over k
    assert condition(speed) == pytest.approx(values[1] / values[0], rel=1e-6)
    assert condition(speed) >= condition(math.sqrt(2.0)) - 1e-9
    assert round(condition(math.sqrt(2.0))) == 19
    assert condition(1e4) == pytest.approx(2.7e8, rel=0.05)  # 4.2.5.4


@given(st.floats(0.01, 10.0), st.floats(0.01, 10.0), st.floats(0.0, 10.0), st.floats(0.0, 0.8))
def test_reachable_speed_takes_all_of_the_effort_or_of_the_speed(
    distance: float, inertia: float, viscous: float, coulomb: float
) -> None:
    limits = BenchLimits(
        "linear", 0.0, distance, 3.0, 1.0, inertia, viscous, coulomb, 0.0, "current", 1.0
    )
    speed = reachable_speed(limits, distance)
    angle = np.linspace(0.0, math.pi, 20_001)
    needed = (
        inertia * 2.0 * speed**2 / distance * np.cos(angle)
        + viscous * speed * np.sin(angle)
        + coulomb
    )
    assert needed.max() <= TOP_SHARE * limits.effort * (1.0 + 1e-9)
    assert speed == pytest.approx(TOP_SHARE * limits.speed) or needed.max() == pytest.approx(
        TOP_SHARE * limits.effort, rel=1e-6
    )


@settings(max_examples=15)
@given(st.integers(3, 40))  # the phase of two is a shift in time
def test_swapping_lowers_the_crest_factor_of_schroeders_phases(harmonics: int) -> None:
    phases = low_crest(harmonics)
    assert (
        math.sqrt(2.0) - 0.1
        < crest(phases)
        <= crest(schroeder(harmonics))
        < crest(np.zeros(harmonics))
    )


@pytest.mark.parametrize("harmonics", [20, 40])
def test_swapping_is_worth_a_tenth_of_the_crest_factor(harmonics: int) -> None:
    """Clipping near the peak lowers it; the best factors published are near 1.4."""
    assert crest(low_crest(harmonics)) < 0.9 * crest(schroeder(harmonics))


def within(sequence: ExcitationSequence, limits: BenchLimits) -> None:
    """Asserts that a reference keeps all limits and that its columns are derivatives of each
    other."""
    x, v, a = sequence.columns.values()
    assert limits.low - 1e-9 <= x.min()
    assert x.max() <= limits.high + 1e-9
    assert np.abs(v).max() <= limits.speed
    assert (
        np.abs(limits.inertia * a + limits.viscous * v + np.sign(v) * limits.coulomb).max()
        <= limits.effort
    )
    step = sequence.period
    assert np.abs((x[2:] - x[:-2]) / (2.0 * step) - v[1:-1]).max() <= 1.01 * step * np.abs(a).max()
    assert abs(v[0]) <= step * np.abs(a).max()  # at rest to a sample


@settings(max_examples=10)
@given(st.floats(0.2, 5.0), st.floats(0.02, 2.0), st.floats(0.0, 0.8), st.integers(0, 5))
def test_references_keep_the_limits_of_any_bench(
    tmp_path_factory: pytest.TempPathFactory,
    inertia: float,
    travel: float,
    friction: float,
    seed: int,
) -> None:
    path = tmp_path_factory.mktemp("bench") / "bench.yaml"
    path.write_text(
        "format: bench/1\nname: any\naxis: linear\nsample_period_s: 0.002\nencoder: {step: "
        "{value: 1e-5, unit: m}}\n"
        "actuator: {drive: voltage, constant: {value: 2, low: 1.8, high: 2.2, unit: N/V}, limit: "
        "{value: 5, unit: V}}\nmechanics:\n"
        f"  inertia: {{value: {inertia}, low: {0.8 * inertia}, high: {1.2 * inertia}, unit: kg}}\n"
        f"  viscous: {{value: 0.5, unit: N s/m}}\n  coulomb: {{value: {8.0 * friction}, unit: N}}\n"
        f"  travel: {{low: -0.1, high: {travel}, unit: m}}\n  top_speed: {{value: 1, unit: "
        f"m/s}}\ncolumns: {{}}\n"
    )
    bench = load(path, Bench)
    for kind in REFERENCES:
        within(
            excite(
                kind,
                bench,
                ExcitationSettings(seed=seed) if kind == "sines" else ExcitationSettings(),
            ),
            limits_of(bench),
        )


@pytest.mark.parametrize("kind", REFERENCES)
def test_references_of_the_rigs(kind: str, tmp_path: Path) -> None:
    for bench in (clutch(), load(EMPS, Bench), mass_bench(tmp_path)):
        within(excite(kind, bench, ExcitationSettings()), limits_of(bench))


def test_sine_has_what_is_asked_for() -> None:
    bench = clutch()
    found = excite("sine", bench, ExcitationSettings(frequency=2.0, speed=200.0, repetitions=3))
    assert found.figures["frequency_hz"] == pytest.approx(2.0)
    assert found.figures["top_speed"] == pytest.approx(200.0, rel=0.01)
    assert found.duration == pytest.approx(1.5, abs=0.01)
    assert np.ptp(found.columns["reference"]) == pytest.approx(200.0 / (2.0 * math.pi), rel=1e-9)
    assert excite("sine", bench, ExcitationSettings(amplitude=10.0, frequency=1.0)).figures[
        "top_speed"
    ] == pytest.approx(20.0 * math.pi, rel=0.01)


def test_the_best_sine_is_the_best() -> None:
    bench, limits = clutch(), limits_of(clutch())
    axis, sensing = axis_known(bench), sensing_of(bench)
    values = np.array([axis.inertia, axis.viscous, axis.coulomb])
    best = best_stroke(limits, axis, sensing, 10.0)

    def worst(distance: float) -> float:
        other = replace(best, speed=reachable_speed(limits, distance), distance=distance)
        return float(
            max(
                cramer_rao([replace(other, times=5.0 / other.duration)], axis, sensing)[:3] / values
            )
        )

    assert (
        worst(best.distance) <= min(worst(distance) for distance in (8.0, 15.0, 30.0, 50.0)) * 1.001
    )


def test_sines_turn_at_other_places_each_time_and_are_what_the_plan_says() -> None:
    bench = clutch()
    one, two = (excite("sines", bench, ExcitationSettings(seed=seed)) for seed in (0, 1))
    assert not np.array_equal(one.columns["reference"][:500], two.columns["reference"][:500])
    x, v, _ = one.columns.values()
    turns = x[np.flatnonzero(np.diff(np.sign(v)))]
    assert np.unique(np.round(turns / bench.encoder.resolution)).size > 20
    planned = sum(2.0 * stroke.times * stroke.duration for stroke in plan(limits_of(bench)))
    assert one.duration == pytest.approx(planned, rel=0.03)


def play(sequence: ExcitationSequence, bench: Bench) -> MotionRecord:
    """Return the record of breakaway ramps, played by their rules on the clutch of the sample
    logs."""
    p, step = TRUTH.as_array(), TRUTH.encoder_step
    command, segment = sequence.columns.values()
    advance_on, limits = sequence.figures["advance_on"], limits_of(bench)
    firsts = {number: int(np.flatnonzero(segment == number)[0]) for number in np.unique(segment)}
    state, k, side = np.asarray(rest(limits.low)), 0, 1.0
    began, position, drive = math.floor(state[0] / step) * step, [], []
    while k < command.size and len(position) < 300_000:
        position.append(math.floor(state[0] / step) * step)
        drive.append(state[2])
        assert advance(state, command[k], p, sequence.period) == 0
        if side > 0.0 and position[-1] > limits.high:
            k, side, began = firsts[-1.0], -1.0, position[-1]
        elif side < 0.0 and position[-1] < limits.low:
            break
        elif abs(position[-1] - began) >= advance_on:
            k, began = firsts.get(segment[k] + side, command.size), position[-1]
        else:
            k += 1
    current = np.array(drive) + NOISE * np.random.default_rng(3).standard_normal(len(drive))
    return make_record(
        "ramps",
        np.arange(len(drive)) * sequence.period,
        np.array(position),
        TRUTH.constant * current,
        step,
        TRUTH.lag,
    )


def test_ramps_played_by_their_rules_give_the_breakaway() -> None:
    bench = clutch()
    sequence = excite("breakaway", bench, ExcitationSettings())
    assert sequence.columns["current"].max() <= bench.actuator.limit.value
    assert {-1.0, 1.0} <= set(sequence.columns["segment"])
    log = play(sequence, bench)
    low, high = limits_of(bench).low, limits_of(bench).high
    assert low - 5.0 < log.position.min()
    assert high < log.position.max() < 63.0
    assert is_ramp(log, bench)
    nominal = bench.mechanics
    axis = {
        name: Interval(getattr(nominal, name).value, *getattr(nominal, name).interval)
        for name in ("inertia", "viscous")
    }
    axis |= {
        "coulomb": Interval(TRUTH.coulomb, TRUTH.coulomb, TRUTH.coulomb),
        "offset": Interval(0.0, 0.0, 0.0),
    }
    found = breakaway([log], bench, axis, 0.95)
    assert found.onsets > 40
    assert found.interval.low <= TRUTH.breakaway <= found.interval.high
    assert found.interval.half_width < 0.05 * TRUTH.breakaway


@pytest.mark.parametrize(
    ("kind", "options", "words"),
    [
        ("sine", ExcitationSettings(amplitude=40.0), ("travel", "3.15 to 59.85")),
        ("sine", ExcitationSettings(speed=500.0), ("speed", "400")),
        (
            "sine",
            ExcitationSettings(frequency=30.0, speed=300.0),
            ("rad/s^2", "allowed: at most 50 (actuator.limit)"),
        ),
        ("multisine", ExcitationSettings(amplitude=20.0, frequency=30.0), ("speed", "400")),
        ("steps", ExcitationSettings(amplitude=40.0), ("travel", "59.85")),
        ("breakaway", ExcitationSettings(amplitude=60.0), ("current", "50 (actuator.limit)")),
        (
            "breakaway",
            ExcitationSettings(amplitude=1.0),
            ("current", "largest breakaway"),
        ),
        (
            "breakaway",
            ExcitationSettings(open_loop=True),
            ("travel: the lightest axis", "leave out --open-loop"),
        ),
        ("sines", ExcitationSettings(duration=1e6), ("duration", "samples")),
    ],
)
def test_refusals_name_the_binding_limit(
    kind: str, options: ExcitationSettings, words: tuple[str, ...]
) -> None:
    with pytest.raises(NoSolutionError) as caught:
        excite(kind, clutch(), options)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    "kind",
    [
        pytest.param(kind, marks=pytest.mark.accept)
        if kind in ("breakaway", "multisine", "speeds")
        else kind
        for kind in MAKERS
    ],
)
def test_csv_and_mcap_hold_the_same_and_twice_the_same_bytes(kind: str, tmp_path: Path) -> None:
    table, log, plot = tmp_path / "test.csv", tmp_path / "test.mcap", tmp_path / "test.svg"
    line = (
        "excite",
        "--bench",
        EMPS,
        "--kind",
        kind,
        *(("--rate", "4") if kind == "breakaway" else ()),
    )
    result = run(*line, "-o", table, "--plot", plot, "--json")
    assert result.code == 0, result.stderr
    assert run(*line, "-o", log).code == 0
    found, facts = read_log(log, None).main, json.loads(result.stdout)
    header, *_ = table.read_text().split("\n", 1)
    columns = np.loadtxt(table, delimiter=",", skiprows=1, unpack=True)
    assert header == ",".join(
        ["time [s]", *(f"{name} [{unit}]" for name, unit in facts["columns"].items())]
    )
    assert np.array_equal(columns[1:], np.array(list(found.signals.values())))
    assert columns[0] == pytest.approx(found.time, abs=1e-9)
    assert plot.read_text().startswith("<svg")
    before = log.read_bytes(), plot.read_bytes()
    run(*line, "-o", log, "--plot", plot)
    assert (log.read_bytes(), plot.read_bytes()) == before


def test_the_command_line(tmp_path: Path) -> None:
    line = ("excite", "--bench", CLUTCH, "--kind", "sine")
    assert run(*line, "-o", tmp_path / "a.txt").code == 2
    assert "belongs to --kind breakaway" in run(*line, "--rate", "3", "-o", "-").stderr
    assert (
        "at most two"
        in run(*line, "--speed", "3", "--amplitude", "1", "--frequency", "1", "-o", "-").stderr
    )
    piped = run(*line, "-o", "-")
    assert piped.stdout.startswith("time [s],reference [rad]")
    assert "to play it" in piped.stderr
    refused(run(*line, "--amplitude", "40", "-o", tmp_path / "x.csv"), 4, "travel")
    assert not (tmp_path / "x.csv").exists()
    assert run("excite", "--help").stdout.index("Example:") < run("excite", "--help").stdout.index(
        "Options:"
    )


def slow_bench(speed: float) -> Bench:
    """Return the clutch's bench with a low top speed [rad/s], whose steps take 200 rad/speed."""
    bench = clutch()
    mechanics = structs.replace(bench.mechanics, top_speed=Quantity(speed, unit="rad/s"))
    return structs.replace(bench, mechanics=mechanics)


def test_a_test_of_more_than_an_hour_is_written_only_if_an_option_chooses_its_length(
    tmp_path: Path,
) -> None:
    rig, out = tmp_path / "bench.yaml", tmp_path / "test.mcap"
    rig.write_text(to_yaml(structs.replace(slow_bench(0.05), sample_period_s=0.01)))
    line = ("excite", "--bench", rig, "--kind", "steps", "-o", out)
    refused(run(*line), 4, "time: the test `steps` takes", "at most 3600 s", "--repetitions")
    assert not out.exists()
    written = run(*line, "--repetitions", "1", "--json")
    facts = json.loads(written.stdout)
    assert written.code == 0
    assert facts["duration_s"] > 3600.0
    head = f"writing a test of {facts['duration_s']:.4g} s, {facts['samples']} rows"
    assert head in written.stderr
    assert read_log(out, None).main.time.size == facts["samples"]


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("steps", ExcitationSettings(repetitions=100_000)),
        ("multisine", ExcitationSettings(frequency=1e-6)),
        ("multisine", ExcitationSettings(repetitions=100_000)),
        ("breakaway", ExcitationSettings(rate=1e-7)),
        ("breakaway", ExcitationSettings(repetitions=100_000)),
    ],
)
def test_a_test_with_too_many_samples_is_refused_before_it_is_computed(
    kind: str, options: ExcitationSettings
) -> None:
    began = perf_counter()
    with pytest.raises(NoSolutionError, match=r"duration: .* samples; allowed: at most 1e\+07"):
        excite(kind, clutch(), options)
    assert perf_counter() - began < 5.0


@pytest.mark.parametrize("names", [("current",), ("position", "speed factor")])
def test_a_picture_has_a_panel_of_every_column_over_one_time(names: tuple[str, ...]) -> None:
    columns = {name: np.sin(np.arange(50) * 0.1 * (k + 1)) for k, name in enumerate(names)}
    units = dict.fromkeys(names, "1") | {names[0]: "A"}
    drawn = picture(ExcitationSequence("sine", 1e-3, columns, units, ""))
    assert drawn == picture(ExcitationSequence("sine", 1e-3, columns, units, ""))
    assert drawn.count("<clipPath") == len(names)
    assert drawn.count("time, s") >= 1


@pytest.mark.parametrize("kind", MAKERS)
def test_the_text_of_a_test_states_the_unit_of_each_figure_that_has_one(
    kind: str, tmp_path: Path
) -> None:
    """Metres on a carriage are radians on a shaft; only pure numbers are without a unit."""
    pure = {"condition", "scale", "condition scaled", "harmonics"}
    lines = run("excite", "--bench", CLUTCH, "--kind", kind, "-o", tmp_path / "test.csv").stdout
    figures = [line[2:].rstrip() for line in lines.splitlines() if line.startswith("  ")]
    assert figures
    for line in figures:
        name, rest = line[:28].strip(), line[28:].split(maxsplit=1)
        assert (len(rest) == 2) == (name not in pure and "crest" not in name), line
        assert len(rest) == 1 or not rest[1].startswith(("m", "kg/", "N s/m"))
