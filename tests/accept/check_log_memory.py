"""Logs of 2 GB: ingested in bounded memory, each in a process of its own whose peak is measured."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from frictool.logs.canonical.mcap_layout import StreamHeader
from frictool.logs.canonical.mcap_writer import CanonicalWriter, write_streams
from frictool.logs.canonical.sample_chunks import chunked
from frictool.logs.stream_source import SampleBlock
from tests.support.example_logs import ROOT
from tests.support.peak_memory import peak_mb

SEED = 11
BYTES = 2_000_000_000
MOST_MB = 400.0
BLOCK = 100_000
BENCH = ROOT / "configs" / "clutch" / "bench.yaml"


def long_csv(path: Path) -> None:
    """Rows of a clutch at 1 kHz."""
    rng = np.random.default_rng(SEED)
    counts, current = np.cumsum(rng.integers(-1, 2, BLOCK)), rng.normal(size=BLOCK)
    counts -= np.linspace(0, counts[-1], BLOCK).astype(
        int
    )  # it ends where it began, so that blocks can follow one another
    rows = [f"{count},{amps:.3f}\n" for count, amps in zip(counts, current, strict=True)]
    with path.open("w") as stream:
        stream.write("time [s],encoder [count],current [A]\n")
        second = 0
        while stream.tell() < BYTES:
            stream.writelines(
                f"{second + k // 1000}.{k % 1000:03d},{row}" for k, row in enumerate(rows)
            )
            second += BLOCK // 1000


def long_mcap(path: Path) -> None:
    """A canonical log of 20 kHz whose values do not compress."""
    rng = np.random.default_rng(SEED)

    def pieces() -> Any:
        written = 0
        for number in range(10**9):
            if stream.tell() > BYTES:
                return
            yield SampleBlock(
                (written + np.arange(BLOCK)) * 50_000, tuple(rng.normal(size=(3, BLOCK)))
            )
            written = (number + 1) * BLOCK

    with path.open("wb") as stream:
        head = StreamHeader("/axis", ("position", "current", "effort"), ("rad", "A", "N m"))
        write_streams(CanonicalWriter(stream, (head,), {}), [chunked(pieces())])


def _ingested(make: Callable[[Path], None], suffix: str) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as folder:
        raw, log = Path(folder, f"raw{suffix}"), Path(folder, "log.mcap")
        make(raw)
        start = time.perf_counter()
        peak = peak_mb("ingest", raw, "--bench", BENCH, "-o", log)
        size = raw.stat().st_size
        return {
            "passed": peak < MOST_MB and size >= BYTES,
            "peak_mb": peak,
            "bytes": size,
            "seconds": time.perf_counter() - start,
        }


CHECKS = {
    "logs.memory.csv": lambda: _ingested(long_csv, ".csv"),
    "logs.memory.mcap": lambda: _ingested(long_mcap, ".mcap"),
}
