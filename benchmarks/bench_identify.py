"""Identification of an hour at 1 kHz with intervals, compared with one `numpy.linalg.lstsq`.

    identify.hour                 least squares: filter, slip mask, QR, jackknife
    identify.hour.output_error    output error: choice of load terms on held-out halves, search,
                                  influence of each cluster of strokes

The peer solves the prepared rows of least squares. The hour consists of 120 tests of the simulated
clutch, with a gap in time after each. The peak memory is that of a separate process, which makes
the log and identifies it once.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import pair
from frictool.documents.bench import Bench
from frictool.identify.methods import METHODS, IdentificationSettings, run
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rows.slip_fit import SMALLEST_SHARE, slipping
from studies.rigs.identification_rigs import clutch
from studies.rigs.sample_logs import TRUTH, sines

TESTS, MOST_ROWS, PAUSE = 120, 40_000, 10.0  # 120 logs of 29.9 s each at 1 kHz; s
LEAST_SQUARES, OUTPUT_ERROR = "least-squares", "output-error"
NAMES = ("inertia", "viscous", "coulomb")
KILOBYTE = 1024


def hour() -> MotionRecord:
    """Return the record of an hour of half sines on the clutch; its encoder has 56 counts."""
    columns, row, start = np.empty((3, TESTS * MOST_ROWS)), 0, 0.0
    for seed in range(TESTS):
        log = sines(seed)
        part = columns[:, row : row + log.time.size]
        part[:] = start + log.time, log.encoder * TRUTH.encoder_step, log.current * TRUTH.constant
        row, start = row + log.time.size, float(part[0, -1]) + PAUSE
    return make_record("hour", *columns[:, :row], resolution=TRUTH.encoder_step, lag=TRUTH.lag)


def peak_bytes(method: str) -> int:
    """Return the peak memory [bytes] of a process that makes the hour and identifies it."""
    assert method in METHODS
    code = f"from benchmarks.bench_identify import alone; alone({method!r})"
    return int(
        subprocess.run(
            [sys.executable, "-c", code], check=True, capture_output=True, text=True
        ).stdout
    )


def alone(method: str) -> None:
    run(method, [hour()], clutch(), IdentificationSettings())
    status = Path("/proc/self/status").read_text().splitlines()
    print(
        next(int(line.split()[1]) * KILOBYTE for line in status if line.startswith("VmHWM"))
    )  # the process's own, not its parent's


def rows(record: MotionRecord, bench: Bench) -> tuple[np.ndarray, np.ndarray]:
    """Return the prepared regressors (n, 4) and efforts (n,)."""
    samples, _ = slipping([record], bench, SMALLEST_SHARE, None)
    return np.column_stack(samples.columns), samples.effort


def _row(identity: str, method: str, rounds: int) -> dict[str, Any]:
    record, bench = hour(), clutch()
    regressors, effort = rows(record, bench)
    ours, theirs = pair(
        lambda: run(method, [record], bench, IdentificationSettings()),
        lambda: np.linalg.lstsq(regressors, effort, rcond=None),
        rounds,
    )
    found = run(method, [record], bench, IdentificationSettings()).parameters
    off = ", ".join(
        f"{name} off {100 * abs(found[name].value / getattr(TRUTH, name) - 1.0):.3f} %"
        for name in NAMES
        if name in found
    )
    return {
        "id": identity,
        "peer": "one numpy.linalg.lstsq",
        "ours": ours,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / ours,
        "accuracy": f"{ours / theirs:.3g} times lstsq, peak {peak_bytes(method) / 1e9:.2f} GB, "
        f"{off}",
    }


def identify_hour() -> dict[str, Any]:
    return _row("identify.hour", LEAST_SQUARES, 5)


def identify_hour_output_error() -> dict[str, Any]:
    return _row("identify.hour.output_error", OUTPUT_ERROR, 1)


identify_hour_output_error.id = "identify.hour.output_error"
ROWS = [identify_hour, identify_hour_output_error]
