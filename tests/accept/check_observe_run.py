"""`observe run`: the memory that logs of one hour and of ten take, in a process of its own; the
friction along clutches of all kinds."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from frictool.observe.friction_tracker import FrictionTracker, estimate_starts
from frictool.observe.velocity import VelocityEstimator
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.typing import Vector
from studies.rigs.clutch_fleet import NOISE, Loop, Unit, believed, clutch, run, spread, steps
from studies.rigs.fleet_logs import long_log, model_file
from tests.support.peak_memory import peak_mb

MOST_MB = 600.0  # most of it are libraries: 8 s of log take nearly as much
MOST_GROWTH = 1.1
HOLD, WEAR = 5.0, 1.2  # s from move to move
PLANTS = 40
SETTLED = 4.0  # s, after which some moves have been seen
SLIPS = 20.0  # rad/s
SPAN = 5  # samples, over which the lag of the drive's loop no longer matters
LEAST_COVERED = 0.93


def memory() -> dict[str, Any]:
    """Peaks with everything that is asked for: the log of estimates, written to nowhere, and the
    picture."""
    with tempfile.TemporaryDirectory() as folder:
        model, peaks, seconds = model_file(Path(folder)), [], []
        for minutes in (1, 60, 600):  # the first compiles, where that has not been done
            log = Path(folder, f"{minutes}.mcap")
            long_log(log, minutes, HOLD, WEAR)
            start = time.perf_counter()
            peaks.append(
                peak_mb(
                    "observe",
                    "run",
                    model,
                    log,
                    "-o",
                    "/dev/null",
                    "--plot",
                    Path(folder, "wear.svg"),
                )
            )
            seconds.append(time.perf_counter() - start)
            log.unlink()
        passed = peaks[2] < MOST_GROWTH * peaks[1] and peaks[2] < MOST_MB
        return {
            "passed": passed,
            "peak_mb": peaks,
            "times_real_time": 9.0 * 3600.0 / (seconds[2] - seconds[1]),
        }


def friction() -> dict[str, Any]:
    """Error and coverage of the friction along PLANTS clutches that are spread as the bench says,
    wear 1.0 to 1.5.

    True is effort less inertia times acceleration, of the simulation and without noise, over SPAN
    samples that are all at rest, or all in slip: it is compared with the mean of the estimates
    there, and of either end of their intervals.
    """
    sums: dict[str, list[tuple[float, float, int, int]]] = {}
    for seed in range(PLANTS):
        unit = spread(seed, wear=1.0 + 0.5 * seed / (PLANTS - 1))
        loop: Loop = "speed" if seed % 2 else "linear"
        for name, figures in _friction(unit, seed, loop).items():
            sums.setdefault(name, []).append(figures)
    found = {}
    for name, rows in sums.items():
        squares, scale, inside, count = (sum(column) for column in zip(*rows, strict=True))
        found[name] = {
            "rms_n_m": (squares / count) ** 0.5,
            "mean_n_m": scale / count,
            "covered": inside / count,
            "samples": count,
        }
    passed = (
        all(one["covered"] >= LEAST_COVERED for one in found.values())
        and found["slip"]["rms_n_m"] < 0.05 * found["slip"]["mean_n_m"]
    )
    return {"passed": passed, **found}


def _friction(unit: Unit, seed: int, loop: Loop) -> dict[str, tuple[float, float, int, int]]:
    """Return, for rest, slip and gap: the sum of squared errors, the sum of absolute friction, the
    number of samples within the interval, and the number of samples."""
    reference = steps(20.0)
    logged, silent = (run(unit, reference, seed, loop, noise) for noise in (NOISE, 0.0))
    (piece,), velocity, effort = logged.pieces, logged.velocity, silent.pieces[0].effort
    model = believed()
    wear, speed, along = WearEstimator(model), VelocityEstimator(model), FrictionTracker(model)
    before = wear.estimate
    known = estimate_starts(piece, before, wear.take(piece))
    value, low, high = (_mean(row) for row in along.take(piece, speed.take(piece), known))
    inertia = unit.inertia * clutch().parameters.inertia.value
    true = _mean(effort) - inertia * (velocity[SPAN:] - velocity[:-SPAN]) / (SPAN * 1e-3)
    windows = np.abs(np.lib.stride_tricks.sliding_window_view(velocity, SPAN + 1))
    settled, still, slips = (
        piece.time[:-SPAN] > SETTLED,
        windows.max(axis=1) == 0.0,
        windows.min(axis=1) > SLIPS,
    )
    loose = (
        np.abs(true)
        < 1.1 * unit.gap_friction * unit.wear * clutch().bench.mechanics.backlash_coulomb.value
    )
    found = {}
    for name, chosen in (("rest", still), ("slip", slips & ~loose), ("gap", slips & loose)):
        at = np.flatnonzero(chosen & settled)
        inside = (low[at] <= true[at]) & (true[at] <= high[at])
        found[name] = (
            float(np.sum((value[at] - true[at]) ** 2)),
            float(np.sum(np.abs(true[at]))),
            int(inside.sum()),
            at.size,
        )
    return found


def _mean(signal: Vector) -> Vector:
    """Over each SPAN periods (n - SPAN,), by trapezoids."""
    ends = np.concatenate(([0.0], np.cumsum(0.5 * (signal[:-1] + signal[1:]))))
    return np.asarray(ends[SPAN:] - ends[:-SPAN]) / SPAN


CHECKS = {"observe.run.memory": memory, "observe.run.friction": friction}
