"""Observers along logs: how many times faster than the log itself, in the time of one core (all threads of the process together)."""

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
from tests.observe.fleet import Unit, believed, run

MINUTES, ROUNDS = 10, 3
MINUTE = 60_000  # samples
WEAR = 1.2
PLACES = (30.0, 0.0, 50.0, 20.0)  # rad, one after another


def _log(path: Path, hold: float) -> None:
    """A clutch at 1 kHz that makes a move each `hold` s, encoder of 56 points, 0.5 A of noise; every minute as the first."""
    held = round(1e3 * hold)
    reference = np.repeat(np.resize(PLACES, MINUTE // held), held)
    (piece,) = run(Unit(wear=WEAR), reference, 0).pieces
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


def _along(hold: float, name: str, written: bool) -> dict[str, Any]:
    """A canonical log from disk to the estimate and its figures: feed, wear, velocity, friction; the start left out.

    written: the estimates of every sample as a log on disk too.
    """
    with tempfile.TemporaryDirectory() as folder, _one_core():
        source, target = Path(folder, "log.mcap"), Path(folder, "estimates.mcap")
        _log(source, hold)
        seconds, found = [], OneLog(source, believed(), Settings())
        for _ in range(1 + ROUNDS):
            start = time.process_time()
            found = OneLog(source, believed(), Settings())
            if written:
                with target.open("wb") as stream:
                    write(found, found.parts(), stream, {})
            else:
                for _part in found.parts():
                    pass
            seconds.append(time.process_time() - start)
    outcome, ours = found.outcome(), statistics.median(seconds[1:])
    wear = outcome.estimate.wear
    told = f"wear {wear.value:.3f} in [{wear.low:.3f}, {wear.high:.3f}], true {WEAR:g}; {outcome.estimate.moves} moves"
    return {
        "id": name,
        "peer": "the log itself, one core",
        "ours": ours,
        "theirs": outcome.duration,
        "unit": "s",
        "ratio": outcome.duration / ours,
        "accuracy": f"{told}, {outcome.samples} samples, {1e6 * ours / outcome.samples:.2f} us each{', written' if written else ''}",
    }


def observe_run() -> dict[str, Any]:
    """A move each 5 s."""
    return _along(5.0, "observe.run", written=False)


def observe_run_written() -> dict[str, Any]:
    """The same with the log of estimates."""
    return _along(5.0, "observe.run_written", written=True)


def observe_run_busy() -> dict[str, Any]:
    """Two moves a second without a pause: each costs as much as hundreds of samples."""
    return _along(0.5, "observe.run_busy", written=False)


ROWS = [observe_run, observe_run_written, observe_run_busy]
