"""Start-up, conversion and canonical logs, compared with other tools for the same task."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import pair
from frictool.documents.bench import Actuator, Bench, Column, Encoder, Mechanics
from frictool.documents.quantity import Quantity
from frictool.logs.canonical.mcap_format import read_mcap, write_mcap
from frictool.logs.log import Log, Stream
from frictool.logs.log_assembly import assemble, write

SEED = 1
ROWS_OF_CSV = 1_000_000
SAMPLES = 600_000
# the message loops are slow: they are timed on fewer samples, and both are given per second
PEER_SAMPLES = 20_000

BENCH = Bench(
    format="bench/1",
    name="bench",
    axis="rotary",
    sample_period_s=0.001,
    encoder=Encoder(counts_per_revolution=56),
    actuator=Actuator("current", Quantity(0.0134, unit="N m/A"), Quantity(50.0, unit="A")),
    mechanics=Mechanics(
        Quantity(1e-5, unit="kg m^2"), Quantity(1e-4, unit="N m s/rad"), Quantity(0.1, unit="N m")
    ),
    columns={
        "time": Column("time", "s"),
        "position": Column("encoder", "count"),
        "current": Column("current", "A"),
    },
)


def startup_help() -> dict[str, Any]:
    """Return the row of `frictool --help` against a process that imports click."""
    frictool = Path(sys.executable).with_name("frictool")

    def ours() -> None:
        subprocess.run([frictool, "--help"], check=True, capture_output=True)

    def theirs() -> None:
        subprocess.run([sys.executable, "-c", "import click"], check=True, capture_output=True)

    a, b = pair(ours, theirs, 9)
    return _row(
        "startup.help", "python -c 'import click'", a, b, "s", b / a, "wall time of a process"
    )


def ingest_csv() -> dict[str, Any]:
    """Return the row of the conversion of CSV to a canonical log, against parsing the CSV."""
    rng = np.random.default_rng(SEED)
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "raw.csv"), Path(folder, "log.mcap")
        counts, current = np.cumsum(rng.integers(-1, 2, ROWS_OF_CSV)), rng.normal(size=ROWS_OF_CSV)
        with source.open("w") as stream:
            stream.write("time [s],encoder [count],current [A]\n")
            stream.writelines(
                f"{k / 1000:.3f},{c},{i:.3f}\n"
                for k, (c, i) in enumerate(zip(counts, current, strict=True))
            )

        def ours() -> None:
            with target.open("wb") as stream:
                write(assemble([source], BENCH), stream, {})

        a, b = pair(ours, lambda: np.loadtxt(source, delimiter=",", skiprows=1), 5)
        wanted = np.loadtxt(source, delimiter=",", skiprows=1)[:, 2]
        worst = float(np.abs(read_mcap(target).main.signals["current"] - wanted).max())
        size = source.stat().st_size / 1e6
    return _row(
        "ingest.csv",
        "numpy.loadtxt",
        size / a,
        size / b,
        "MB/s",
        b / a,
        f"output written; largest difference {worst:g}",
    )


def _log(samples: int) -> Log:
    rng = np.random.default_rng(SEED)
    time = np.arange(samples) / 1000.0
    position = np.cumsum(rng.integers(-1, 2, samples)) * 0.1122
    current = np.round(rng.normal(size=samples), 3)
    signals = {
        "position": position,
        "current": current,
        "effort": 0.0134 * current,
        "reference": np.round(position, 1),
    }
    units = {"position": "rad", "current": "A", "effort": "N m", "reference": "rad"}
    return Log((Stream("/axis", time, signals, units),))


def _save(log: Log, path: Path) -> None:
    with path.open("wb") as stream:
        write_mcap(log, stream)


def log_read() -> dict[str, Any]:
    """Return the row of reading a log with all CRCs checked.

    The peer is the mcap reader, which decodes each message with its ROS 2 decoder.
    """
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with tempfile.TemporaryDirectory() as folder:
        whole, part = Path(folder, "whole.mcap"), Path(folder, "part.mcap")
        _save(_log(SAMPLES), whole)
        _save(_log(PEER_SAMPLES), part)

        def theirs() -> list[float]:
            with part.open("rb") as stream:
                reader = make_reader(stream, decoder_factories=[DecoderFactory()])
                return [decoded.position for _, _, _, decoded in reader.iter_decoded_messages()]

        a, b = pair(lambda: read_mcap(whole), theirs, 5)
        same = np.array_equal(read_mcap(part).main.signals["position"], theirs())
    speed, peer = SAMPLES / a, PEER_SAMPLES / b
    return _row(
        "log.read",
        "mcap reader, decoded",
        speed,
        peer,
        "samples/s",
        speed / peer,
        f"CRCs checked; same values: {same}",
    )


def log_read_csv() -> dict[str, Any]:
    """Return the row of reading a log with all CRCs checked, against pyarrow's CSV reader."""
    import pyarrow.csv

    log = _log(SAMPLES)
    with tempfile.TemporaryDirectory() as folder:
        ours_path, theirs_path = Path(folder, "log.mcap"), Path(folder, "log.csv")
        _save(log, ours_path)
        table = pyarrow.table({"time": log.main.time, **log.main.signals})
        pyarrow.csv.write_csv(table, theirs_path)
        a, b = pair(lambda: read_mcap(ours_path), lambda: pyarrow.csv.read_csv(theirs_path), 9)
        same = np.array_equal(
            read_mcap(ours_path).main.signals["current"],
            pyarrow.csv.read_csv(theirs_path)["current"].to_numpy(),
        )
    return _row(
        "log.read.csv",
        "pyarrow.csv",
        SAMPLES / a,
        SAMPLES / b,
        "samples/s",
        b / a,
        f"CRCs checked; same values: {same}",
    )


