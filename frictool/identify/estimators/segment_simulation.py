"""Simulation of segments of records with an axis model, and fit of the model's parameters.

- open loop: the measured effort drives the model; the residual is the error of the position
- closed loop: the bench's controller (`PositionServo`) drives the model along the measured
  reference; the residual is the error of the effort

The parameters are searched by a Gauss-Newton method in a trust region, with a Jacobian by finite
differences.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.engine.status_codes import OK
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.load_terms import (
    POSITIVE,
    SMALLEST,
    MotionSize,
    axis_and_load,
    names_of,
    scale_of,
    start_of,
)
from frictool.identify.rows.segments import RecordSegment, of_each_record
from frictool.identify.rows.strokes import find_strokes
from frictool.plant.axis import BACKLASH, GAP, VELOCITY
from frictool.typing import Matrix, Vector

if TYPE_CHECKING:
    from frictool.engine.bench_position_loop import PositionServo

STEP = 1e-4  # step of the differences, in units of a parameter's scale
MOST_RUNS = 60  # largest number of evaluations in the trust region
# largest residual of a simulation, and residual of a failed simulation, relative to the signals
FAILED = 1e3
# share of a closed-loop segment that is ignored at its start, since the log does not give the
# initial state of the loop
SETTLING = 0.03
OBSERVER = 10.0  # number of time constants of the observer in a median stroke


@dataclass(frozen=True)
class SegmentSimulation:
    """Simulation of segments of the records with one model of the axis.

    - terms: load terms of the model
    - servo: the bench's controller; None for the open loop
    - fixed: values of the parameters that are not fitted, SI
    """

    segments: Sequence[RecordSegment]
    bench: Bench
    terms: tuple[str, ...] = ()
    servo: PositionServo | None = None
    fixed: Mapping[str, float] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the fitted parameters."""
        return tuple(name for name in names_of(self.terms) if name not in self.fixed)

    def residual(self, values: Mapping[str, float]) -> Vector:
        """Return the measured minus the simulated signal (n,) over all segments.

        The signal is the position [rad | m] or, in closed loop, the effort [N m | N].
        """
        return np.concatenate([self.of_segment(segment, values) for segment in self.segments])

    def of_segment(
        self, segment: RecordSegment, values: Mapping[str, float], error: Vector | None = None
    ) -> Vector:
        """Return the residual (m,) of one segment.

        In open loop, `error` (m,) [N m | N] is added to the measured effort. Each residual is
        limited to `failed_residual`, which is also the residual of a failed simulation.
        """
        p, load = axis_and_load(values, self.bench, segment.record)
        state = _state(segment, p)
        n = segment.last - segment.first
        x, v, u = np.empty(n), np.empty(n), np.empty(n)
        measured = segment.position
        effort = segment.effort
        period = segment.record.period
        if self.servo is not None:
            from frictool.engine.bench_position_loop import follow_reference  # loads the engine

            assert segment.reference is not None
            status = follow_reference(
                p,
                load,
                state,
                np.array(self.servo),
                segment.reference,
                float(effort[0]),
                period,
                x,
                v,
                u,
            )
            out = effort - u
            out[: int(SETTLING * n)] = 0.0
        else:
            from frictool.engine.effort_replay import FREE, replay  # loads the engine

            acting = effort if error is None else effort + error
            status = replay(p, load, state, acting, measured, FREE, period, x, v)
            out = measured - x
        failed = failed_residual(segment)
        if status != OK or not np.all(np.isfinite(out)):
            return np.full(n, failed)
        return np.asarray(np.clip(out, -failed, failed))

    def missing_effort(self, values: Mapping[str, float]) -> list[Vector]:
        """Return the effort error (m,) [N m | N] of each segment.

        An observer makes the model follow the measured position. The effort error is the effort
        that the observer adds to the model.
        """
        gains = of_each_record(self.segments, observer_gains)
        return [
            self._observe(segment, values, gain)
            for segment, gain in zip(self.segments, gains, strict=True)
        ]

    def _observe(
        self, segment: RecordSegment, values: Mapping[str, float], gains: Vector
    ) -> Vector:
        from frictool.engine.effort_replay import replay  # loads the engine

        p, load = axis_and_load(values, self.bench, segment.record)
        period = segment.record.period
        n = segment.last - segment.first
        x, v = np.empty(n), np.empty(n)
        if (
            replay(
                p, load, _state(segment, p), segment.effort, segment.position, gains, period, x, v
            )
            != OK
        ):
            raise UnusableLogs(
                f"{segment.record.name}: the simulation does not follow the measured position"
            )
        return np.asarray(values["inertia"] * gains[1] / period * (segment.position - x))


