"""A recording of 2 GB: ingested in bounded memory, every message of it there."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from frictool.logs.canonical.mcap_reader import open_mcap
from tests.support.peak_memory import peak_mb
from tests.support.recordings import CLUTCH, COLUMNS, long_joint_states

BYTES = 2_000_000_000
MOST_MB = 400.0
MESSAGE_BYTES = 127


def memory() -> dict[str, Any]:
    """The most memory that `ingest` needs for it."""
    with tempfile.TemporaryDirectory() as folder:
        raw, bench, log = (
            Path(folder, "raw.mcap"),
            Path(folder, "bench.yaml"),
            Path(folder, "log.mcap"),
        )
        bench.write_text(
            CLUTCH.read_text().partition("columns:")[0]
            + COLUMNS.replace("clutch]", "arm]").replace("effort[", "velocity[")
        )
        long_joint_states(raw, BYTES // MESSAGE_BYTES)
        size = raw.stat().st_size
        peak = peak_mb("ingest", raw, "--bench", bench, "-o", log)
        found = sum(piece.time.size for piece in open_mcap(log)[0][0].samples())
    whole = found == BYTES // MESSAGE_BYTES
    return {
        "passed": whole and size > 0.95 * BYTES and peak < MOST_MB,
        "bytes": size,
        "samples": found,
        "peak_mb": peak,
    }


CHECKS = {"recordings.memory": memory}
