"""Writes the golden files of the formats that need a library, with those libraries alone, nothing
of frictool's.

python tests/logs/golden/make_extras.py
"""

from __future__ import annotations

import io
from datetime import UTC, datetime
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from asammdf import MDF, Signal
from asammdf.blocks.v4_blocks import FileHistory

HERE = Path(__file__).parent
COUNTS = np.array([-1, 2, 300, 7], dtype=np.int16)
TIME = np.array([0.0, 0.5, 1.0, 1.5])


def mdf(version: str) -> bytes:
    """Two rasters that share a name, a conversion to amperes, one to texts, in version 4 an invalid
    sample."""
    file = MDF(version=version)
    invalid = np.array([False, True, False, False])
    states = {"val_0": 0, "text_0": "off", "val_1": 1, "text_1": "on", "default": "?"}
    fast = [
        Signal(COUNTS, TIME, name="nAct\\ETKC:1", unit="rpm"),
        Signal(COUNTS, TIME, name="iAct", unit="A", conversion={"a": 0.5, "b": 1.0}),
        Signal(np.array([0, 1, 0, 1], dtype=np.uint8), TIME, name="state", conversion=states),
        Signal(np.array([b"a", b"b", b"c", b"d"]), TIME, name="note", encoding="latin-1"),
    ]
    if version >= "4":
        fast.append(Signal(COUNTS, TIME, name="doubtful", unit="A", invalidation_bits=invalid))
    file.append(fast, acq_name="fast", common_timebase=True)
    file.append(
        [Signal(COUNTS[:2] * 1.0, TIME[:2], name="nAct\\ETKC:1", unit="rpm")], acq_name="slow"
    )
    if version >= "4":
        file.header.abs_time = 1_700_000_000_123_456_789
        history = FileHistory(abs_time=0)
        history.abs_time, history.comment = 0, "<FHcomment><TX>golden</TX></FHcomment>"
        file.file_history.append(history)
        stream = io.BytesIO()
        file.save(stream, compression=2, add_history_block=False)
        return stream.getvalue()
    file.header.start_time = datetime(2024, 2, 29, 12, tzinfo=UTC)
    target = HERE / "v3.mdf"
    file.save(target, overwrite=True)
    return target.with_suffix(".mdf").read_bytes()


def parquet(path: Path) -> None:
    """Stamps in ns, a unit, an empty cell, a structure, two row groups."""
    stamps = pa.array(1_700_000_000_123_456_789 + np.arange(4) * 500_000_001).cast(
        pa.timestamp("ns", "UTC")
    )
    state = pa.array([{"on": bool(k % 2), "text": "x"} for k in range(4)])
    columns = {
        "when": stamps,
        "position": pa.array(TIME),
        "count": pa.array([*COUNTS[:3].tolist(), None], pa.int16()),
        "state": state,
    }
    table = pa.table(
        columns,
        schema=pa.schema(
            [
                pa.field(n, c.type, metadata={"unit": "rad"} if n == "position" else None)
                for n, c in columns.items()
            ]
        ),
    )
    pq.write_table(table, path, row_group_size=2, write_page_checksum=True)


def mat73(path: Path) -> None:
    """As MATLAB lays it out: axes reversed, the class in an attribute, references to what is in
    cells and arrays of structures."""
    with h5py.File(path, "w", userblock_size=512) as file:

        def put(
            group: h5py.Group, name: str, array: np.ndarray, kind: str = "double"
        ) -> h5py.Dataset:
            dataset = group.create_dataset(name, data=array)
            dataset.attrs["MATLAB_class"] = np.bytes_(kind)
            return dataset

        put(file, "t", TIME[np.newaxis])
        put(file, "counts", COUNTS[:, np.newaxis], "int16")
        put(file, "matrix", np.arange(8.0).reshape(2, 4))
        put(file, "note", np.array([[104], [105]], dtype=np.uint16), "char")
        put(file, "gain", np.array([[35.15]]))
        data = file.create_group("data")
        data.attrs["MATLAB_class"] = np.bytes_("struct")
        put(data, "time", TIME[np.newaxis])
        references = file.create_group("#refs#")
        first, second = (
            put(references, "a", TIME[np.newaxis]),
            put(references, "b", TIME[np.newaxis] + 5),
        )
        cells = file.create_dataset(
            "cells", data=np.array([[first.ref, second.ref]], dtype=h5py.ref_dtype)
        )
        cells.attrs["MATLAB_class"] = np.bytes_("cell")
        runs = file.create_group("runs")
        runs.attrs["MATLAB_class"] = np.bytes_("struct")
        runs.create_dataset("x", data=np.array([[first.ref], [second.ref]], dtype=h5py.ref_dtype))
        series = put(file, "series", np.zeros((1, 6), dtype=np.uint32), "timeseries")
        series.attrs["MATLAB_object_decode"] = np.int32(3)
        file["elsewhere"] = h5py.ExternalLink("other.mat", "/t")
    with path.open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file, written by h5py".ljust(124) + b"\x00\x02IM")


def npz(path: Path) -> None:
    """Dates, big-endian counts, a matrix in Fortran's order, a structured array, an object."""
    when = np.datetime64("2023-11-14T22:13:20.123456789", "ns") + np.arange(4) * np.timedelta64(
        500_000_001, "ns"
    )
    matrix = np.asfortranarray(np.arange(8.0).reshape(4, 2))
    rows = np.array(
        [(1, 0.5), (2, 1.5), (3, 2.5), (4, 3.5)], dtype=[("count", "u1"), ("current", "<f4")]
    )
    np.savez(
        path,
        when=when,
        counts=COUNTS.astype(">i2"),
        matrix=matrix,
        rows=rows,
        note=np.array([None, "x"], dtype=object),
    )


if __name__ == "__main__":
    (HERE / "v4.mf4").write_bytes(mdf("4.10"))
    (HERE / "v3.mdf").write_bytes(mdf("3.30"))
    parquet(HERE / "stamps.parquet")
    mat73(HERE / "v73.mat")
    npz(HERE / "arrays.npz")
