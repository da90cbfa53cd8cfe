"""An hour at 1 kHz identified with intervals (filter, slip mask, QR, jackknife) against one `numpy.linalg.lstsq` on the prepared rows.

The hour is 120 tests of the simulated clutch, one after the other with a pause of the clock. Peak memory is that of a process of its own
that holds the log and identifies it once.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import pair
from frictool.documents.bench import Bench
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.methods import Settings
from frictool.identify.record import Record, make_record
from frictool.identify.rows.slipping import SMALLEST_SHARE, slipping
from sample_logs.make import TRUTH, sines
from tests.identify.benches import clutch

TESTS, MOST_ROWS, PAUSE, ROUNDS = 120, 40_000, 10.0, 5  # 120 logs of 29.9 s each at 1 kHz; s
KILOBYTE = 1024


def hour() -> Record:
    """An hour of half sines on the clutch with its encoder of 56 points."""
    columns, row, start = np.empty((3, TESTS * MOST_ROWS)), 0, 0.0
    for seed in range(TESTS):
        log = sines(seed)
        part = columns[:, row : row + log.time.size]
        part[:] = start + log.time, log.encoder * TRUTH.encoder_step, log.current * TRUTH.constant
        row, start = row + log.time.size, float(part[0, -1]) + PAUSE
    return make_record("hour", *columns[:, :row], resolution=TRUTH.encoder_step, lag=TRUTH.lag)


def peak_bytes() -> int:
    """Peak resident memory of a fresh process that makes the hour and identifies it."""
    code = "from benchmarks.bench_identify import alone; alone()"
    return int(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout)


def alone() -> None:
    least_squares([hour()], clutch(), Settings())
    status = Path("/proc/self/status").read_text().splitlines()
    print(next(int(line.split()[1]) * KILOBYTE for line in status if line.startswith("VmHWM")))  # the process's own, not its parent's


def rows(record: Record, bench: Bench) -> tuple[np.ndarray, np.ndarray]:
    """The prepared regressors (n, 4) and efforts (n,)."""
    samples, _ = slipping([record], bench, SMALLEST_SHARE, None)
    return np.column_stack(samples.columns), samples.effort


def identify_hour() -> dict[str, Any]:
    record, bench = hour(), clutch()
    regressors, effort = rows(record, bench)
    fit = least_squares([record], bench, Settings())
    ours, theirs = pair(lambda: least_squares([record], bench, Settings()), lambda: np.linalg.lstsq(regressors, effort, rcond=None), ROUNDS)
    coulomb = fit.parameters["coulomb"]
    off = abs(coulomb.value / TRUTH.coulomb - 1.0)
    return {
        "id": "identify.hour",
        "peer": "one numpy.linalg.lstsq",
        "ours": ours,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / ours,
        "accuracy": f"{ours / theirs:.1f} times lstsq, peak {peak_bytes() / 1e9:.2f} GB, coulomb off {100 * off:.3f} %",
    }


ROWS = [identify_hour]
