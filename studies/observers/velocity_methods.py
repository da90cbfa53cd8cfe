"""Comparison of velocity estimates on the same logs, with variants of the tracking observer.

    python -m studies.observers.velocity_methods [EMPS_MODEL EMPS_LOG]

The logs are of twenty clutches within the bench's ranges (studies/rigs/clutch_fleet.py), with an
encoder of 56 counts per turn and a wear of 1 to 1.5. Each log has 20 s of steps, with the speed
controller or with a PID, and 0.5 A of noise on the current. The inertia of the observers' model is
20 % below the nominal value. The table shows the rms error of the velocity [rad/s] over all logs,
and the coverage of the 95 % interval. (5.70) and the difference quotient have the best cut-off for
each log; Savitzky-Golay is not causal. With the two files of configs/emps, the record is compared
with its zero-phase velocity.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
import numpy as np
from scipy.signal import savgol_filter

from frictool.documents.model import Model
from frictool.documents.observer import FrictionMap, Observer
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.observe.design.tracking import CELL, bandwidth_of, design_tracking
from frictool.observe.motion_block import MotionBlock
from frictool.observe.sample_stream import open_stream
from frictool.observe.velocity import VelocityEstimator
from frictool.typing import Vector
from studies.rigs.clutch_fleet import Run, believed, runs, spread, steps, targets

Change = Callable[[Observer], Observer]
FROM = Provenance("studies.observers.velocity_methods", "0")
SEEDS, WINDOW = range(10), 15
CELLS, FACTORS = (0.0, 0.25, CELL, 0.75, 1.0), (0.5, 0.7, 1.0, 1.4, 2.0)


def logs() -> list[Run]:
    """Return the logs with the speed controller, then those with the PID."""
    units = [spread(seed, wear=(1.0, 1.5, 1.2)[seed % 3]) for seed in SEEDS]
    references = [steps() if seed % 2 == 0 else targets(seed) for seed in SEEDS]
    return [
        *runs(units, references, list(SEEDS), "speed"),
        *runs(units, references, list(SEEDS), "linear"),
    ]


def rms(errors: list[Vector]) -> float:
    return float(np.sqrt(np.mean([np.mean(error**2) for error in errors])))


def by_observer(model: Model, observer: Observer, found: list[Run]) -> float:
    """Return the rms velocity error of an observer over all logs [rad/s]."""
    errors = []
    for log in found:
        estimator = VelocityEstimator(model, observer=observer)
        errors.append(
            np.concatenate([estimator.take(piece)[0] for piece in log.pieces]) - log.velocity
        )
    return rms(errors)


def without_friction(observer: Observer) -> Observer:
    """Return the observer without friction and dead zone, which is a Kalman filter.

    The states of the filter are position, speed and disturbance.
    """
    assert observer.tracking is not None
    plain = msgspec.structs.replace(observer.tracking, cell=0.0, backlash=None, knees=())
    return msgspec.structs.replace(
        observer, tracking=plain, friction=FrictionMap(observer.friction.over, (0.0,), (0.0,))
    )


def without_backlash(observer: Observer) -> Observer:
    assert observer.tracking is not None
    return msgspec.structs.replace(
        observer, tracking=msgspec.structs.replace(observer.tracking, backlash=None)
    )


def clutches() -> list[str]:
    """Return the table with one line per method."""
    model, found = believed(), logs()
    rule = bandwidth_of(model)
    low_passes, rows = [], []
    for log in found:
        estimator = VelocityEstimator(model)
        for piece in log.pieces:
            estimator.take(piece)
        low_passes.append(float(estimator.figures()["velocity_rms_filter_true"]))
    smooth = [
        savgol_filter(log.pieces[0].position, WINDOW, 2, 1, 1e-3) - log.velocity for log in found
    ]
    rows.append(
        (
            "(5.70), order 1 or the difference, best for each log",
            float(np.sqrt(np.mean(np.square(low_passes)))),
        )
    )
    changes: dict[str, Change] = {
        "Kalman with a disturbance, no friction": without_friction,
        "tracking, without the backlash": without_backlash,
    }
    for name, change in changes.items():
        best = min(
            (by_observer(model, change(design_tracking(model, FROM, rule * factor)), found), factor)
            for factor in FACTORS
        )
        rows.append((f"{name}, best of the bandwidths below", best[0]))
    by_cell = {cell: design_tracking(model, FROM, cell=cell) for cell in CELLS}
    rows += [
        (f"tracking, cell {cell:g} of a step, {rule:.0f} rad/s", by_observer(model, one, found))
        for cell, one in by_cell.items()
    ]
    for factor in FACTORS:
        observer = design_tracking(model, FROM, rule * factor)
        rows.append(
            (
                f"tracking, cell {CELL:g} of a step, {rule * factor:.0f} rad/s",
                by_observer(model, observer, found),
            )
        )
    rows.append((f"Savitzky-Golay of {WINDOW} points, not causal", rms(smooth)))
    shown = [f"{name:<72}{value:>8.2f} rad/s" for name, value in rows]
    all_of, moving = coverage(model, found)
    return [
        *shown,
        f"interval of 95 % of the tracking observer holds the velocity in {all_of:.1%} of the "
        f"samples, of those in motion in {moving:.1%}",
    ]


def coverage(model: Model, found: list[Run]) -> tuple[float, float]:
    """Return the share of intervals that contain the true velocity: all, and those in motion."""
    inside, moving = [], []
    for log in found:
        estimator = VelocityEstimator(model)
        values = np.concatenate([estimator.take(piece) for piece in log.pieces], axis=1)
        inside.append((values[1] <= log.velocity) & (log.velocity <= values[2]))
        moving.append(log.velocity != 0.0)
    all_of, still = np.concatenate(inside), np.concatenate(moving)
    return float(all_of.mean()), float(all_of[still].mean())


def record(model: Model, path: Path) -> list[str]:
    """Return the table of a measured log, compared with its zero-phase velocity."""
    lines = []
    pieces: list[MotionBlock] = list(open_stream(path, model.bench).pieces())
    rule = bandwidth_of(model)
    for factor in FACTORS:
        bandwidth = min(rule * factor, 1.0 / model.bench.sample_period_s)
        estimator = VelocityEstimator(model, observer=design_tracking(model, FROM, bandwidth))
        for piece in pieces:
            estimator.take(piece)
        found = estimator.figures()
        cutoff = (
            "the difference itself"
            if found["filter_cutoff_hz"] is None
            else f"{found['filter_cutoff_hz']:.0f} Hz"
        )
        lines.append(
            f"{path.name}: tracking at {bandwidth:.0f} rad/s {found['velocity_rms']:.3g}, (5.70) "
            f"at its best ({cutoff}) "
            f"{found['velocity_rms_filter']:.3g}, to the zero-phase velocity of "
            f"{found['zero_phase_cutoff_hz']:.0f} Hz"
        )
    return lines


def main(arguments: list[str]) -> int:
    if len(arguments) not in (0, 2):
        print(__doc__, file=sys.stderr)
        return 2
    print("\n".join(clutches()))
    if arguments:
        print("\n".join(record(load(Path(arguments[0]), Model), Path(arguments[1]))))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
