"""Run of the event-driven engine: samples and events of a body under a sequence of efforts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from frictool.engine import body as fb
from frictool.engine.body import FrictionBody, at_rest
from frictool.engine.drive import EffortFunction
from frictool.engine.extended_friction_motion import EXTENDED_SIZE
from frictool.engine.status_codes import OK
from frictool.engine.stick_slip import run, run_extended
from frictool.friction.kernel_signatures import SLIP_FORCE
from frictool.runtime.kernels import function_pointer
from frictool.typing import Vector

Segments = Sequence[tuple[float, EffortFunction]]

MOST_EVENTS = 10_000


@dataclass(frozen=True)
class Trajectory:
    """Samples and events of a run in SI units.

    - samples (n, 5): samples at `time` (n,)
    - events (m, 4): time, kind, position, velocity (engine/body.py)
    - status: code of engine/status_codes.py; if the status is not OK, the run ended at `reached`
      [s], and later samples are NaN
    - state: final state
    """

    status: int
    reached: float
    time: Vector
    samples: Vector
    events: Vector
    state: Vector

    @property
    def position(self) -> Vector:
        """Return the position x (n,) [m | rad]."""
        return self.samples[:, fb.SAMPLE_POSITION]

    @property
    def velocity(self) -> Vector:
        """Return the velocity v (n,) [m/s | rad/s], exactly 0 at rest."""
        return self.samples[:, fb.SAMPLE_VELOCITY]

    @property
    def effort(self) -> Vector:
        """Return the effort u (n,) [N | N m]."""
        return self.samples[:, fb.SAMPLE_EFFORT]

    @property
    def friction(self) -> Vector:
        """Return the friction force (n,) [N | N m]; at rest, the force that holds the body."""
        return self.samples[:, fb.SAMPLE_FRICTION]

    @property
    def mode(self) -> Vector:
        """Return the mode (n,): 0 at rest, in slip the direction of the slip, 1 or -1."""
        return self.samples[:, fb.SAMPLE_MODE]

    def times_of(self, kind: int = fb.BREAKS_AWAY) -> Vector:
        """Return the times of all events of one kind [s]."""
        times: Vector = self.events[self.events[:, 1] == kind, 0]
        return times


def segment_arrays(
    segments: Segments, times: ArrayLike, start: float
) -> tuple[Vector, Vector, Vector]:
    """Return arrays for the kernels: ends (s,) and efforts (s, 10) of the segments, times (n,).

    Raises ValueError if the ends of the segments do not rise, or if `times` do not ascend or exceed
    the run.
    """
    sample_times = np.array(times, dtype=np.float64, ndmin=1)
    ends = np.array([end for end, _ in segments], dtype=np.float64)
    if not ends.size or not np.all(np.diff(np.concatenate([[start], ends])) > 0.0):
        raise ValueError(
            f"ends of segments: found {ends.tolist()} s; allowed: rising times above {start} s"
        )
    if sample_times.size and not (
        np.all(np.diff(sample_times) >= 0.0)
        and start <= sample_times[0]
        and sample_times[-1] <= ends[-1]
    ):
        raise ValueError(
            "times: found unordered values or values outside the run; allowed: ascending values "
            f"from {start} to {ends[-1]} s"
        )
    return ends, np.stack([drive.as_array() for _, drive in segments]), sample_times


def _extended(state: Vector) -> Vector:
    if state.size == EXTENDED_SIZE:
        return state
    rested = 0.0 if state[fb.DIRECTION] == 0.0 else np.inf
    return np.concatenate([state, [state[fb.VELOCITY], rested, 0.0]])


def simulate(
    body: FrictionBody,
    segments: Segments,
    times: ArrayLike,
    *,
    state: Vector | None = None,
    start: float = 0.0,
    most_events: int = MOST_EVENTS,
) -> Trajectory:
    """Simulate a body from `start` [s] under a sequence of efforts, sampled at `times` (n,).

    Parameters
    ----------
    body
        The body with its friction.
    segments
        Pairs (end [s], drive) in order of time.
    times
        Ascending times [s] within the run.
    state
        State (5,) at the start, not changed; by default, rest at position 0. A body with extended
        friction has a state (8,) (engine/extended_friction_events.py). If `state` of such a body
        is (5,), the film starts in steady state, and the time at rest before `start` is 0 for a
        body at rest, infinite for a slipping body.
    start
        Start of the run [s].
    most_events
        Allowed number of events; one more event ends the run with status EVENTS_FULL.

    Returns
    -------
    Trajectory
        Samples, events and final state.

    Raises
    ------
    ValueError
        If segments or times are not in order, or body or drive are invalid.
    """
    ends, drives, sample_times = segment_arrays(segments, times, start)
    now = np.array(at_rest() if state is None else state, dtype=np.float64)
    samples = np.full((sample_times.size, fb.SAMPLE_SIZE), np.nan)
    events = np.zeros((most_events, fb.EVENT_SIZE))
    force = function_pointer(body.slip_force, SLIP_FORCE)
    array = body.as_array()
    if body.extension is None:
        law = np.array(body.law, dtype=np.float64)
        status, reached, happened = run(
            force, law, array, now, start, ends, drives, sample_times, samples, events
        )
    else:
        now = _extended(now)
        outcome = run_extended(
            force, *body.extension, array, now, start, ends, drives, sample_times, samples, events
        )
        status, reached, happened = outcome
    if status != OK:
        samples[sample_times > reached] = np.nan
    return Trajectory(status, reached, sample_times, samples, events[:happened].copy(), now)
