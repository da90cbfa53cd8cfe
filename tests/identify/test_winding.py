"""Resistance, back-EMF constant and inductance of a winding with known values; the mechanics of the
motor do not matter, so that its motion is prescribed."""

from __future__ import annotations

import functools
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from frictool.identify.fit_result import Interval
from frictool.identify.measurement.winding import WindingLog, winding
from frictool.typing import Vector
from studies.command_line import run
from tests.support.voltage_motor import COUNT, Motor, log_signals, steps
from tests.support.voltage_motor import PERIOD as SLOW

PERIOD, SUBSTEPS = 1e-3, 20
STEP = 2.0 * np.pi / 8192  # rad, one count
RESISTANCE, BACK_EMF, INDUCTANCE = 1.6, 0.12, 2e-3  # ohm, V s/rad, H
TRUTH = {"resistance": RESISTANCE, "back_emf_constant": BACK_EMF, "inductance": INDUCTANCE}
BENCH = """\
format: bench/1
name: winding
axis: rotary
sample_period_s: 0.001
encoder: {{counts_per_revolution: 8192}}
actuator:
  drive: {drive}
  constant: {{value: {constant}, unit: N m/{unit}}}
  limit: {{value: 24, unit: {unit}}}
mechanics:
  inertia: {{value: 2.2e-3, low: 1.0e-3, high: 4.0e-3, unit: kg m^2}}
  viscous: {{value: 3.0e-3, low: 0, high: 5.0e-2, unit: N m s/rad}}
  coulomb: {{value: 0.04, low: 0.005, high: 0.2, unit: N m}}
columns:
  time: {{column: time, unit: s}}
  position: {{column: position, unit: count}}
  voltage: {{column: voltage, unit: V}}
  current: {{column: current, unit: A}}
"""


