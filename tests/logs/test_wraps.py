"""Positions that wrap: unwrapped where the bench says so, in any unit; refused with the line that
mends it where it does not."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from frictool.documents.bench import Column, Encoder
from frictool.documents.quantity import Quantity
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.channels.unwrapping import PeriodicSignal
from frictool.logs.log import Log, Stream
from frictool.logs.quality.wrap_detection import TURN, Wrap, WrapSearch
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.example_logs import as_bytes, bench, measured

PERIOD = 0.001
TIME = np.arange(6000) * PERIOD
TRUE = 7.0 * np.sin(TIME / 0.9) + 0.4 * np.sin(TIME / 0.05) + 1.0  # rad: over two turns, both ways
COUNTS = 4096


def shown(true: np.ndarray, period: float, low: float) -> np.ndarray:
    """Return the reading of a sensor that wraps into [low, low + period)."""
    return np.mod(true - low, period) + low


def written(
    folder: Path, unit: str, encoder: Encoder, columns: dict[str, np.ndarray], axis: str = "rotary"
) -> list[str | Path]:
    """A log and its bench as the arguments of a command."""
    units = {"position": unit, "reference": unit, "current": "A"}
    mapped = {name: Column(name, units[name]) for name in columns}
    header = ",".join(["time", *columns])
    rows = [
        ",".join([f"{k * PERIOD:.3f}", *(repr(float(value)) for value in row)])
        for k, row in enumerate(zip(*columns.values(), strict=True))
    ]
    log, rig = folder / "log.csv", folder / "bench.yaml"
    log.write_text("\n".join([header, *rows]) + "\n")
    rig.write_text(to_yaml(bench({"time": Column("time", "s"), **mapped}, encoder, axis=axis)))
    return [log, "--bench", rig]


def with_key(text: str, key: str) -> str:
    """A bench's text with a further key of the encoder, which is written on one line or below."""
    return re.sub(
        r"encoder:( \{|\n  )",
        lambda match: f"encoder:{match[1]}{key}{', ' if '{' in match[1] else match[1]}",
        text,
    )


ROTARY = [
    ("rad", TURN, 0.0, 1.0, "wrap: {value: 1, unit: turn}"),
    ("rad", TURN, -TURN / 2, 1.0, "wrap: {value: 1, unit: turn}"),
    ("deg", TURN, 0.0, 180 / np.pi, "wrap: {value: 360, unit: deg}"),
    ("deg", TURN, -TURN / 2, 180 / np.pi, "wrap: {value: 360, unit: deg}"),
    ("deg", TURN / 2, -TURN / 4, 180 / np.pi, "wrap: {value: 180, unit: deg}"),
    ("turn", 2 * TURN, 0.0, 1 / TURN, "wrap: {value: 2, unit: turn}"),
    ("rad", TURN / COUNTS * 256, 0.0, 1.0, "wrap: {value: 0.0625, unit: turn}"),
    ("count", TURN, 0.0, COUNTS / TURN, "wrap_bits: 12"),
]


@pytest.mark.parametrize(("unit", "period", "low", "scale", "line"), ROTARY)
def test_a_wrapped_position_is_refused_until_the_bench_says_so(
    unit: str, period: float, low: float, scale: float, line: str, tmp_path: Path
):
    true = TRUE if period > 1.0 else 0.05 * TRUE
    columns = {
        "position": shown(true, period, low) * scale,
        "reference": shown(true + 0.01, period, low) * scale,
    }
    columns = {
        name: np.floor(values) if unit == "count" else values for name, values in columns.items()
    }
    given = written(tmp_path, unit, Encoder(counts_per_revolution=COUNTS), columns)
    target = tmp_path / "log.mcap"
    refused(
        run("ingest", *given, "-o", target),
        3,
        "log.csv: column 'position': the position wraps",
        f"under encoder in bench.yaml: {line}\n",
    )
    assert not target.exists()
    rig = tmp_path / "bench.yaml"
    rig.write_text(with_key(rig.read_text(), line))
    assert run("ingest", *given, "-o", target).code == 0
    signals = read_mcap(target).main.signals
    turns = (signals["position"] - true) / period
    assert np.abs(turns - np.rint(turns[0])).max() < 0.01
    assert np.abs(signals["reference"] - signals["position"] - 0.01).max() < 1.1 * TURN / COUNTS


