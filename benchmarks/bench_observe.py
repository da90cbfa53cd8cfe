"""Observers along logs: processor time of one core, compared with the duration of the log.

The processor time is the sum over all threads of the process.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from frictool.observe.estimates_log import write
from frictool.observe.log_observer import LogObserver, ObservationSettings
from studies.rigs.clutch_fleet import believed
from studies.rigs.fleet_logs import long_log

MINUTES, ROUNDS = 10, 3
WEAR = 1.2


@contextmanager
def _one_core() -> Iterator[None]:
    """Run the threads of this process on one core, if the operating system allows it."""
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
    """Return the row of an observation, from the log on disk to the wear and the velocity errors.

    The first of several observations is not timed.

    - hold: time between two moves [s]
    - written: True if the estimates of every sample are written to disk as a log
    """
    with tempfile.TemporaryDirectory() as folder, _one_core():
        source, target = Path(folder, "log.mcap"), Path(folder, "estimates.mcap")
        long_log(source, MINUTES, hold, WEAR)
        seconds, found = [], LogObserver(source, believed(), ObservationSettings())
        for _ in range(1 + ROUNDS):
            start = time.process_time()
            found = LogObserver(source, believed(), ObservationSettings())
            if written:
                with target.open("wb") as stream:
                    write(found, found.parts(), stream, {})
            else:
                for _part in found.parts():
                    pass
            seconds.append(time.process_time() - start)
    outcome, ours = found.outcome(), statistics.median(seconds[1:])
    wear = outcome.estimate.wear
    told = (
        f"wear {wear.value:.3f} in [{wear.low:.3f}, {wear.high:.3f}], true {WEAR:g}; "
        f"{outcome.estimate.moves} moves"
    )
    return {
        "id": name,
        "peer": "the log itself, one core",
        "ours": ours,
        "theirs": outcome.duration,
        "unit": "s",
        "ratio": outcome.duration / ours,
        "accuracy": f"{told}, {outcome.samples} samples, {1e6 * ours / outcome.samples:.2f} us "
        f"each{', written' if written else ''}",
    }


def observe_run() -> dict[str, Any]:
    """Return the row of a log with a move every 5 s."""
    return _along(5.0, "observe.run", written=False)


def observe_run_written() -> dict[str, Any]:
    """Return the row of `observe_run` when the log of estimates is written."""
    return _along(5.0, "observe.run_written", written=True)


def observe_run_busy() -> dict[str, Any]:
    """Return the row of a log with two moves per second, without pauses.

    A move costs as much processor time as hundreds of samples.
    """
    return _along(0.5, "observe.run_busy", written=False)


ROWS = [observe_run, observe_run_written, observe_run_busy]
