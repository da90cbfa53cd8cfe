"""Random rigs whose friction falls over the speed from the breakaway to Coulomb friction, and their
breakaway ramps."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictool.engine.axis_motion import advance
from frictool.identify.breakaway.breakaway import Breakaway, breakaway
from frictool.identify.fit_result import SLIDING, Interval
from frictool.identify.motion_record import make_record
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.position_load import PositionLoad, with_load
from frictool.typing import Vector
from studies.rigs.identification_rigs import mass_bench
from tests.identify.arm import PERIOD

# Stribeck velocity over the speed at which the ramp alone passes a count; none: friction falls at
# once
FALLS: dict[str, tuple[float, float] | None] = {
    "none": None,
    "fast": (0.02, 0.2),
    "mid": (0.2, 2.0),
    "slow": (2.0, 20.0),
}
PAUSE = 50  # samples without effort after each motion


class Ramps(NamedTuple):
    """Ramps of `rate` per s, taken back after `counts` of the encoder; noise: standard deviation of
    the effort; the direction changes at least `span` rad from 0."""

    rate: float
    counts: int
    noise: float
    span: float = 0.05


def random_rig(seed: int, fall: str, exponent: float = 2.0) -> tuple[AxisParameters, Ramps]:
    """Return an axis and its test; friction, inertia, encoder and ramps are drawn over orders of
    magnitude."""
    draw = np.random.default_rng([seed, list(FALLS).index(fall)])
    coulomb = 10.0 ** draw.uniform(-1.0, 1.0)
    strength = coulomb * draw.uniform(1.03, 1.5)
    inertia, step = (
        coulomb * 10.0 ** draw.uniform(-3.0, -1.5),
        2.0 * math.pi / 10.0 ** draw.uniform(2.5, 4.3),
    )
    rate = strength / 10.0 ** draw.uniform(-0.3, 0.5)
    axis = AxisParameters(
        inertia, coulomb * 10.0 ** draw.uniform(-3.0, -1.5), coulomb, strength, encoder_step=step
    )
    span = FALLS[fall]
    if span is not None:
        velocity = np.cbrt(step**2 * rate / inertia) * math.exp(draw.uniform(*np.log(span)))
        axis = axis._replace(
            laws=axis.laws._replace(stribeck_velocity=float(velocity), stribeck_exponent=exponent)
        )
    return axis, Ramps(rate, int(draw.integers(2, 12)), strength * 10.0 ** draw.uniform(-3.3, -2.0))


def play(
    axis: AxisParameters,
    ramps: Ramps,
    samples: int,
    seed: int,
    load: PositionLoad = PositionLoad(),  # noqa: B008
) -> tuple[Vector, Vector]:
    """Return the position (n,) by the encoder and the measured effort (n,) of ramps to and fro."""
    state, parameters, step = (
        np.asarray(rest(0.3 * axis.encoder_step)),
        with_load(axis.as_array(), load.as_array()),
        axis.encoder_step,
    )
    position, effort = np.empty(samples), np.empty(samples)
    span = max(15.0 * step, ramps.span)
    level, side, before, pause = 0.0, 1.0, 0, 0
    for k in range(samples):
        count = math.floor(state[0] / step)
        position[k], effort[k] = count * step, side * level
        assert advance(state, side * level, parameters, PERIOD) == 0
        if pause > 0:
            pause, before = pause - 1, count
        elif abs(count - before) >= ramps.counts:
            level, pause = 0.0, PAUSE
            side = -1.0 if state[0] > span else 1.0 if state[0] < -span else side
        else:
            level += ramps.rate * PERIOD
    return position, effort + ramps.noise * np.random.default_rng(seed).standard_normal(samples)


def found_breakaway(
    seed: int, fall: str, folder: Path, samples: int = 40_000, exponent: float = 2.0
) -> tuple[AxisParameters, Breakaway]:
    """Return the axis of a seed and its breakaway at 95 %, with its other parameters known."""
    axis, ramps = random_rig(seed, fall, exponent)
    position, effort = play(axis, ramps, samples, seed)
    log = make_record(
        "ramps", np.arange(samples) * PERIOD, position, effort, axis.encoder_step, 0.0
    )
    known = {name: Interval(*[getattr(axis, name)] * 3) for name in SLIDING}
    return axis, breakaway([log], mass_bench(folder), known, 0.95)
