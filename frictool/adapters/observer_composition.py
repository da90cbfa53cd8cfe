"""Observer document as a block of a program.

    position, effort ──▶ block of the document's kind ──▶ position, velocity, friction, wear

The program contains only the observer (for a log), or the observer and a controller. The estimates
at a sample use the position up to this sample and the effort before this sample. A controller can
therefore use the estimates at the same sample.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictool.control import switched_observer, tracking_observer
from frictool.control.observer_output import ObserverNodes
from frictool.control.program import Program, ProgramNode
from frictool.control.switched_observer import SlipMode, SwitchedParameters
from frictool.control.tracking_observer import TrackingParameters
from frictool.documents.bench import Bench
from frictool.documents.observer import FrictionMap, Mode, Observer, Tracking

GRID = 257  # number of positions at which a map is evaluated
MARGIN = 0.5  # reach of positions and references beyond each end of the travel, in travel widths
TOP_SPEEDS = 4.0  # bound of a measured or estimated velocity in top speeds of the bench
# largest friction divided by the model's friction f, alpha_max of (6.13); for additive wear, bound
# of (f + alpha)/max f
MOST_WEAR = 3.0


class ObserverProgram(NamedTuple):
    """Program with the inputs `position` [rad | m] and `effort` [N m | N], and the estimates."""

    program: Program
    estimates: ObserverNodes


def observer_program(observer: Observer) -> ObserverProgram:
    """Return a program that contains only the observer; its output is the estimated velocity."""
    program = Program()
    most = _most_effort(observer.bench)
    position = program.input("position", *reach(observer.bench))
    effort = program.input("effort", -most, most)
    estimates, move = observer_block(program, position, observer)
    move(effort)
    program.output = estimates.velocity
    return ObserverProgram(program, estimates)


def observer_block(
    program: Program, position: ProgramNode, observer: Observer
) -> tuple[ObserverNodes, Callable[[ProgramNode], None]]:
    """Return the estimates for a measured position [rad | m], and a function `move(effort)`.

    `move` adds the update of the states to the program; its argument is the effort [N m | N] that
    acts until the next sample.
    """
    if observer.tracking is not None:
        parameters = tracking_facts(observer, observer.tracking)
        estimates, tracked = tracking_observer.write_prediction(program, position, parameters)
        return estimates, lambda effort: tracking_observer.write_update(
            program, effort, tracked, parameters
        )
    facts = switched_facts(observer)
    estimates, chosen = switched_observer.write_prediction(program, position, facts)
    return estimates, lambda effort: switched_observer.write_correction(
        program, position, effort, estimates, chosen, facts
    )


def switched_facts(observer: Observer) -> SwitchedParameters:
    """Return the parameters of the switched observer.

    Raises ValueError if the document lacks the stuck mode or the modes of a direction.
    """
    switched, friction = observer.switched, observer.friction
    assert switched is not None
    stuck = next((mode for mode in switched.modes if mode.direction == 0), None)
    forward, backward = (
        _cells([mode for mode in switched.modes if mode.direction == side]) for side in (1, -1)
    )
    if stuck is None or not forward or not backward:
        raise ValueError(
            "switched.modes: a direction is missing; needed: modes of the directions -1, 0 (stuck) "
            "and 1"
        )
    additive = switched.wear == "additive"
    return SwitchedParameters(
        period=observer.sample_period_s,
        inertia=observer.inertia.value,
        switch_speed=switched.switch_speed.value,
        forward=forward,
        backward=backward,
        stuck=(stuck.gains[0][0], stuck.gains[1][0]),
        kept=switched.stuck_speed,
        additive=additive,
        curves=(friction.forward, friction.backward),
        travel=(friction.over.low, friction.over.high),
        viscous=friction.viscous,
        offset=friction.offset,
        top_speed=top_speed(observer.bench),
        wear=(-_largest(friction), (MOST_WEAR - 1.0) * _largest(friction))
        if additive
        else (0.0, MOST_WEAR),
    )


def tracking_facts(observer: Observer, tracking: Tracking) -> TrackingParameters:
    """Return the parameters of the tracking observer."""
    friction, bench, gap = observer.friction, observer.bench, tracking.backlash
    return TrackingParameters(
        period=observer.sample_period_s,
        inertia=observer.inertia.value,
        gains=tracking.gains,
        cell=tracking.cell,
        step=bench.encoder.resolution,
        forward=friction.forward,
        backward=friction.backward,
        travel=(friction.over.low, friction.over.high),
        breakaway=tracking.breakaway_ratio,
        viscous=friction.viscous,
        knees=tuple((knee.above.value, knee.steeper) for knee in tracking.knees),
        offset=friction.offset,
        backlash=0.0 if gap is None else gap.width,
        loose=0.0 if gap is None else gap.friction,
        top_speed=top_speed(bench),
        most_effort=_most_effort(bench),
    )


def _largest(friction: FrictionMap) -> float:
    over = np.linspace(friction.over.low, friction.over.high, GRID)
    return float(
        max(
            np.max(np.polynomial.Polynomial(curve)(over))
            for curve in (friction.forward, friction.backward)
        )
    )


def _cells(modes: list[Mode]) -> tuple[SlipMode, ...]:
    ordered = sorted(modes, key=lambda mode: mode.over[0] if mode.over is not None else -math.inf)
    rows = [tuple(row[0] for row in mode.gains) for mode in ordered]
    highs = [mode.over[1] if mode.over is not None else math.inf for mode in ordered]
    return tuple(
        SlipMode(high, mode.friction, (row[0], row[1], row[2]))
        for mode, row, high in zip(ordered, rows, highs, strict=True)
    )


def reach(bench: Bench) -> tuple[float, float]:
    """Return the range of references and positions [rad | m]: the travel plus a margin."""
    travel = bench.mechanics.travel
    if travel is None:
        return -math.inf, math.inf
    beyond = MARGIN * (travel.high - travel.low)
    return travel.low - beyond, travel.high + beyond


def top_speed(bench: Bench) -> float:
    """Return the bound of a speed [rad/s | m/s]: TOP_SPEEDS times the top speed in bench.yaml."""
    top = bench.mechanics.top_speed
    return math.inf if top is None else TOP_SPEEDS * top.value


def _most_effort(bench: Bench) -> float:
    return bench.actuator.constant.value * bench.actuator.limit.value