@functools.cache
def signals(seed: int, turning: float = 1.0, drop: float = 0.0) -> tuple[Vector, Vector, Vector]:
    """Counted position, held voltage and noisy current (n,) of 6 s, each about the same share of
    the voltage for resistance and back-EMF; the driver takes up to `drop` [V]."""
    draw = np.random.default_rng([seed, 77])
    samples = 6000
    size, rate, phase = draw.uniform(2.0, 6.0, 3), draw.uniform(3.0, 12.0, 3), draw.uniform(0, 6, 3)
    held = np.repeat(draw.uniform(-4.0, 4.0, samples // 40), 40)
    fine = (np.arange(samples * SUBSTEPS) + 0.5) * PERIOD / SUBSTEPS
    speed = turning * (size * np.sin(np.outer(fine, rate) + phase)).sum(axis=1)
    time = np.arange(samples) * PERIOD
    position = turning * (-size / rate * np.cos(np.outer(time, rate) + phase)).sum(axis=1)
    decay = float(np.exp(-RESISTANCE / INDUCTANCE * PERIOD / SUBSTEPS))
    acting = np.sign(held) * np.maximum(np.abs(held) - drop, 0.0)
    final = (np.repeat(acting, SUBSTEPS) - BACK_EMF * speed) / RESISTANCE
    after = lfilter([1.0 - decay], [1.0, -decay], final)
    current = np.concatenate([[0.0], after[SUBSTEPS - 1 : -1 : SUBSTEPS]])
    counts = np.floor(position * 8192 / (2.0 * np.pi) + draw.uniform())
    return counts, held, current + 0.02 * draw.standard_normal(samples)


def measured(
    folder: Path,
    rows: tuple[Vector, Vector, Vector],
    drive: str = "voltage",
    constant: float = 0.0,
    options: tuple[str, ...] = ("--measurement",),
) -> tuple[dict, str]:
    """Identify with these options; return the measurement and what was printed on stderr."""
    log = folder / "log.csv"
    time = np.arange(rows[0].size) * PERIOD
    lines = zip(time, *rows, strict=True)
    log.write_text(
        "time,position,voltage,current\n"
        + "".join(f"{t:.3f},{x:.0f},{u:.6f},{i:.6f}\n" for t, x, u, i in lines)
    )
    usual = BACK_EMF if drive == "current" else BACK_EMF / RESISTANCE
    bench = folder / "bench.yaml"
    unit = "A" if drive == "current" else "V"
    bench.write_text(BENCH.format(drive=drive, constant=constant or usual, unit=unit))
    given = ("--bench", bench, "-o", folder / "model.yaml", *options)
    result = run("identify", log, *given, "--keep-bench-values", "--json")
    assert result.code == 0, result.stderr
    return json.loads(result.stdout)["measurement"], result.stderr


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[dict, str]]:
    """The measurement and the text on stderr by drive, with a bench that has the true constant."""
    folder = tmp_path_factory.mktemp("usual")
    return {drive: measured(folder, signals(1), drive) for drive in ("voltage", "current")}


@pytest.mark.parametrize("drive", ["voltage", "current"])
def test_the_winding_comes_back(usual: dict[str, tuple[dict, str]], drive: str) -> None:
    """Resistance, back-EMF constant and inductance lie in intervals below half of their values."""
    found, _ = usual[drive]
    for name, true in TRUTH.items():
        one = found[name]
        assert one["low"] <= true <= one["high"], name
        assert one["high"] - one["low"] < 0.5 * true, name
    assert [found[name]["unit"] for name in TRUTH] == ["ohm", "N m/A", "H"]


@pytest.mark.parametrize(
    ("records", "least"), [(3, 2), pytest.param(20, 16, marks=pytest.mark.accept)]
)
def test_the_intervals_cover(records: int, least: int) -> None:
    """At 95 %, fewer hits than `least` have a probability of 0.7 or 0.3 %."""
    hits = dict.fromkeys(TRUTH, 0)
    for seed in range(records):
        counts, voltage, current = signals(seed)
        piece = np.zeros(counts.size)
        log = WindingLog(voltage, current, counts * STEP, piece, PERIOD, 31, 0.3 * STEP)
        found = winding([log], 0.95)
        for name, true in TRUTH.items():
            one = found[name]
            assert isinstance(one, Interval)
            hits[name] += one.low <= true <= one.high
    assert min(hits.values()) >= least, hits


def test_the_drop_of_the_driver_is_no_resistance() -> None:
    """Without the drop, the resistance would be a third too large."""
    counts, voltage, current = signals(0, drop=1.0)
    log = WindingLog(voltage, current, counts * STEP, 0.0 * counts, PERIOD, 31, 0.3 * STEP)
    found = winding([log], 0.95)
    for name, true in {**TRUTH, "voltage_drop": 1.0}.items():
        one = found[name]
        assert isinstance(one, Interval)
        assert one.low <= true <= one.high, name
    log = replace(log, current=signals(0)[2])
    assert "voltage_drop" not in winding([log], 0.95)


def test_a_motor_at_rest_has_no_back_emf(tmp_path: Path) -> None:
    """The resistance of a blocked motor comes back; the back-EMF constant is refused."""
    found, _ = measured(tmp_path, signals(2, turning=1e-5))
    assert found["resistance"]["low"] <= RESISTANCE <= found["resistance"]["high"]
    assert "back_emf_constant" not in found
    assert "did not move" in found["refused"]["back_emf_constant"]


@pytest.mark.parametrize("drive", ["voltage", "current"])
def test_a_wrong_constant_of_the_bench_is_named(
    tmp_path: Path, usual: dict[str, tuple[dict, str]], drive: str
) -> None:
    """A constant that is 1.3 times too large scales inertia and every friction alike. A drop of the
    driver does not change the ratio K/R, but the friction of a voltage drive contains it."""
    true = BACK_EMF if drive == "current" else BACK_EMF / RESISTANCE
    stderr = measured(tmp_path, signals(1, drop=1.0), drive, constant=1.3 * true)[1]
    assert stderr.count("contradicts the log's back-EMF constant") == 1
    assert "actuator.constant" not in usual[drive][1]
    told = [one for one in stderr.splitlines() if "driver and brushes" in one]
    assert len(told) == (drive == "voltage")
    assert "driver and brushes" not in usual[drive][1]
    if told:
        effort, drop = (float(one) for one in re.findall(r"\d+\.?\d*", told[0])[:2])
        assert drop == pytest.approx(1.0, rel=0.01)
        assert effort == pytest.approx(1.3 * true * drop, rel=0.01)
        assert len(told[0].removeprefix("warning: ")) <= 190


SPEC = """\
format: spec/1
name: winding
axis: rotary
drive: voltage
modulus_margin: 0.4
"""
DESIGN = """\
format: design/1
name: winding
axis: rotary
structure: position
method: pole-placement
"""


MEASURE = ("--measurement",)


@pytest.mark.parametrize(
    ("voltage", "current"),
    [((), MEASURE), *(pytest.param(one, one, marks=pytest.mark.accept) for one in ((), MEASURE))],
)
def test_synth_names_a_winding_that_the_model_lacks(
    tmp_path: Path, voltage: tuple[str, ...], current: tuple[str, ...]
) -> None:
    """The entry that synth suggests is L/R within its interval; with this entry, and for a current
    drive, whose loop sets the current, synth does not warn."""
    (tmp_path / "spec.yaml").write_text(SPEC)
    (tmp_path / "design.yaml").write_text(DESIGN)

    model = tmp_path / "model.yaml"

    def identified(drive: str, options: tuple[str, ...]) -> str:
        measured(tmp_path, signals(1), drive, options=options)
        text = model.read_text()
        assert ("inductance" in text) == (drive == "voltage" or bool(options))
        return text

    def warnings(text: str, entry: str = "") -> list[str]:
        model.write_text(text.replace("    limit:", f"{entry}    limit:", 1))
        given = ("--spec", tmp_path / "spec.yaml", "--design", tmp_path / "design.yaml")
        stderr = run("synth", model, *given, "--vertices-only", "--no-play").stderr
        return [one for one in stderr.splitlines() if "winding" in one and "L/R" in one]

    text = identified("voltage", voltage)
    (warning,) = warnings(text)
    entry = warning.split("write loop_time_constant_s: ")[1].split()[0]
    assert float(entry) == pytest.approx(INDUCTANCE / RESISTANCE, rel=0.2)
    assert len(warning.removeprefix(f"warning: {tmp_path}")) <= 190
    assert not warnings(text, f"    loop_time_constant_s: {entry}\n")
    assert warnings(text, "    loop_time_constant_s: 1.0e-5\n")
    assert not warnings(identified("current", current))


def test_a_voltage_of_another_motor_is_refused(tmp_path: Path) -> None:
    """The reason names the share of the voltage that is left."""
    counts, _, current = signals(1)
    found, _ = measured(tmp_path, (counts, signals(5)[1], current))
    assert "% of the voltage" in found["refused"]["resistance"]


@pytest.mark.parametrize(
    ("late", "records", "least"),
    [(0.6, 2, 1), *(pytest.param(late, 6, 5, marks=pytest.mark.accept) for late in (0.0, 0.6))],
)
def test_a_free_motor_gives_its_winding(late: float, records: int, least: int) -> None:
    """The speed changes within a period, by K^2 T/(2 J R) of the current's voltage, which is 3 % of
    the resistance. The voltage acts at an unknown time after its row."""
    motor = Motor(late=late)
    truth = (motor.resistance, motor.constant, motor.inductance)
    hits = np.zeros(3)
    for seed in range(records):
        one = log_signals(motor, steps(seed, 6000), seed)
        log = WindingLog(
            one["voltage"], one["current"], one["position"], np.zeros(6000), SLOW, 15, 0.3 * COUNT
        )
        for k, found in enumerate(winding([log], 0.95).values()):
            assert isinstance(found, Interval)
            assert found.value == pytest.approx(truth[k], rel=0.01 if k < 2 else 0.15)
            hits[k] += found.low <= truth[k] <= found.high
    assert np.all(hits >= least), hits
