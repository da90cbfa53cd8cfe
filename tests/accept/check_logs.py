"""Mutated input files at full count: each is read or refused in one line; nothing else is raised, nothing takes long."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.errors import FrictoolError
from frictool.logs.reading import read_log
from tests.logs.example import ROOT, as_bytes, golden_log

SEED = 7
COUNT = 3000  # of each format
SLOWEST = 10.0  # s


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """The file with bytes changed, cut out, doubled or cut off."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 4))):
        if not out:
            break
        at, length = int(rng.integers(len(out))), int(rng.integers(1, 64))
        action = int(rng.integers(5))
        if action == 0:
            out[at] ^= 1 << int(rng.integers(8))
        elif action == 1:
            out[at : at + length] = rng.bytes(length)
        elif action == 2:
            del out[at : at + length]
        elif action == 3:
            out[at:at] = out[at : at + length]
        else:
            del out[at:]
    return bytes(out)


def fuzz(data: bytes, seed: int, count: int) -> dict[str, Any]:
    """Reads `count` mutations of a file through the clutch's bench. Whatever is raised beyond FrictoolError ends the check."""
    bench = load(ROOT / "configs" / "clutch" / "bench.yaml", Bench)
    rng = np.random.default_rng(seed)
    refused, slowest = 0, 0.0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "input")
        for _ in range(count):
            path.write_bytes(mutated(data, rng))
            start = time.perf_counter()
            try:
                read_log(path, bench)
            except FrictoolError as error:
                refused += 1
                if "\n" in str(error):
                    raise AssertionError(f"more than one line: {error}") from error
            slowest = max(slowest, time.perf_counter() - start)
    return {"passed": slowest < SLOWEST, "files": count, "refused": refused, "slowest_s": slowest}


def sample(kind: str) -> bytes:
    """A small good file of each format."""
    if kind == "mcap":
        return as_bytes(golden_log())
    if kind == "csv":
        return b"".join((ROOT / "sample_logs" / "sines.csv").read_bytes().splitlines(keepends=True)[:60])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "x.mat")
        columns = {"time": np.arange(60) / 1000.0, "encoder": np.arange(60, dtype=np.int16), "current": np.linspace(0.0, 1.0, 60)}
        scipy.io.savemat(path, columns, do_compression=kind == "mat.compressed")
        return path.read_bytes()


def _check(kind: str, seed: int) -> Callable[[], dict[str, Any]]:
    return lambda: fuzz(sample(kind), seed, COUNT)


KINDS = ("mcap", "csv", "mat", "mat.compressed")
CHECKS = {f"logs.fuzz.{kind}": _check(kind, SEED + number) for number, kind in enumerate(KINDS)}
