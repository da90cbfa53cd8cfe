"""Backlash, delay and the current loop's lag from logs: what was put in lies in the interval, or
the reason says why there is none."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.measurement.loop_lag import loop_lag
from frictool.identify.measurement.reversals import reversals
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.axis import AxisParameters
from frictool.typing import Vector
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH, clutch, record
from studies.rigs.sample_logs import PERIOD, TRUTH, Recording, sines
from tests.support.identification_statistics import FINE_STEP


def currents(
    lag: float, seed: int, samples: int = 6000, noise: float = 0.1
) -> tuple[Vector, Vector]:
    """A commanded current of steps and its measured current, which follows with a lag."""
    generator = np.random.default_rng([seed, 41])
    command = np.repeat(generator.uniform(-20.0, 20.0, samples // 50 + 1), 50)[:samples]
    kept = np.exp(-PERIOD / lag)
    before = np.concatenate((command[:1], command[:-1]))
    measured, _ = lfilter([1.0 - kept], [1.0, -kept], before, zi=[kept * command[0]])
    return command, 0.97 * measured + 0.05 + noise * generator.standard_normal(samples)


def fast_strokes(seed: int, truth: AxisParameters) -> Recording:
    """Return the last 12 s of half sines, which are the fastest."""
    return Recording(*(column[-12_000:] for column in sines(seed, truth)))


@settings(max_examples=25, deadline=None)
@given(st.floats(1e-3, 5e-2), st.integers(0, 10_000))
def test_the_loops_lag_comes_back(lag: float, seed: int) -> None:
    """99.99 %: twenty-five draws do not miss by chance."""
    found = loop_lag(*currents(lag, seed), PERIOD, 0.9999)
    assert found.low <= lag <= found.high
    assert found.half_width < 0.1 * lag


@pytest.mark.parametrize(
    ("records", "least"), [(20, 15), pytest.param(60, 51, marks=pytest.mark.accept)]
)
def test_the_interval_of_the_lag_covers(records: int, least: int) -> None:
    """At 95 %, fewer hits than `least` have a probability of 0.03 or 0.1 %."""
    hits = [
        interval.low <= 0.003 <= interval.high
        for interval in (loop_lag(*currents(0.003, seed), PERIOD, 0.95) for seed in range(records))
    ]
    assert sum(hits) >= least


def test_what_does_not_tell_a_lag_is_refused() -> None:
    command, measured = currents(0.003, 1)
    with pytest.raises(UnusableLogs, match="are identical"):
        loop_lag(command, command, PERIOD, 0.95)
    with pytest.raises(UnusableLogs, match="does not change"):
        loop_lag(np.ones(6000), measured, PERIOD, 0.95)
    with pytest.raises(UnusableLogs, match=r"leaves .* of the current unexplained"):
        loop_lag(command, np.random.default_rng(1).standard_normal(6000), PERIOD, 0.95)
    with pytest.raises(UnusableLogs, match="lag of the current loop is too short"):
        loop_lag(
            command,
            np.append(command[0], command[:-1])
            + 0.1 * np.random.default_rng(2).standard_normal(6000),
            PERIOD,
            0.95,
        )


@pytest.mark.parametrize(
    ("width", "delay", "seed"),
    [
        (2.5, 1.6e-3, 1),
        *(
            pytest.param(*one, marks=pytest.mark.accept)
            for one in ((1.0, 0.0, 0), (4.0, -2e-3, 2), (1.5, 2e-3, 3))
        ),
    ],
)
def test_backlash_and_delay_come_back(width: float, delay: float, seed: int) -> None:
    """Encoder of 4096 points; the drive is logged `delay` late."""
    truth = TRUTH._replace(encoder_step=FINE_STEP, backlash=width)
    log = record(fast_strokes(seed, truth), truth)
    gap, late = reversals(
        [replace(log, effort=np.interp(log.time - delay, log.time, log.effort))], clutch(), 0.999
    )
    assert isinstance(late, Interval)
    assert isinstance(gap, Interval)
    assert late.low <= delay <= late.high
    assert gap.low <= width <= gap.high
    assert late.half_width < 1e-3
    assert gap.half_width < 0.3


def test_no_backlash_is_said_and_a_coarse_encoder_does_not_tell_a_small_width() -> None:
    tight = TRUTH._replace(encoder_step=FINE_STEP, backlash=0.0)
    gap, late = reversals([record(fast_strokes(1, tight), tight)], clutch(), 0.95)
    hidden = re.search(r"not rise after reversals; a backlash of up to (\S+) rad", str(gap))
    assert hidden is not None
    assert 0.0 < float(hidden[1]) < 1.0  # the narrowest width of the test above
    assert isinstance(late, Interval)
    assert late.low <= 0.0 <= late.high
    small = TRUTH._replace(backlash=0.3)
    assert isinstance(reversals([record(sines(0, small), small)], clutch(), 0.95)[0], UnusableLogs)


@pytest.mark.parametrize(
    ("backlash", "seed"),
    [
        (3.0, 0),
        (1.0, 1),
        (2.0, 8),  # missed by 20 % if the width changed by speed times delay only
        *(pytest.param(*one, marks=pytest.mark.accept) for one in ((2.0, 1), (2.0, 2), (1.0, 2))),
    ],
)
def test_a_coarse_encoder_gives_no_wrong_width(backlash: float, seed: int) -> None:
    """56 counts per revolution: a backlash of 1 rad is 9 counts."""
    truth = TRUTH._replace(backlash=backlash)
    width = reversals([record(fast_strokes(seed, truth), truth)], clutch(), 0.95)[0]
    if isinstance(width, Interval):
        assert width.low <= backlash <= width.high
    else:
        assert backlash < 2.5


@pytest.mark.accept
@pytest.mark.parametrize("backlash", [2.0, 3.0])
def test_the_interval_of_the_backlash_covers(backlash: float) -> None:
    """At 95 %, less than 80 % of at least 20 intervals has a probability below 0.4 %."""
    truth = TRUTH._replace(backlash=backlash)
    widths = [
        reversals([record(fast_strokes(seed, truth), truth)], clutch(), 0.95)[0]
        for seed in range(100, 130)
    ]
    intervals = [width for width in widths if isinstance(width, Interval)]
    assert len(intervals) >= 20
    held = sum(interval.low <= backlash <= interval.high for interval in intervals)
    assert held >= 0.8 * len(intervals)


def spring_of_throttle(position: Vector) -> Vector:
    """Effort [N m] of a preloaded return spring, 0.05 to 0.35 N m over the travel of 63 rad."""
    return 0.05 + 0.3 * position / 63.0


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.accept) for k in (1, 2))])
def test_a_return_spring_is_no_backlash(seed: int) -> None:
    """The drive also holds the spring along the same motion."""
    tight = TRUTH._replace(encoder_step=FINE_STEP, backlash=0.0)
    log = record(fast_strokes(seed, tight), tight)
    gap, late = reversals(
        [replace(log, effort=log.effort + spring_of_throttle(log.position))], clutch(), 0.95
    )
    assert "friction does not rise after reversals" in str(gap)
    assert isinstance(late, Interval)
    assert abs(late.value) < 1e-3


@pytest.mark.parametrize("seed", [0, *(pytest.param(k, marks=pytest.mark.accept) for k in (1, 2))])
def test_a_backlash_is_measured_under_a_return_spring(seed: int) -> None:
    truth = TRUTH._replace(encoder_step=FINE_STEP, backlash=2.0)
    log = record(fast_strokes(seed, truth), truth)
    gap = reversals(
        [replace(log, effort=log.effort + spring_of_throttle(log.position))], clutch(), 0.999
    )[0]
    assert isinstance(gap, Interval)
    assert gap.low <= 2.0 <= gap.high
    assert gap.half_width < 0.3


@pytest.mark.parametrize(
    ("shape", "distance", "strokes_of"),
    [
        ("presliding", 1.0, fast_strokes),
        ("elastic", 4.0, fast_strokes),
        *(
            pytest.param(*one, sines, marks=pytest.mark.accept)
            for one in (("presliding", 4.0), ("elastic", 1.0))
        ),
    ],
)
def test_a_gradual_rise_is_no_backlash(
    shape: str, distance: float, strokes_of: Callable[[int, AxisParameters], Recording]
) -> None:
    """After a reversal, friction rises from -C to C over some distance: exponentially with
    presliding (Dahl), linearly while a soft shaft winds up. Half of the friction rises so."""
    tight = TRUTH._replace(encoder_step=FINE_STEP, backlash=0.0)
    log = record(strokes_of(0, tight), tight)
    strokes = find_strokes(log)
    left = (
        np.exp(-strokes.advance / distance)
        if shape == "presliding"
        else np.clip(1.0 - strokes.advance / distance, 0.0, 1.0)
    )
    effort = log.effort - TRUTH.coulomb * strokes.sign * left
    gap = reversals([replace(log, effort=effort)], clutch(), 0.95)[0]
    assert "elastic drive train" in str(gap)


def test_the_command_measures_the_bench(tmp_path: Path) -> None:
    bench, log, target = tmp_path / "bench.yaml", tmp_path / "log.csv", tmp_path / "model.yaml"
    text = CLUTCH.read_text().replace("counts_per_revolution: 56 ", "counts_per_revolution: 4096 ")
    bench.write_text(text.rstrip("\n") + "\n  current_command: {column: command, unit: A}\n")
    truth = TRUTH._replace(encoder_step=FINE_STEP)
    made = fast_strokes(3, truth)
    command = currents(truth.lag, 3, made.time.size)[0]
    rows = [
        f"{t:.3f},{n},{i:.6f},{c:.6f}"
        for t, n, i, c in zip(made.time, made.encoder, made.current, command, strict=True)
    ]
    log.write_text("\n".join(["time [s],encoder [count],current [A],command [A]", *rows, ""]))
    result = run(
        "identify",
        log,
        "--bench",
        bench,
        "--method",
        "least-squares",
        "--measurement",
        "-o",
        target,
        "--json",
    )
    assert result.code == 0, result.stderr
    model = load(target, Model)
    assert model.measurement is not None
    assert model.measurement.backlash is not None
    assert (
        model.measurement.backlash.interval[0]
        <= TRUTH.backlash
        <= model.measurement.backlash.interval[1]
    )
    assert (
        "leaves" in model.measurement.refused["loop_time_constant"]
    )  # this command is not that of this current
    assert json.loads(result.stdout)["measurement"]["delay"]["unit"] == "s"
    plain = run("identify", log, "--bench", bench, "--method", "least-squares", "--measurement")
    assert "measured: backlash" in plain.stdout
    assert "not measured: loop_time_constant" in plain.stdout
