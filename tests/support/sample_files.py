"""A small good file of each format that is read, and a bench that maps its columns, whatever they
are called."""

from __future__ import annotations

import io
import json
import re
import shutil
import tempfile
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench, Column, Encoder
from frictool.documents.starting_documents import StartingRig, starting_documents
from frictool.documents.writing import to_yaml
from frictool.errors import LogError
from frictool.logs.canonical.mcap_reader import is_canonical
from frictool.logs.formats import open_tables
from frictool.logs.raw_table import RawTable, RowBlock
from frictool.logs.recordings.recording_files import METADATA, sources
from tests.support import logger_files
from tests.support.example_logs import GOLDEN, as_bytes, bench, golden_log
from tests.support.logger_headers import LOGGERS

ROWS = 40
TIME = np.arange(ROWS) / 1000.0
COUNTS = np.rint(20.0 * np.sin(np.arange(ROWS) / 6.0))
CURRENT = np.round(np.cos(np.arange(ROWS) / 6.0), 3)
NS = [round(1e9 * float(time)) + 1_700_000_000_000_000_000 for time in TIME]
ONE_UNIT = 1.000001  # a scale, so that no unit of the file contradicts the bench's


def _rows(
    delimiter: str = ",", decimal: str = ".", date: Callable[[float], str] = "{:.3f}".format
) -> str:
    rows = zip(TIME, COUNTS, CURRENT, strict=True)
    return "".join(
        delimiter.join([date(t), f"{n:.0f}", f"{i:.3f}"]).replace(
            "." if decimal == "," else "\0", decimal
        )
        + "\n"
        for t, n, i in rows
    )


def _csv() -> bytes:
    return ("time [s],encoder [count],current [A]\n" + _rows()).encode()


def _german() -> bytes:
    return ("\ufeffZeit [s];Geber;Strom [A]\r\n" + _rows(";", ",").replace("\n", "\r\n")).encode()


def _scope() -> bytes:
    """As oscilloscopes export: what the instrument says of itself, names, units in a row of their
    own."""
    return (
        "Model,S1\nSample Interval,0.001,s\nProbe,10\n\nTIME,CH1,CH2\ns,V,V\n" + _rows()
    ).encode()


def _labview() -> bytes:
    """A LabVIEW measurement with a time column, a unit line and a column of comments."""
    head = (
        "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\n"
        "Decimal_Separator\t,\nMulti_Headings\tNo\nX_Columns\tOne\nTime_Pref\tRelative\n"
        "***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t40\t40\t\n"
        "Y_Unit_Label\tcount\tA\t\nX_Dimension\tTime\tTime\t\nX0\t0,0\t0,0\t\n"
        "Delta_X\t0,001\t0,001\t\n***End_of_Header***\t\t\t\nX_Value\tencoder\tcurrent\tComment\n"
    )
    return (head + _rows("\t", ",")).encode()


def _json_lines() -> bytes:
    rows = zip(TIME.tolist(), COUNTS.tolist(), CURRENT.tolist(), strict=True)
    return "".join(
        json.dumps({"time": t, "encoder": n, "motor": {"current": i}, "state": "on"}) + "\n"
        for t, n, i in rows
    ).encode()


def _can(folder: Path) -> None:
    """A CAN log and its DBC; a mutated copy in another folder is refused for want of a DBC."""
    (folder / "x.dbc").write_text(logger_files.DBC)
    (folder / "x").write_text(logger_files.candump())


def _mat(**options: bool) -> bytes:
    import scipy.io

    stream = io.BytesIO()
    scipy.io.savemat(
        stream, {"time": TIME, "encoder": COUNTS.astype(np.int16), "current": CURRENT}, **options
    )
    return stream.getvalue()


def _npz(packed: bool = False) -> bytes:
    stream = io.BytesIO()
    (np.savez_compressed if packed else np.savez)(
        stream, time=TIME, encoder=COUNTS.astype(np.int32), current=CURRENT
    )
    return stream.getvalue()