def test_a_linear_counter_that_a_drive_has_scaled(tmp_path: Path):
    step = 1e-5
    columns = {"position": shown(0.9 * TRUE, step * 2**16, 0.0), "current": TRUE}
    given = written(tmp_path, "m", Encoder(step=Quantity(step, unit="m")), columns, "linear")
    rig = tmp_path / "bench.yaml"
    rig.write_text(
        rig.read_text().replace("N m s/rad", "N s/m").replace("N m", "N").replace("kg m^2", "kg")
    )
    refused(run("info", *given), 3, "wrap: {value: 0.65536, unit: m}")
    for line in ("wrap: {value: 655.36, unit: mm}", "wrap_bits: 16"):
        text = rig.read_text()
        rig.write_text(with_key(text, line))
        assert run("info", *given).code == 0
        rig.write_text(text)


def test_a_period_that_is_not_the_sensors_is_refused(tmp_path: Path):
    """Half of it contradicts the range of the numbers; twice of it leaves the wraps in."""
    given = written(
        tmp_path,
        "deg",
        Encoder(counts_per_revolution=COUNTS),
        {"position": np.degrees(shown(TRUE, TURN, 0.0))},
    )
    rig = tmp_path / "bench.yaml"
    text = rig.read_text()
    for wrong, words in (
        ("{value: 180, unit: deg}", "allowed: values within the period encoder.wrap of"),
        ("{value: 2, unit: turn}", "360, unit: deg"),
    ):
        rig.write_text(with_key(text, f"wrap: {wrong}"))
        refused(run("ingest", *given, "-o", tmp_path / "log.mcap"), 3, "column 'position'", words)


@pytest.mark.parametrize(
    "keys",
    [
        "wrap: {value: 1, unit: turn}, wrap_bits: 12",
        "wrap: {value: 0.001, unit: rad}",
        "wrap: {value: 1, unit: m}",
    ],
)
def test_a_wrap_that_no_encoder_has_is_refused(keys: str, tmp_path: Path):
    given = written(tmp_path, "rad", Encoder(counts_per_revolution=COUNTS), {"position": TRUE})
    rig = tmp_path / "bench.yaml"
    rig.write_text(with_key(rig.read_text(), keys))
    refused(run("info", *given), 3, "bench.yaml", "encoder", "wrap")


def test_a_canonical_log_that_wraps_is_no_log_to_identify(tmp_path: Path):
    path, rig = tmp_path / "log.mcap", tmp_path / "bench.yaml"
    signals = {"position": shown(TRUE, TURN, 0.0), "current": np.cos(TIME / 0.9)}
    path.write_bytes(
        as_bytes(Log((Stream("/axis", TIME, signals, {"position": "rad", "current": "A"}),)))
    )
    rig.write_text(
        to_yaml(
            bench({"position": Column("position", "rad")}, Encoder(counts_per_revolution=COUNTS))
        )
    )
    refused(
        run("identify", path, "--bench", rig),
        3,
        "the position wraps",
        "wrap: {value: 1, unit: turn}, and ingest the raw log again",
    )


