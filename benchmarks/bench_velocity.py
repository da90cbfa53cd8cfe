"""Velocity estimates along logs: time per sample.

velocity.tracking   tracking observer of the clutch, with friction, backlash and dead zone. The
                    peer is filterpy's steady-state Kalman filter, which contains the linear
                    part only: position, speed and disturbance. The accuracy is the largest
                    difference of the speeds of both linear parts on the same samples, divided
                    by the largest speed.
velocity.along      estimate with its interval and errors, and the errors of the low-pass (5.70)
                    at every cut-off, compared with the duration of the log
"""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np

from benchmarks.timing import pair
from frictool.documents.observer import FrictionMap, Observer
from frictool.documents.provenance import Provenance
from frictool.observe.design.tracking import design_tracking
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverRun
from frictool.observe.velocity import VelocityEstimator
from frictool.typing import Vector
from studies.rigs.clutch_fleet import believed, run, spread, steps

SECONDS, ROUNDS, PEER_SAMPLES = 20.0, 5, 2000
START = (
    500  # samples: at rest the disturbance is not corrected, which the filter has forgotten by then
)


def linear_part(observer: Observer) -> Observer:
    """Return the observer without friction, backlash, knees and dead zone."""
    own = observer.tracking
    assert own is not None
    plain = msgspec.structs.replace(own, cell=0.0, knees=(), backlash=None)
    mechanics = msgspec.structs.replace(observer.bench.mechanics, top_speed=None)
    bench = msgspec.structs.replace(observer.bench, mechanics=mechanics)
    return msgspec.structs.replace(
        observer,
        tracking=plain,
        friction=FrictionMap(observer.friction.over, (0.0,), (0.0,)),
        bench=bench,
    )


def by_filterpy(observer: Observer, positions: Vector, efforts: Vector) -> Vector:
    """Return the speeds (n,) of filterpy's steady-state filter with the observer's gains."""
    from filterpy.kalman import KalmanFilter

    own, period, inertia = observer.tracking, observer.sample_period_s, observer.inertia.value
    assert own is not None
    peer = KalmanFilter(dim_x=3, dim_z=1, dim_u=1)
    peer.F = np.array(
        [[1.0, period, 0.5 * period**2 / inertia], [0.0, 1.0, period / inertia], [0.0, 0.0, 1.0]]
    )
    peer.B = np.array([[0.5 * period**2 / inertia], [period / inertia], [0.0]])
    peer.H = np.array([[1.0, 0.0, 0.0]])
    peer.K = np.array([[gain] for gain in own.gains])
    peer.x = np.array([[positions[0]], [0.0], [0.0]])
    speeds = np.empty(positions.size)
    for k in range(positions.size):
        peer.update_steadystate(np.array([[positions[k]]]))
        speeds[k] = peer.x[1, 0]
        peer.predict_steadystate(np.array([[efforts[k]]]))
    return speeds


def smooth(samples: int) -> tuple[Vector, Vector]:
    """Return positions [rad] and efforts [N m] of a motion that never rests, each (n,).

    Only the linear part of an observer acts in this motion.
    """
    t = 1e-3 * np.arange(samples, dtype=np.float64)
    return 20.0 * t + 0.2 * np.sin(30.0 * t), 0.002 * np.cos(30.0 * t) + 0.001


def along(observer: Observer, positions: Vector, efforts: Vector) -> Vector:
    time: Vector = observer.sample_period_s * np.arange(positions.size, dtype=np.float64)
    return ObserverRun(observer).take(MotionBlock(time, positions, efforts, follows=False)).velocity


def velocity_tracking() -> dict[str, Any]:
    """Return the row of a sample of the tracking observer."""
    observer = design_tracking(believed(), Provenance("make bench", "0"))
    piece = run(spread(0), steps(SECONDS), 0, "linear").pieces[0]
    short = piece.position[:PEER_SAMPLES], piece.effort[:PEER_SAMPLES]
    linear, (positions, efforts) = linear_part(observer), smooth(PEER_SAMPLES)
    ours, theirs = along(linear, positions, efforts), by_filterpy(linear, positions, efforts)
    settled = slice(START, None)
    apart = float(np.max(np.abs(ours - theirs)[settled]) / np.max(np.abs(theirs)))
    whole, peer = pair(
        lambda: along(observer, piece.position, piece.effort),
        lambda: by_filterpy(linear, *short),
        ROUNDS,
    )
    own, other = whole / piece.time.size, peer / PEER_SAMPLES
    return {
        "id": "velocity.tracking",
        "peer": "filterpy KalmanFilter, linear",
        "ours": own,
        "theirs": other,
        "unit": "s/sample",
        "ratio": other / own,
        "accuracy": f"linear part: speeds apart by {apart:.1e} of the largest",
    }


def velocity_along() -> dict[str, Any]:
    """Return the row of a sample along a log, with interval and velocity errors."""
    log = run(spread(0), steps(SECONDS), 0, "linear")
    piece = log.pieces[0]
    figures: dict[str, Any] = {}

    def estimate() -> None:
        estimator = VelocityEstimator(believed())
        estimator.take(piece)
        figures.update(estimator.figures())

    seconds, _ = pair(estimate, lambda: None, ROUNDS)
    ours = seconds / piece.time.size
    return {
        "id": "velocity.along",
        "peer": "the log's own time",
        "ours": ours,
        "theirs": 1e-3,
        "unit": "s/sample",
        "ratio": 1e-3 / ours,
        "accuracy": f"rms {figures['velocity_rms_true']:.2f} rad/s, (5.70) "
        f"{figures['velocity_rms_filter_true']:.2f} at its best",
    }


ROWS = [velocity_tracking, velocity_along]
