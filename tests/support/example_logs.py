"""A small rig and logs of it, for the tests of this room."""

from __future__ import annotations

import io
import os
from pathlib import Path

import numpy as np
import pytest

from frictool.documents.bench import Actuator, Bench, Column, Encoder, Mechanics
from frictool.documents.quantity import Quantity
from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import Log, Stream
from frictool.logs.log_assembly import LogAssembly, add_tables, assemble_log
from frictool.logs.raw_table import RawTable

GOLDEN = Path(__file__).parents[1] / "logs" / "golden"
ROOT = Path(__file__).parents[2]


def bench(
    columns: dict[str, Column],
    encoder: Encoder | None = None,
    sample_period_s: float = 0.001,
    axis: str = "rotary",
) -> Bench:
    """A rig with 100 counts a revolution (0.01 m a count where linear) and 2 N m/A."""
    rotary = axis == "rotary"
    default = (
        Encoder(counts_per_revolution=100) if rotary else Encoder(step=Quantity(0.01, unit="m"))
    )
    return Bench(
        format="bench/1",
        name="rig",
        axis=axis,
        sample_period_s=sample_period_s,
        encoder=encoder or default,
        actuator=Actuator("current", Quantity(2.0, unit="N m/A"), Quantity(50.0, unit="A")),
        mechanics=Mechanics(
            Quantity(1.0, unit="kg m^2"), Quantity(1.0, unit="N m s/rad"), Quantity(1.0, unit="N m")
        ),
        columns=columns,
    )


def mapped(tables: RawTable | list[RawTable], rig: Bench) -> Log:
    """Tables as the log that a rig's bench makes of them."""
    made = LogAssembly()
    add_tables(made, tables if isinstance(tables, list) else [tables], rig)
    return assemble_log(made)


def golden_log() -> Log:
    """Two streams that start before 0, over more than one chunk, with a gap: every feature of the
    canonical layout."""
    sample = np.arange(12.0)
    time = np.where(sample < 6, sample - 3, sample + 14) / 4.0
    main = {"position": sample * 0.125, "current": np.where(sample % 2, -1.5, 2.25)}
    force = {"effort": 10.0 - sample[:3]}
    return Log(
        (
            Stream("/axis", time, main, {"position": "rad", "current": "A"}),
            Stream("/axis/force", np.array([0.0005, 0.001, 1.5]), force, {"effort": "N m"}),
        ),
        {
            "log": {"kind": "measured"},
            "provenance": {
                "command": "frictool ingest raw.csv --bench bench.yaml",
                "frictool": "0.1.0",
            },
        },
    )


def as_bytes(log: Log) -> bytes:
    stream = io.BytesIO()
    write_mcap(log, stream)
    return stream.getvalue()


def same(one: Log, other: Log) -> bool:
    """Return True if two logs have the same streams, bit for bit, and the same metadata."""
    alike = one.metadata == other.metadata and len(one.streams) == len(other.streams)
    return alike and all(
        (a.topic, list(a.signals), a.units) == (b.topic, list(b.signals), b.units)
        and np.array_equal(a.time, b.time)
        and all(np.array_equal(a.signals[name], b.signals[name]) for name in a.signals)
        for a, b in zip(one.streams, other.streams, strict=True)
    )


def measured(name: str) -> Path:
    """A file of the measured data, which are no part of the project; skips the test where they are
    not on this machine."""
    folder = Path(os.environ.get("FRICTOOL_DATA", ROOT.parent / "shared" / "data"))
    if not (folder / name).exists():
        pytest.skip(f"measured data: no {name} under FRICTOOL_DATA or ../shared/data")
    return folder / name