@pytest.mark.parametrize("speed", ["0.9", "1.5"])
def test_a_measured_joint_that_wraps_once(speed: str, tmp_path: Path):
    """The first row of these records is no measurement: it holds an infinite force."""
    record = measured(f"field/kinova/velocity_{speed}00000readings.csv")
    log, rig = tmp_path / "log.csv", tmp_path / "bench.yaml"
    log.write_text(record.read_text().partition("\n")[2])
    one = bench(
        {"position": Column(2, "rad"), "current": Column(6, "A")},
        Encoder(counts_per_revolution=1e6),
    )
    rig.write_text(to_yaml(one))
    refused(
        run("info", log, "--bench", rig),
        3,
        "the position wraps once",
        "wrap: {value: 1, unit: turn}",
    )
    rig.write_text(
        to_yaml(
            msgspec.structs.replace(
                one, encoder=Encoder(counts_per_revolution=1e6, wrap=Quantity(TURN, unit="rad"))
            )
        )
    )
    assert run("ingest", log, "--bench", rig, "-o", tmp_path / "log.mcap").code == 0
    position = read_mcap(tmp_path / "log.mcap").main.signals["position"]
    assert np.ptp(position) == pytest.approx(float(speed) * position.size * PERIOD, rel=0.02)
    assert np.abs(np.diff(position)).max() < 0.01


def found(position: np.ndarray, cuts: list[int] | None = None) -> Wrap | None:
    wraps = WrapSearch(bench({}, Encoder(counts_per_revolution=COUNTS)))
    time = np.arange(position.size) * PERIOD
    for block in np.split(np.arange(position.size), sorted(cuts or [])):
        wraps.take(time[block], position[block])
    wraps.finish()
    return wraps.result()


@given(cuts=st.lists(st.integers(0, TIME.size), max_size=6), low=st.floats(-10.0, 10.0))
@example(
    cuts=[], low=1.03125
)  # the first wrap is the third sample's, before which there is one step only
def test_it_does_not_matter_where_blocks_end(cuts: list[int], low: float):
    seen = shown(TRUE, TURN, low)
    wrap = found(seen, cuts)
    assert wrap is not None
    assert wrap.period == TURN
    assert wrap == found(seen)
    one, whole = PeriodicSignal(TURN), PeriodicSignal(TURN).follow(seen)
    assert np.array_equal(
        np.concatenate([one.follow(block) for block in np.split(seen, sorted(cuts))]), whole
    )
    assert np.abs(whole - whole[0] - TRUE + TRUE[0]).max() < 1e-9


@given(
    seed=st.integers(0, 10_000),
    amplitude=st.floats(0.1, 30.0),
    glitches=st.integers(0, 40),
    noise=st.floats(0.0, 0.05),
    kind=st.sampled_from(["sine", "triangle", "steps"]),
)
def test_motion_steps_and_glitches_are_no_wraps(
    seed: int, amplitude: float, glitches: int, noise: float, kind: str
):
    """Steps of a slow log, dropouts to zero and single wild samples, over ranges of any length."""
    rng = np.random.default_rng(seed)
    phase = rng.uniform(3.0, 200.0) * TIME + rng.uniform(0.0, TURN)
    shape = {
        "sine": np.sin(phase),
        "triangle": np.arcsin(np.sin(phase)),
        "steps": np.sign(np.sin(phase)),
    }
    position = amplitude * shape[kind] + rng.normal(0.0, noise, TIME.size)
    places = rng.integers(0, TIME.size, glitches)
    position[places] = np.where(
        rng.integers(0, 2, glitches), 0.0, rng.uniform(-40.0, 40.0, glitches)
    )
    assert found(position) is None


@pytest.mark.parametrize("amplitude", [20.0, 100.0, 1000.0])
def test_a_fast_axis_that_was_unwrapped_before(amplitude: float):
    """Steps of more than half a turn between two samples, over many turns."""
    assert found(amplitude * np.sin(TIME / 0.05)) is None


