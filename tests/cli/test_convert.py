"""`convert`: what comes back from each format is the log, bit for bit; other tools open it."""

from __future__ import annotations

import io
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.logs.canonical.mcap_format import read_mcap, write_mcap
from frictool.logs.formats import WRITTEN
from frictool.logs.log import Log, Stream
from frictool.logs.raw_table import BLOCK_ROWS
from studies.command_line import CommandResult, run
from tests.support.command_line import refused
from tests.support.example_logs import ROOT, as_bytes, golden_log

KINDS = tuple(WRITTEN)
SUFFIX = {kind: one.suffixes[0] for kind, one in WRITTEN.items()}
UNITS = {"time": "s", "position": "rad", "velocity": "rad/s", "current": "A", "effort": "N m"}


def save(log: Log, path: Path) -> Path:
    with path.open("wb") as stream:
        write_mcap(log, stream)
    return path


def single(time_ns: np.ndarray, **signals: np.ndarray) -> Log:
    return Log(
        (Stream("/axis", time_ns / 1e9, signals, {name: UNITS[name] for name in signals}),),
        {"log": {"kind": "measured"}},
    )


def bench_for(path: Path, columns: dict[str, str], period: float) -> Path:
    """A bench that maps SI columns as they are called in a file."""
    document = yaml.safe_load((ROOT / "configs" / "clutch" / "bench.yaml").read_text())
    document["columns"] = {
        channel: {"column": column, "unit": UNITS[channel]} for channel, column in columns.items()
    }
    document["sample_period_s"] = period
    path.write_text(yaml.safe_dump(document))
    return path


def round_trip(log: Log, kind: str, folder: Path, period: float) -> Log:
    """To the format and back through `ingest`."""
    source, other, back = (
        save(log, folder / "a.mcap"),
        folder / f"b{SUFFIX[kind]}",
        folder / "c.mcap",
    )
    done = run("convert", source, "-o", other)
    assert (done.code, done.stderr) == (0, "")
    names = ("time", *log.main.signals)
    bench = bench_for(folder / "bench.yaml", {name: name for name in names}, period)
    done = run("ingest", other, "--bench", bench, "-o", back)
    assert done.code == 0, done.stderr
    return read_mcap(back)


def alike(found: Log, log: Log) -> None:
    assert np.array_equal(
        np.rint((found.main.time - found.main.time[0]) * 1e9),
        np.rint((log.main.time - log.main.time[0]) * 1e9),
    )
    for name, values in log.main.signals.items():
        assert found.main.signals[name].tobytes() == values.tobytes()
    assert found.main.units.items() >= log.main.units.items()


@pytest.mark.parametrize("kind", KINDS)
def test_round_trip_bit_for_bit_over_several_blocks(kind: str, tmp_path: Path):
    n = BLOCK_ROWS + 500
    draw = np.random.default_rng(5)
    time = np.arange(n) * 1_000_000 + draw.integers(-300_000, 300_000, n)
    log = single(
        time,
        position=draw.normal(size=n),
        current=draw.normal(size=n) * 1e-300,
        effort=np.exp(draw.normal(size=n) * 50),
    )
    alike(round_trip(log, kind, tmp_path, 0.001), log)


FINITE = st.floats(-1e100, 1e100).map(
    lambda x: x + 0.0
)  # larger ones are refused; of zeros the sign is lost in the mapping


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=settings.default.max_examples // 10)
@given(values=st.lists(FINITE, min_size=2, max_size=20), start=st.integers(0, 10**15))
def test_round_trip_of_any_numbers(kind: str, values: list[float], start: int):
    log = single(
        start + np.arange(len(values)) * 1_000_000,
        velocity=np.array(values),
        effort=np.array(values)[::-1].copy(),
    )
    with tempfile.TemporaryDirectory() as folder:
        alike(round_trip(log, kind, Path(folder), 0.001), log)


@pytest.fixture
def two(tmp_path: Path) -> Path:
    path = tmp_path / "two.mcap"
    path.write_bytes(as_bytes(golden_log()))
    return path


