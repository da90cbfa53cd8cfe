"""Causal estimate of the velocity along a log, with its interval, from encoder and drive.

    MotionBlock ──mean effort of each period──▶ tracking observer ──▶ velocity
    velocity ──kernels/velocity_interval.py──▶ interval
             ──velocity_errors.py────────────▶ rms error, compared with the low-pass (thesis 5.70)

control/tracking_observer.py defines the observer. If the drive has a lag, the effort of a period is
the mean of the samples at both ends of the period. The period after the last sample of a block is
therefore processed with the next block. A drive without a lag keeps its value over the period.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Any

import numpy as np

from frictool import __version__
from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.observe.design.error_gains import error_gains
from frictool.observe.design.tracking import design_tracking, spread
from frictool.observe.kernels.velocity_interval import (
    STATE_SIZE,
    VelocityIntervalConstants,
    velocity_interval,
)
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverOutput, ObserverRun
from frictool.observe.velocity_errors import VelocityErrors
from frictool.typing import Matrix, Vector

# quantile of the normal distribution for which kernels/velocity_interval.py is calibrated
CALIBRATED = NormalDist().inv_cdf(0.975)


class VelocityEstimator:
    """Estimator of the velocity along a log, block by block.

    - confidence: confidence of the intervals, 0 to 1
    - observer: tracking observer; None to design one from the model
    """

    def __init__(
        self, model: Model, confidence: float = 0.95, observer: Observer | None = None
    ) -> None:
        self.observer = observer or design_tracking(
            model, Provenance("frictool observe run", __version__)
        )
        tracking = self.observer.tracking
        if tracking is None:
            raise ValueError("a velocity interval needs a tracking observer")
        self._run = ObserverRun(self.observer)
        self._lagged = model.bench.actuator.logged_lag_s > 0.0
        self._bandwidth = tracking.bandwidth_rad_s
        inertia = self.observer.inertia.value
        period = self.observer.sample_period_s
        unsure, friction = spread(model)
        step = model.bench.encoder.resolution
        passed = error_gains(tracking.gains, inertia, period)
        self._sizes = VelocityIntervalConstants(
            unsure, friction / inertia, step, tracking.cell, self._bandwidth, period, *passed
        )
        self._widening = NormalDist().inv_cdf(0.5 + 0.5 * confidence) / CALIBRATED
        self._figures = VelocityErrors(
            self._bandwidth / (2.0 * math.pi), self.observer.sample_period_s
        )
        self._state = np.zeros(STATE_SIZE)
        self._waiting: tuple[MotionBlock, Vector] | None = None

    def take(self, piece: MotionBlock) -> Matrix:
        """Process a block; return value, lower and upper bound (3, n) [rad/s | m/s]."""
        estimate = self._along(piece)
        half = self._half(piece, estimate)
        self._figures.take(piece.position, estimate.velocity, piece.velocity, piece.follows)
        return np.stack([estimate.velocity, estimate.velocity - half, estimate.velocity + half])

    def figures(self) -> dict[str, Any]:
        """Return the velocity errors and the observer's bandwidth (SI) at the end of the log."""
        return self._figures.figures() | {"observer_bandwidth_rad_s": self._bandwidth}

    def _along(self, piece: MotionBlock) -> ObserverOutput:
        if not self._lagged:
            return self._run.take(piece)
        # the period between the blocks, whose two ends are known now
        if self._waiting is not None and piece.follows:
            last, before = self._waiting
            self._run.machine.real[:] = before
            self._run.take(_with_effort(last, 0.5 * (last.effort + piece.effort[:1])))
        ahead = _part(piece, slice(0, -1))
        last = _part(piece, slice(-1, None), follows=True if piece.time.size > 1 else piece.follows)
        middle = 0.5 * (piece.effort[:-1] + piece.effort[1:])
        parts = [self._run.take(_with_effort(ahead, middle))] if ahead.time.size else []
        before = self._run.machine.real.copy()
        parts.append(self._run.take(last))
        self._waiting = _part(last, slice(None), follows=True), before
        return _joined(parts)

    def _half(self, piece: MotionBlock, output: ObserverOutput) -> Vector:
        if not piece.follows:
            self._state[:] = 0.0
        acceleration = np.where(
            output.velocity != 0.0,
            (piece.effort - output.friction) / self.observer.inertia.value,
            0.0,
        )
        half = np.empty(piece.time.size)
        assert output.miss is not None
        velocity_interval(
            output.velocity,
            acceleration,
            piece.position,
            output.miss,
            self._sizes,
            self._state,
            half,
        )
        return self._widening * half


def _part(piece: MotionBlock, part: slice, follows: bool | None = None) -> MotionBlock:
    return MotionBlock(
        piece.time[part],
        piece.position[part],
        piece.effort[part],
        piece.follows if follows is None else follows,
    )


def _with_effort(piece: MotionBlock, effort: Vector) -> MotionBlock:
    return MotionBlock(piece.time, piece.position, effort, piece.follows)


def _joined(parts: list[ObserverOutput]) -> ObserverOutput:
    if len(parts) == 1:
        return parts[0]
    time, position, velocity, friction, miss = (
        np.concatenate([getattr(part, name) for part in parts])
        for name in ("time", "position", "velocity", "friction", "miss")
    )
    return ObserverOutput(time, position, velocity, friction, None, miss)