TURNING = (
    1.9 * TURN * np.sin(TIME / 0.9) + 0.1 * np.sin(TIME / 0.05) + 0.2
)  # rad, over almost four turns
QUANTUM = TURN / COUNTS
# unit, period of the sensor in the unit, lowest number, true position in the unit, advice
ANY_PERIOD = [
    (
        "rad",
        25.0,
        -12.5,
        4.0 * TURNING,
        "wrap: {value: 25, unit: rad}",
    ),  # as drivers of the MIT protocol show it
    ("rad", 8.0, -4.0, TURNING, "wrap: {value: 8, unit: rad}"),
    ("deg", 360.0, 0.0, np.degrees(TURNING), "wrap: {value: 360, unit: deg}"),
    ("deg", 100.0, 0.0, np.degrees(TURNING), "wrap: {value: 100, unit: deg}"),
    ("turn", 1.0, 0.0, TURNING / TURN, "wrap: {value: 1, unit: turn}"),
    ("count", 65536.0, 0.0, 40.0 * TURNING / QUANTUM, "wrap_bits: 16"),
    ("count", 4096.0, -2048.0, TURNING / QUANTUM, "wrap_bits: 12"),
    ("count", 3000.0, 0.0, TURNING / QUANTUM, "wrap: {value: 4.60194236366, unit: rad}"),
    ("rad", 25.0, -12.5, 12.5 + 2.0 * (TIME - 3.0), "wrap: {value: 25, unit: rad}"),  # once
    (
        "rad",
        25.0,
        -12.5,
        25.0 * np.cumsum(0.3 + 0.05 * np.sin(5.0 * TIME)),
        "wrap: {value: 25, unit: rad}",
    ),  # three samples a period
]


@pytest.mark.parametrize(("unit", "period", "low", "true", "line"), ANY_PERIOD)
def test_any_period_is_refused_with_a_line_that_repairs_the_log(
    unit: str, period: float, low: float, true: np.ndarray, line: str, tmp_path: Path
) -> None:
    true = np.floor(true) if unit == "count" else true
    given = written(
        tmp_path,
        unit,
        Encoder(counts_per_revolution=COUNTS),
        {"position": shown(true, period, low)},
    )
    target, rig = tmp_path / "log.mcap", tmp_path / "bench.yaml"
    refused(
        run("ingest", *given, "-o", target),
        3,
        "column 'position': the position wraps",
        f"in bench.yaml: {line}\n",
    )
    rig.write_text(with_key(rig.read_text(), line))
    assert run("ingest", *given, "-o", target).code == 0
    si = {"rad": 1.0, "deg": np.pi / 180.0, "turn": TURN, "count": QUANTUM}[unit]
    position = read_mcap(target).main.signals["position"]
    assert np.allclose(np.diff(position), np.diff(true) * si, rtol=0.0, atol=1e-7 * period)


def jumps_that_are_no_wraps() -> list[np.ndarray]:
    """Positions in rad: steps, a sensor at its stop, single wild samples, dropouts, lost counts,
    and an axis that is set to 0."""
    rng = np.random.default_rng(3)
    motion, wild = 2.0 * np.sin(TIME / 0.3), []
    wild += [
        level * np.sign(np.sin(TIME / 0.2)) + rng.normal(0.0, 1e-3, TIME.size)
        for level in (0.3, 1.7, 4.0, 12.5)
    ]
    wild += [np.clip(level * motion, -level, level) for level in (0.2, 1.0, 6.25)]
    for value in (0.0, -12.5, 12.5, 25.0, TURN):
        for length in (1, 4):
            position = motion.copy()
            for place in (700, 2100, 2103, 4444):
                position[place : place + length] = value
            wild.append(position)
    for lost in (0.7, TURN, 8.0):
        position = motion.copy()
        for place in (900, 2500, 4000):
            position[place:] += lost
        wild.append(position)
    zeroed = motion.copy()
    zeroed[3100:] -= zeroed[3100]
    return [*wild, zeroed, np.full(TIME.size, 0.4), 1e-3 * rng.normal(size=TIME.size)]


@pytest.mark.parametrize("position", jumps_that_are_no_wraps())
def test_a_jump_that_is_no_wrap_is_not_refused(position: np.ndarray, tmp_path: Path) -> None:
    given = written(tmp_path, "rad", Encoder(counts_per_revolution=COUNTS), {"position": position})
    result = run("info", *given)
    assert result.code == 0, result.stderr
    assert "encoder in bench.yaml" not in result.stderr