@pytest.mark.parametrize("kind", ["mat", "mdf", "npz"])
def test_several_streams_in_one_file(kind: str, two: Path, tmp_path: Path):
    target = tmp_path / f"x{SUFFIX[kind]}"
    assert run("convert", two, "-o", target).code == 0
    names = {
        "mat": ("streams.axis.position", "streams.axis.time"),
        "mdf": ("position", "time"),
        "npz": ("axis.position", "axis.time"),
    }[kind]
    bench = bench_for(
        tmp_path / "bench.yaml", dict(zip(("position", "time"), names, strict=True)), 0.25
    )
    done = run("ingest", target, "--bench", bench, "-o", tmp_path / "back.mcap")
    assert done.code == 0, done.stderr
    assert np.array_equal(
        read_mcap(tmp_path / "back.mcap").main.signals["position"],
        golden_log().main.signals["position"],
    )


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_one_stream_of_several(kind: str, two: Path, tmp_path: Path):
    target = tmp_path / f"x{SUFFIX[kind]}"
    refused(
        run("convert", two, "-o", target),
        3,
        "has 2 streams, /axis, /axis/force",
        "--stream",
        "mat, mdf, npz",
    )
    assert not target.exists()
    done = run("convert", two, "--stream", "/axis/force", "-o", target, "--json")
    assert json.loads(done.stdout) == {
        "format": "convert/1",
        "file_format": kind,
        "streams": {"/axis/force": {"effort": "N m"}},
    }
    refused(
        run("convert", two, "--stream", "/axis/froce", "-o", target),
        3,
        "did you mean '/axis/force'?",
    )


def test_matlab_and_scipy_see_structures_and_units(two: Path, tmp_path: Path):
    run("convert", two, "-o", tmp_path / "x.mat")
    found = scipy.io.loadmat(tmp_path / "x.mat", squeeze_me=True, simplify_cells=True)
    streams = found["streams"]
    assert np.array_equal(streams["axis"]["position"], golden_log().main.signals["position"])
    assert streams["axis_force"]["units"] == {"time": "s", "effort": "N m"}
    assert found["notes"]["provenance"]["command"] == "frictool convert two.mcap --to mat"
    run("convert", two, "--stream", "/axis", "-o", tmp_path / "y.mat")
    alone = scipy.io.loadmat(tmp_path / "y.mat", squeeze_me=True, simplify_cells=True)
    assert np.array_equal(alone["current"], golden_log().main.signals["current"])
    assert alone["units"]["current"] == "A"


def test_asammdf_sees_groups_units_and_time(two: Path, tmp_path: Path):
    asammdf = pytest.importorskip("asammdf")
    run("convert", two, "-o", tmp_path / "x.mf4")
    with asammdf.MDF(tmp_path / "x.mf4") as file:
        assert [group.channel_group.acq_name for group in file.groups] == ["/axis", "/axis/force"]
        signal = file.get("position")
        assert np.array_equal(signal.samples, golden_log().main.signals["position"])
        assert np.array_equal(signal.timestamps, golden_log().main.time)
        assert (signal.unit, file.version) == ("rad", "4.10")
        assert file.header.abs_time == 0


def test_parquet_and_numpy_carry_units_and_provenance(two: Path, tmp_path: Path):
    pq = pytest.importorskip("pyarrow.parquet")
    run("convert", two, "--stream", "/axis", "-o", tmp_path / "x.parquet")
    schema = pq.read_schema(tmp_path / "x.parquet")
    assert {field.name: field.metadata[b"unit"] for field in schema} == {
        "time": b"s",
        "position": b"rad",
        "current": b"A",
    }
    assert (
        json.loads(schema.metadata[b"provenance"])["command"]
        == "frictool convert two.mcap --to parquet --stream /axis"
    )
    run("convert", two, "-o", tmp_path / "x.npz")
    with np.load(tmp_path / "x.npz") as arrays:
        assert dict(arrays["units"].tolist())["axis_force.effort"] == "N m"
        assert json.loads(str(arrays["notes"]))["log"] == {"kind": "measured"}