def _hdf5(folder: Path) -> None:
    import h5py

    with h5py.File(folder / "x", "w", userblock_size=512) as file:
        for name, values in {"time": TIME, "encoder": COUNTS, "current": CURRENT}.items():
            file.create_dataset(name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_(
                "double"
            )
    with (folder / "x").open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def _parquet(folder: Path) -> None:
    import pyarrow
    import pyarrow.parquet

    pyarrow.parquet.write_table(
        pyarrow.table({"time": TIME, "encoder": COUNTS, "current": CURRENT}), folder / "x"
    )


def _mdf(folder: Path) -> None:
    from asammdf import MDF, Signal

    signals = [
        Signal(samples=values, timestamps=TIME, name=name)
        for name, values in {"encoder": COUNTS, "current": CURRENT}.items()
    ]
    with MDF(version="4.10") as file:
        file.append(signals)
        saved = file.save(folder / "saved.mf4", overwrite=True)
    Path(saved).rename(folder / "x")


def _ros2_mcap() -> bytes:
    from mcap_ros2.writer import Writer

    stream = io.BytesIO()
    writer = Writer(stream)
    schema = writer.register_msgdef(
        "demo_msgs/msg/Axis", "float64 encoder\nfloat64 current\nfloat64[] more\nstring text"
    )
    for at, n, i in zip(NS, COUNTS, CURRENT, strict=True):
        message = {"encoder": float(n), "current": float(i), "more": [1.0, 2.0], "text": "x"}
        writer.write_message("/axis_state", schema, message, log_time=at, publish_time=at)
    writer.finish()
    return stream.getvalue()


def _json_mcap() -> bytes:
    from mcap.writer import CompressionType, Writer

    stream = io.BytesIO()
    writer = Writer(stream, compression=CompressionType.LZ4)
    writer.start()
    channel = writer.register_channel(
        "/axis_state", "json", writer.register_schema("Axis", "jsonschema", b'{"type": "object"}')
    )
    for at, n, i in zip(NS, COUNTS, CURRENT, strict=True):
        writer.add_message(
            channel, at, f'{{"encoder": {n}, "current": {i}, "more": [1, 2]}}'.encode(), at
        )
    writer.finish()
    return stream.getvalue()


def _bag(folder: Path) -> None:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kind = store.types["geometry_msgs/msg/Point"]
    with Writer(folder / "x.bag") as writer:
        connection = writer.add_connection("/axis_state", kind.__msgtype__, typestore=store)
        for at, n, i in zip(NS, COUNTS, CURRENT, strict=True):
            writer.write(
                connection,
                at,
                store.serialize_ros1(kind(x=float(n), y=float(i), z=0.0), kind.__msgtype__),
            )
    (folder / "x.bag").rename(folder / "x")


def _db3(folder: Path, part: slice = slice(None)) -> None:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = store.types["geometry_msgs/msg/Point"]
    with tempfile.TemporaryDirectory() as made:
        with Writer(Path(made, "bag"), version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
            connection = writer.add_connection("/axis_state", kind.__msgtype__, typestore=store)
            for at, n, i in zip(NS[part], COUNTS[part], CURRENT[part], strict=True):
                writer.write(
                    connection,
                    at,
                    store.serialize_cdr(kind(x=float(n), y=float(i), z=0.0), kind.__msgtype__),
                )
        shutil.move(next(Path(made, "bag").glob("*.db3")), folder / "x")


def _split_bag(folder: Path) -> None:
    """The folder of a ROS 2 bag in two parts."""
    bag, halves = folder / "x", (slice(0, ROWS // 2), slice(ROWS // 2, ROWS))
    bag.mkdir()
    for number, part in enumerate(halves):
        _db3(bag, part)
        (bag / "x").rename(bag / f"x_{number}.db3")
    files = "".join(f"  - x_{number}.db3\n" for number in range(len(halves)))
    about = (
        f"  version: 5\n  storage_identifier: sqlite3\n  relative_file_paths:\n{files}  "
        "compression_mode: ''\n"
    )
    (bag / METADATA).write_text("rosbag2_bagfile_information:\n" + about)


LOGGER = "logger/"  # before the name of a logger: its files are read without a bench
DOCUMENT = "document"  # a bench in YAML
TAGGED = (
    'name: !!str rig\nsample_period_s: !!float "0.001"\nlayout: !!map {first_line: !!int "2"}\n'
)
# name -> its bytes, or what writes the file `x` into a folder
SAMPLES: dict[str, Callable[[], bytes] | Callable[[Path], None]] = {
    "canonical": lambda: as_bytes(golden_log()),
    "csv": _csv,
    "csv.german": _german,
    "csv.bare": lambda: _rows("\t").encode(),
    "csv.scope": _scope,
    "csv.iso": lambda: (
        "when;encoder;current\n"
        + _rows(";", date=lambda t: f"2026-01-02T03:04:05.{round(1000 * t):03d}Z")
    ).encode(),
    "csv.labview": _labview,
    "csv.day_first": lambda: (
        "when;encoder;current\n"
        + _rows(";", date=lambda t: f"31.01.2026 03:04:05.{round(1000 * t):03d}")
    ).encode(),
    "jsonl": _json_lines,
    "mat": _mat,
    "mat.compressed": lambda: _mat(do_compression=True),
    "npz": lambda: _npz(),
    "npz.compressed": lambda: _npz(packed=True),
    "mat73": _hdf5,
    "parquet": _parquet,
    "mdf": _mdf,
    "mcap.ros2": _ros2_mcap,
    "mcap.json": _json_mcap,
    "bag": _bag,
    "db3": _db3,
    "folder/metadata.yaml": _split_bag,
    "folder/x_0.db3": _split_bag,
}


SAMPLES |= {
    name: made
    for name, library, made in (
        ("tdms", "nptdms", lambda folder: logger_files.write_tdms(folder / "x")),
        ("ulog", "pyulog", logger_files.ulog),
        ("can", "can", _can),
    )
    if find_spec(library)
}


def names() -> list[str]:
    """Every sample, the starts of public loggers' files, a document, and every golden file."""
    loggers = (f"{LOGGER}{name}" for name in LOGGERS)
    return [
        *SAMPLES,
        *loggers,
        DOCUMENT,
        *(
            f"golden/{path.name}"
            for path in sorted(GOLDEN.iterdir())
            if path.is_file() and path.suffix != ".py"
        ),
    ]


def write(name: str, folder: Path) -> Path:
    """The sample as the file `x` in `folder`; of `folder/FILE`, that file of the bag `x`."""
    target = folder / "x"
    if name.startswith("golden/"):
        target.write_bytes((GOLDEN / name.removeprefix("golden/")).read_bytes())
        return target
    if name.startswith(LOGGER):
        target.write_text(LOGGERS[name.removeprefix(LOGGER)])
        return target
    if name == DOCUMENT:
        target.write_text(
            f"{starting_documents(StartingRig('rig', 'rotary'))['bench.yaml']}{TAGGED}"
        )
        return target
    made = SAMPLES[name]
    if made.__code__.co_argcount:
        made(folder)
    else:
        target.write_bytes(made())
    return target / name.removeprefix("folder/") if target.is_dir() else target


def given(path: Path) -> Path:
    """Return the path that frictool gets to read `path`: the file, or the bag that contains it."""
    return path.parent if (path.parent / METADATA).exists() else path


def bench_of(path: Path) -> Bench:
    """A bench that maps the first columns of what is `given`: a time where one is called so, a
    position, a current."""
    (parts,) = sources([given(path)])
    if is_canonical(parts[0]):
        return bench({"position": Column("position", "rad")})
    tables = open_tables(parts)
    table = max(tables, key=lambda one: len(one.names))
    blocks = {name: block for name in table.names if (block := _whole(table, name)) is not None}
    once = {name for name in blocks if sum(name in one.names for one in tables) == 1}
    dated = next((block.time_ns for block in blocks.values() if block.time_ns is not None), None)
    usable = [name for name in blocks if name in once]
    time = (
        next((name for name in usable if re.match(r"(t|time|zeit)\b", name, re.IGNORECASE)), None)
        if dated is None
        else None
    )
    numbers = [name for name in usable if name != time]
    columns = {} if time is None else {"time": Column(time, "s", ONE_UNIT)}
    for channel, unit, name in zip(("position", "current"), ("rad", "A"), numbers, strict=False):
        columns[channel] = Column(name, unit, ONE_UNIT)
    times = (
        dated / 1e9
        if dated is not None
        else blocks[time].columns[time]
        if time is not None
        else np.arange(2) / 1000.0
    )
    return bench(columns, Encoder(counts_per_revolution=100), float(np.median(np.diff(times))))


def _whole(table: RawTable, name: str) -> RowBlock | None:
    """A column whose numbers are all there: its first block."""
    try:
        blocks = [block for block, _ in table.blocks([name])]
    except LogError:
        return None
    return (
        blocks[0]
        if all(name in block.columns and np.isfinite(block.columns[name]).all() for block in blocks)
        else None
    )


def write_other(name: str, path: Path, target: Path) -> None:
    """Write the second file of the command: the bench of the sample at `path`, or the log that a
    document is the bench of."""
    target.write_text(
        "time,encoder,current\n" + _rows(",") if name == DOCUMENT else to_yaml(bench_of(path))
    )