def test_a_return_that_the_drive_can_make_in_one_sample_is_no_wrap(tmp_path: Path) -> None:
    """The same numbers at 1 kHz and at 2 Hz: 100 N m move 1 kg m2 by 3 rad in half a second."""
    sawtooth = np.mod(0.37 * np.arange(200.0), 3.0)
    for period, code in ((PERIOD, 3), (0.5, 0)):
        given = written(
            tmp_path, "rad", Encoder(counts_per_revolution=COUNTS), {"position": sawtooth}
        )
        given[0].write_text("position\n" + "\n".join(map(repr, map(float, sawtooth))) + "\n")
        rig = tmp_path / "bench.yaml"
        rig.write_text(
            to_yaml(
                bench(
                    {"position": Column("position", "rad")},
                    Encoder(counts_per_revolution=COUNTS),
                    period,
                )
            )
        )
        assert run("info", *given).code == code


@pytest.mark.parametrize("amplitude", [0.4, 3.0])
def test_one_turn_that_is_lost_is_not_called_a_counter(amplitude: float, tmp_path: Path) -> None:
    """The lattice of the numbers makes one turn 2^13 counts, and the range of the position is wider
    than a turn."""
    position = amplitude * TRUE
    position[3000:] += TURN
    position = np.floor(position * 8192 / TURN) * TURN / 8192
    result = run(
        "info",
        *written(tmp_path, "rad", Encoder(counts_per_revolution=8192), {"position": position}),
    )
    assert result.code == 0
    assert "the position jumps once, at 3 s" in result.stdout
    assert "wrap_bits" not in result.stdout + result.stderr


def test_a_jump_that_may_be_a_wrap_is_a_warning_with_the_line(tmp_path: Path) -> None:
    """Once, from 5.3 rad to 0 while the axis moves on: a period of 5.3 rad, or an axis that was set
    to 0."""
    position = np.mod(2.0 + 0.9 * TIME, 5.3)
    result = run(
        "info",
        *written(tmp_path, "rad", Encoder(counts_per_revolution=COUNTS), {"position": position}),
    )
    assert result.code == 0
    assert "the position jumps once, at" in result.stderr
    assert (
        "if the sensor wraps, write under encoder in bench.yaml: wrap: {value: 5.3, unit: rad}"
        in result.stderr
    )


@pytest.mark.parametrize("low", [0.0, -0.5 * TURN])
@pytest.mark.parametrize("kind", ["creeps", "turns", "rests"])
@pytest.mark.parametrize("seed", range(6))
def test_a_wrap_is_found_where_noise_hides_the_motion(low: float, kind: str, seed: int) -> None:
    """The axis creeps across the end of a turn, turns just beyond it, or rests there."""
    draw = np.random.default_rng([seed, 13])
    noise, slow = 10.0 ** draw.uniform(-3.0, -2.0), 10.0 ** draw.uniform(-2.5, -1.5)
    over = noise * draw.uniform(0.0, 2.0)
    true = {
        "creeps": slow * (TIME - 3.0),
        "turns": draw.uniform(0.1, 2.0) * (np.cos(3.0 * TIME) - 1.0) + over,
        "rests": np.minimum(0.2 * (TIME - 3.0), 0.0) + over - noise,
    }[kind]
    step = TURN / COUNTS
    noisy = true + noise * draw.standard_normal(TIME.size)
    position = np.floor((np.mod(noisy, TURN) + low) / step) * step
    wrap = found(position)
    assert wrap is not None
    assert wrap.line == "wrap: {value: 1, unit: turn}"


def test_a_switch_between_two_positions_is_no_wrap() -> None:
    """A drive that moves the axis by one turn between two samples needs no wrap."""
    draw = np.random.default_rng(13)
    slow = np.arange(200) * 0.5
    position = TURN * (draw.random(slow.size) < 0.5) + 0.003 * draw.standard_normal(slow.size)
    search = WrapSearch(bench({}, Encoder(counts_per_revolution=COUNTS)))
    search.take(slow, position)
    search.finish()
    assert search.result() is None