def test_csv_is_readable(tmp_path: Path):
    log = single(
        np.array([0, 1_000_000, 2_000_000]),
        position=np.array([0.1, 0.2, 0.30000000000000004]),
        current=np.array([1.0, -2.0, 1e-9]),
    )
    run("convert", save(log, tmp_path / "x.mcap"), "-o", tmp_path / "x.csv")
    assert (tmp_path / "x.csv").read_text() == (
        "time [s],position [rad],current "
        "[A]\n0.0,0.1,1.0\n0.001,0.2,-2.0\n0.002,0.30000000000000004,1e-09\n"
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_log_gives_the_same_bytes_on_file_and_stdout(kind: str, two: Path, tmp_path: Path):
    def once(name: str) -> CommandResult:
        return run(
            "convert",
            two,
            "--stream",
            "/axis",
            "--to",
            kind,
            "-o",
            tmp_path / name if name != "-" else name,
        )

    once("one"), once("other")
    piped = once("-")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes() == piped.out
    assert piped.stderr == f"stdout: {kind}, /axis\n"


def test_a_raw_file_through_its_bench(tmp_path: Path):
    raw, bench = ROOT / "sample_logs" / "sines.csv", ROOT / "configs" / "clutch" / "bench.yaml"
    assert run("convert", raw, "--bench", bench, "-o", tmp_path / "x.npz").code == 0
    with np.load(tmp_path / "x.npz") as arrays:
        assert {"time", "position", "current", "effort"} <= set(arrays)
    refused(run("convert", raw, "-o", tmp_path / "y.npz"), 3, "--bench")


def test_an_output_that_does_not_say_its_format(two: Path, tmp_path: Path):
    done = run("convert", two, "-o", tmp_path / "x.dat")
    assert done.code == 2
    assert "--to" in done.stderr
    assert list(tmp_path.iterdir()) == [two]


def test_a_log_on_a_clock_keeps_its_epoch(tmp_path: Path):
    asammdf = pytest.importorskip("asammdf")
    raw, bench = ROOT / "tests" / "logs" / "golden" / "v4.mf4", tmp_path / "bench.yaml"
    bench_for(bench, {"current": "iAct"}, 0.5)
    done = run("convert", raw, "--bench", bench, "-o", tmp_path / "x.mf4")
    assert done.code == 0, done.stderr
    with asammdf.MDF(io.BytesIO((tmp_path / "x.mf4").read_bytes())) as file:
        assert file.header.abs_time == 1_700_000_000_123_456_789
        assert file.get("current").samples.tolist() == [0.5, 2.0, 151.0, 4.5]


def test_what_a_log_lost_goes_with_it(tmp_path: Path):
    """A MATLAB variable cut in its last samples: salvaged with exit code 3, then converted with a
    warning and the record."""
    contents = {name: np.arange(40.0) / 1000 for name in ("time", "position", "current")}
    scipy.io.savemat(tmp_path / "raw.mat", contents)
    (tmp_path / "raw.mat").write_bytes((tmp_path / "raw.mat").read_bytes()[:-80])
    bench = bench_for(tmp_path / "bench.yaml", {name: name for name in contents}, 0.001)
    refused(
        run("ingest", tmp_path / "raw.mat", "--bench", bench, "-o", tmp_path / "a.mcap"),
        3,
        "raw.mat: is damaged",
    )
    assert not (tmp_path / "a.mcap").exists()
    assert (
        run(
            "ingest", tmp_path / "raw.mat", "--bench", bench, "-o", tmp_path / "a.mcap", "--salvage"
        ).code
        == 3
    )
    (lost,) = json.loads(run("info", tmp_path / "a.mcap", "--json").stdout)["lost"]
    assert (lost["samples"], lost["channels"]) == (10, ["/axis.current"])
    done = run("convert", tmp_path / "a.mcap", "-o", tmp_path / "x.npz")
    assert done.code == 0
    assert (
        done.stderr
        == "warning: data were lost when a.mcap was made: 10 samples in 1 place; `frictool info` "
        "lists them\n"
    )
    with np.load(tmp_path / "x.npz") as arrays:
        assert arrays["current"].size == 30
        assert "10" in json.loads(str(arrays["notes"]))["lost"]["1"]


@pytest.mark.parametrize(
    ("name", "module", "extra"),
    [("x.mf4", "asammdf", "mdf"), ("x.parquet", "pyarrow.parquet", "parquet")],
)
def test_a_missing_library_is_named_with_the_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, module: str, extra: str
):
    log = save(single(np.arange(3) * 10**6, position=np.arange(3.0)), tmp_path / "log.mcap")
    monkeypatch.setitem(sys.modules, module, None)
    refused(
        run("convert", log, "-o", tmp_path / name),
        3,
        f"{name}: needs {module}",
        f"pip install 'frictool[{extra}]'",
    )
    assert not (tmp_path / name).exists()
