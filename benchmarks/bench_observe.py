"""Observers along logs: how many times faster than the log itself, on one core."""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from frictool.logs.canonical.chunks import chunked
from frictool.logs.canonical.mcap_layout import Head
from frictool.logs.canonical.mcap_writer import CanonicalWriter, write_streams
from frictool.logs.flow import Samples
from frictool.observe.estimates_log import write
from frictool.observe.one_log import OneLog, Settings
from tests.observe.files import CONSTANT, UNITS
from tests.observe.fleet import Unit, believed, run, steps

MINUTES, ROUNDS = 10, 3
MINUTE = 60_000  # samples
WEAR = 1.2


def _log(path: Path) -> None:
    """A clutch at 1 kHz that makes two moves a second, encoder of 56 points, 0.5 A of noise; every minute as the first."""
    (piece,) = run(Unit(wear=WEAR), np.concatenate([steps(30.0), steps(30.0)]), 0).pieces
    signals = (piece.position, piece.effort / CONSTANT)

    def pieces() -> Iterator[Samples]:
        for minute in range(MINUTES):
            yield Samples((minute * MINUTE + np.arange(MINUTE)) * 1_000_000, signals)

    with path.open("wb") as stream:
        head = Head("/axis", ("position", "current"), (UNITS["position"], UNITS["current"]))
        write_streams(CanonicalWriter(stream, (head,), {}), [chunked(pieces())])


@contextmanager
def _one_core() -> Iterator[None]:
    """All threads of this process on one core, where the system can be told so."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def observe_run() -> dict[str, Any]:
    """A canonical log from disk to the log of estimates on disk: feed, wear, velocity with its figures, friction; the start left out."""
    with tempfile.TemporaryDirectory() as folder, _one_core():
        source, target = Path(folder, "log.mcap"), Path(folder, "estimates.mcap")
        _log(source)
        seconds, found = [], OneLog(source, believed(), Settings())
        for _ in range(1 + ROUNDS):
            start = time.perf_counter()
            one = OneLog(source, believed(), Settings())
            with target.open("wb") as stream:
                write(one, one.parts(), stream, {})
            found = one
            seconds.append(time.perf_counter() - start)
    outcome, ours = found.outcome(), statistics.median(seconds[1:])
    wear = outcome.estimate.wear
    return {
        "id": "observe.run",
        "peer": "the log itself, one core",
        "ours": ours,
        "theirs": outcome.duration,
        "unit": "s",
        "ratio": outcome.duration / ours,
        "accuracy": (
            f"wear {wear.value:.3f} in [{wear.low:.3f}, {wear.high:.3f}], true {WEAR:g}; {outcome.estimate.moves} moves, "
            f"{outcome.samples} samples, {1e6 * ours / outcome.samples:.2f} us each"
        ),
    }


ROWS = [observe_run]
