"""`frictool info`: one row per signal, and what the log is good for, in text and as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import scipy.io

from frictool.logs.log import Log, Stream
from studies.command_line import run
from tests.support.command_line import refused
from tests.support.example_logs import ROOT, as_bytes, golden_log, measured
from tests.support.short_logs import first_part

CLUTCH = ROOT / "configs" / "clutch" / "bench.yaml"
EMPS = ROOT / "configs" / "emps" / "bench.yaml"
UNITS = {"position": "rad", "current": "A", "command": "A"}


def saved(
    folder: Path, metadata: dict[str, dict[str, str]] | None = None, **signals: np.ndarray
) -> Path:
    """A canonical log at 1 kHz."""
    time = np.arange(next(iter(signals.values())).size) * 0.001
    stream = Stream("/axis", time, signals, {name: UNITS[name] for name in signals})
    path = folder / "log.mcap"
    path.write_bytes(as_bytes(Log((stream,), metadata or {})))
    return path


def facts(*arguments: str | Path) -> Any:
    done = run("info", *arguments, "--json")
    assert done.code == 0, done.stderr
    return json.loads(done.stdout)


def test_one_row_per_signal_with_what_the_machine_needs(tmp_path: Path):
    path = tmp_path / "two.mcap"
    path.write_bytes(as_bytes(golden_log()))
    found = facts(path)
    assert [(row["source"], row["name"]) for row in found["channels"]] == [
        ("/axis", "position"),
        ("/axis", "current"),
        ("/axis/force", "effort"),
    ]
    needed = {
        "name",
        "source",
        "unit",
        "samples",
        "rate_hz",
        "jitter_s",
        "gaps",
        "step",
        "held_s",
        "flat_tops",
        "low",
        "high",
    }
    assert all(row.keys() >= needed for row in found["channels"])
    assert found.keys() >= {"channels", "duration_s", "encoder_step", "lost"}
    assert found["duration_s"] == 7.0  # of the longest stream


@pytest.mark.parametrize("kind", ["sines", "ramp", "steps"])
def test_the_sample_logs(kind: str, tmp_path: Path):
    log = tmp_path / f"{kind}.csv"
    log.write_text(first_part(f"{kind}.csv", 30_000 if kind == "ramp" else 10_000))
    found = facts(log, "--bench", CLUTCH)
    assert found["test"] == {"kind": kind, "given": False}
    assert found["reversed"] == found["odd"] == []
    fed = {name for name, why in found["methods"].items() if why is None}
    if kind == "ramp":
        assert fed == {"breakaway"}
        return
    assert "least-squares" in fed
    assert fed.isdisjoint({"breakaway", "stribeck-curve", "friction-force"})
    assert ("sines" in fed) is (kind == "sines")  # the steps have too few strokes


def test_the_kind_that_was_given_is_believed(tmp_path: Path):
    path = saved(tmp_path, {"log": {"test": "ramp"}}, position=np.sin(np.arange(3000) / 300.0))
    assert facts(path)["test"] == {"kind": "ramp", "given": True}
    assert (
        "test: ramp (stated in the log): the effort repeatedly grows from rest until the axis moves"
        in run("info", path).stdout
    )


def test_ingest_takes_the_kind(tmp_path: Path):
    target = tmp_path / "log.mcap"
    steps = ROOT / "sample_logs" / "steps.csv"
    assert run("ingest", steps, "--bench", CLUTCH, "--kind", "free", "-o", target).code == 0
    assert facts(target)["test"] == {"kind": "free", "given": True}
    assert run("ingest", steps, "--bench", CLUTCH, "--kind", "sine", "-o", target).code == 2


def test_saturation_holds_and_limits_in_text(tmp_path: Path):
    k = np.arange(6000)
    current = np.clip(80.0 * np.sin(k / 200.0), -50.0, 50.0)
    command = np.repeat(80.0 * np.sin(k[::4] / 200.0), 4)
    path = saved(
        tmp_path, position=np.rint(40 * np.sin(k / 200.0)), current=current, command=command
    )
    shown = run("info", path, "--bench", CLUTCH).stdout
    assert "saturated: /axis.current is flat at -50 A in " in shown
    assert "saturated: /axis.current is flat at 50 A in " in shown
    assert (
        f"saturated: /axis.current is at the bench's limit in {np.sum(np.abs(current) >= 49.0)} "
        "samples" in shown
    )
    assert "held: /axis.command keeps its value for 4 samples (0.004 s) or more" in shown
    assert "/axis.command is flat" not in shown
    without = run("info", path).stdout
    assert "flat at 50 A" in without
    assert "limit" not in without


def test_a_reversed_sensor_is_named(tmp_path: Path):
    bench = tmp_path / "bench.yaml"
    bench.write_text(
        EMPS.read_text().replace("{column: vir, unit: V}", "{column: vir, unit: V, scale: -1}")
    )
    record = tmp_path / "emps.mat"
    whole = scipy.io.loadmat(measured("emps/DATA_EMPS.mat"))
    part = {name: one[:8000] for name, one in whole.items() if not name.startswith("_")}
    scipy.io.savemat(record, part)
    assert facts(record, "--bench", EMPS)["reversed"] == []
    assert facts(record, "--bench", bench)["reversed"] == ["effort"]
    assert (
        "odd: the effort takes energy from the axis" in run("info", record, "--bench", bench).stdout
    )
    ingested = run("ingest", record, "--bench", bench, "-o", tmp_path / "log.mcap")
    assert ingested.code == 0
    assert "warning: the effort takes energy from the axis" in ingested.stderr


def test_what_was_lost_is_listed(tmp_path: Path):
    loss = {
        "channels": ["/axis.position"],
        "reason": "a chunk is damaged",
        "start_s": 1.0,
        "end_s": 2.0,
        "samples": 1000,
    }
    path = saved(
        tmp_path, {"lost": {"1": msgspec.json.encode(loss).decode()}}, position=np.arange(50.0)
    )
    assert facts(path)["lost"] == [loss]
    assert (
        "lost: 1000 samples of /axis.position from 1 to 2 s: a chunk is damaged\n"
        in run("info", path).stdout
    )


def test_numbers_that_nothing_measures(tmp_path: Path):
    path = saved(
        tmp_path,
        position=np.array([0.0, 1e300, -1.7e308, 3.0] * 30),
        current=np.array([1e-320, 1.0, 1e308, 0.0] * 30),
    )
    assert facts(path)["channels"][0]["high"] == 1e300
    raw = tmp_path / "raw.csv"
    raw.write_text(
        "time [s],encoder [count],current [A]\n"
        + "".join(f"{k / 1000},{k},{'1e308' if k == 5 else k}\n" for k in range(20))
    )
    refused(
        run("info", raw, "--bench", CLUTCH),
        3,
        "raw.csv:7: column 'current': found 1e+308; allowed: a finite number of at most 1e+100",
    )


def test_the_clocks_of_two_instruments(tmp_path: Path):
    time = np.arange(0.0, 20.0, 0.001)

    def stream(topic: str, clock: np.ndarray) -> Stream:
        return Stream(
            topic,
            clock,
            {"position": np.sin(3.0 * time) + 0.5 * np.sin(7.1 * time)},
            {"position": "rad"},
        )

    path = tmp_path / "two.mcap"
    path.write_bytes(
        as_bytes(
            Log((stream("/axis", time), stream("/axis/laser", 0.004 + (1.0 + 2e-4) * time)), {})
        )
    )
    (clock,) = facts(path)["clocks"]
    assert (clock["source"], clock["against"], clock["signal"]) == (
        "/axis/laser",
        "/axis",
        "position",
    )
    assert clock["offset_s"] == pytest.approx(0.004 + 2e-4 * 10.0, abs=2e-5)
    assert clock["drift"] == pytest.approx(2e-4, rel=0.02)
    text = (
        f"clock: /axis/laser shows position {clock['offset_s']:.4g} s after /axis, drift "
        f"{1e6 * clock['drift']:.4g} us per second\n"
    )
    assert text in run("info", path).stdout


def test_a_record_of_losses_that_is_none_is_one_line(tmp_path: Path):
    path = saved(tmp_path, {"lost": {"1": "everything"}}, position=np.arange(50.0))
    refused(run("info", path), 3, "log.mcap: metadata 'lost' is not a list of losses")


def test_the_same_log_gives_the_same_text_wherever_it_goes(tmp_path: Path):
    path, target = saved(tmp_path, position=np.arange(500.0) % 90), tmp_path / "info.txt"
    assert run("info", path, "-o", target).code == 0
    assert target.read_text() == run("info", path).stdout


def test_a_drive_in_another_stream_than_the_position_is_told_with_what_to_do(tmp_path: Path):
    time = np.arange(500) / 1000.0
    position = Stream("/axis", time, {"position": np.sin(20.0 * time)}, {"position": "rad"})
    current = Stream(
        "/axis/motor", time + 0.0004, {"current": np.cos(20.0 * time)}, {"current": "A"}
    )
    path, joined = tmp_path / "apart.mcap", tmp_path / "joined.mcap"
    path.write_bytes(as_bytes(Log((position, current), {})))
    assert facts(path)["odd"] == [
        "/axis has the position and /axis/motor has the current: `frictool ingest --resample` "
        "puts all streams on one grid"
    ]
    assert run("ingest", path, "--resample", "0.001", "-o", joined).code == 0
    assert facts(joined)["odd"] == []
    why = "the log is not a ramp of the effort from rest"
    fed = [line for line in run("info", joined).stdout.splitlines() if "suit" in line]
    assert len(fed) == 5
    assert fed[0].startswith("suits ")
    assert "least-squares, " in fed[0]
    assert fed[1] == "does not suit instrumental: the log has no reference"
    assert fed[2].startswith("does not suit stribeck-curve: found 0 runs at a constant speed")
    assert fed[3].startswith("does not suit friction-force: the log reverses")
    assert fed[4].startswith(f"does not suit breakaway: {why}")


def test_a_refusal_to_unpack_is_the_reason_that_is_given(tmp_path: Path):
    h5py, path = pytest.importorskip("h5py"), tmp_path / "filled.h5"
    with h5py.File(path, "w") as file:
        for name in ("time", "encoder"):
            file.create_dataset(
                name, shape=(250_000_000,), dtype="f8", chunks=(1 << 16,), fillvalue=1.0
            )
    refused(run("info", path), 3, "filled.h5: declares 250000000 rows")


@pytest.mark.parametrize("tail", [b"\0" * 100_000, b"\xff" * 30])
def test_a_recording_without_a_readable_sample_is_not_sent_to_a_salvage_in_vain(
    tail: bytes, tmp_path: Path
) -> None:
    log, target = tmp_path / "log.mcap", tmp_path / "out.mcap"
    log.write_bytes(b"\x89MCAP0\r\n" + tail)
    for command in (
        ["info", log],
        ["info", log, "--bench", CLUTCH],
        ["ingest", log, "--bench", CLUTCH, "-o", target],
    ):
        result = run(*command)
        refused(
            result,
            3,
            "log.mcap: is damaged or cut off at byte 8",
            "copy the file again",
        )
        assert "--salvage" not in result.stderr
    refused(
        run("ingest", log, "--bench", CLUTCH, "--salvage", "-o", target),
        3,
        "log.mcap: no sample can be read",
    )
    assert not target.exists()


def test_a_recording_with_samples_behind_the_damage_is_sent_to_a_salvage_that_works(
    tmp_path: Path,
) -> None:
    path, target = (
        saved(tmp_path, position=np.arange(20_000.0), current=np.arange(20_000.0) % 7),
        tmp_path / "out.mcap",
    )
    data = bytearray(path.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 100] = bytes(100)
    path.write_bytes(data)
    refused(
        run("ingest", path, "--bench", CLUTCH, "-o", target),
        3,
        "`ingest --salvage` keeps the readable part",
    )
    assert (
        run("ingest", path, "--bench", CLUTCH, "--salvage", "-o", target).code == 3
    )  # data are lost
    assert sum(channel["samples"] for channel in facts(target)["channels"]) == 2 * 16_000