def _state(segment: RecordSegment, p: Vector) -> Vector:
    """Return the initial state (7,) of a segment; a moving axis starts with its backlash closed."""
    state = segment.start()
    if state[VELOCITY] != 0.0:
        state[GAP] = np.sign(state[VELOCITY]) * 0.5 * p[BACKLASH]
    return state


def observer_rate(record: MotionRecord) -> float:
    """Return the rate [1/s] at which the observer's error decays.

    The decay is much faster than a stroke, and much slower than a sample period.
    """
    lengths = np.bincount(find_strokes(record).number)
    return min(OBSERVER / (float(np.median(lengths)) * record.period), 0.1 / record.period)


def observer_gains(record: MotionRecord) -> Vector:
    """Return the observer's gains (2,) for position [-] and velocity [1/s]."""
    rate = observer_rate(record)
    return np.array([2.0 * rate * record.period, rate**2 * record.period])


@dataclass(frozen=True)
class SimulationFit:
    """Result of a fit by simulation.

    - values: fitted and fixed parameters, SI
    - residual: measured minus simulated signal, (n,)
    - jacobian: derivatives of the residual with respect to the fitted parameters, (n, p)
    """

    values: dict[str, float]
    residual: Vector
    jacobian: Matrix


def failed_residual(segment: RecordSegment) -> float:
    """Return the large residual that is used for a failed simulation of a segment."""
    return FAILED * (float(np.ptp(segment.position)) + float(np.ptp(segment.effort)))


def motion_size(segments: Sequence[RecordSegment]) -> MotionSize:
    """Return travel, largest speed and rms effort of the motion in all segments."""
    travel = speed = squares = 0.0
    for segment in segments:
        position, period = segment.position, segment.record.period
        span = max(1, position.size // 100)
        travel = max(travel, float(np.ptp(position)))
        moved = float(np.max(np.abs(position[span:] - position[:-span])))
        speed = max(speed, moved / (span * period))
        squares += float(segment.effort @ segment.effort)
    samples = sum(segment.effort.size for segment in segments)
    return MotionSize(travel, speed, float(np.sqrt(squares / samples)))


def estimate(simulated: SegmentSimulation, known: Mapping[str, float]) -> SimulationFit:
    """Return the parameters that minimise the squared residual of a simulation.

    The search starts at the parameters `known` [SI]. Raises UnusableLogs if the search does not
    converge, or if the simulation with the final parameters fails or deviates far from the measured
    signal.
    """
    names = simulated.names
    motion = motion_size(simulated.segments)
    scale = np.array([scale_of(name, known, motion) for name in names])
    start = np.array([start_of(name, known) for name in names]) / scale
    low = np.array([SMALLEST if name in POSITIVE else -np.inf for name in names])

    def residual(z: Vector) -> Vector:
        return simulated.residual(
            {**simulated.fixed, **dict(zip(names, (z * scale).tolist(), strict=True))}
        )

    size = max(float(np.sqrt(np.mean(residual(start) ** 2))), 1e-300)
    solution = scipy.optimize.least_squares(
        lambda z: residual(z) / size,
        np.maximum(start, 2.0 * low),
        bounds=(low, np.inf),
        diff_step=STEP,
        x_scale=1.0,
        max_nfev=MOST_RUNS,
        xtol=1e-6,
        ftol=1e-7,
        gtol=1e-9,
    )
    if not solution.success and solution.status != 0:
        raise UnusableLogs(f"the output-error search does not converge: {solution.message}")
    if float(np.max(np.abs(solution.fun))) * size >= min(map(failed_residual, simulated.segments)):
        raise UnusableLogs("the simulation does not follow the measured signal; use least-squares")
    values = dict(zip(names, (solution.x * scale).tolist(), strict=True))
    return SimulationFit(
        {**simulated.fixed, **values}, solution.fun * size, solution.jac * size / scale
    )