log_read_csv.id = "log.read.csv"


def log_write() -> dict[str, Any]:
    """Return the row of writing a log.

    The peer is the mcap writer, which writes messages that are encoded already.
    """
    from mcap.writer import Writer

    log = _log(SAMPLES)
    time = (np.arange(PEER_SAMPLES) * 1_000_000).tolist()
    values = np.column_stack(list(log.main.signals.values()))[:PEER_SAMPLES]
    payloads = [b"\0\1\0\0" + row.tobytes() for row in values]
    with tempfile.TemporaryDirectory() as folder:
        ours_path, theirs_path = Path(folder, "ours.mcap"), Path(folder, "theirs.mcap")

        def theirs() -> None:
            with theirs_path.open("wb") as stream:
                writer = Writer(stream)
                writer.start("ros2")
                schema = writer.register_schema(
                    "frictool_msgs/msg/Axis", "ros2msg", b"float64 position\n"
                )
                channel = writer.register_channel("/axis", "cdr", schema)
                for stamp, payload in zip(time, payloads, strict=True):
                    writer.add_message(channel, stamp, payload, stamp)
                writer.finish()

        a, b = pair(lambda: _save(log, ours_path), theirs, 5)
        found = read_mcap(ours_path).main
        same = all(
            np.array_equal(found.signals[name], wanted) for name, wanted in log.main.signals.items()
        )
    speed, peer = SAMPLES / a, PEER_SAMPLES / b
    return _row(
        "log.write",
        "mcap writer's loop",
        speed,
        peer,
        "samples/s",
        speed / peer,
        f"indexed, CRCs; read back the same: {same}",
    )


def _row(
    identity: str, peer: str, ours: float, theirs: float, unit: str, ratio: float, accuracy: str
) -> dict[str, Any]:
    return {
        "id": identity,
        "peer": peer,
        "ours": ours,
        "theirs": theirs,
        "unit": unit,
        "ratio": ratio,
        "accuracy": accuracy,
    }


ROWS = [startup_help, ingest_csv, log_read, log_read_csv, log_write]
