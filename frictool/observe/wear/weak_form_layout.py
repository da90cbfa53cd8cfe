"""What the rows of the weak form hold for a model, and how they are cut from the samples: all that
the kernels are told.

    effort - offset - load(x) = inertia a + viscous v + asymmetry |v| + sum_j bend_j (|v| - knee_j)+
    s
                                + sum_d,z dry_d,z f(x, s) + sum_d level_d s

s is the direction of the motion, f the model's dry friction (4.43)-(4.44) at the position; dry_d,z
is 1 in every direction d and zone z of a plant that is as the model says, level_d 0. That wear is
the same everywhere, or in a direction, or in a zone, or is a constant added, is a restriction of
these columns (restriction.py), and one row serves them all.

The window is as long as the encoder asks for, so that its counts move a row by no more than
NOISE_SHARE of the dry friction, and no longer than a third of the time that the travel takes at top
speed: a longer one would hold no move.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.friction.position_polynomial import mean_over
from frictool.friction.stribeck import straight_from
from frictool.plant.axis import COULOMB
from frictool.plant.axis_friction_laws import (
    COULOMB_MAPS,
    COULOMB_PAIR,
    MAP_HIGH,
    MAP_LOW,
    MAPPED,
    MAX_TERMS,
    PLAIN_SIZE,
)
from frictool.plant.axis_model import axis_of, load_of
from frictool.plant.weak_form import bell, effort_weights

Vector = NDArray[np.float64]

SHORTEST = 21  # samples of a window
SHORTEST_S = 0.02
MOVE_SHARE = 1.0 / 3.0  # of the time that the travel takes at top speed
NOISE_SHARE = (
    0.007  # of the mean dry friction, that the encoder's counts leave in a row (standard deviation)
)
PER_WINDOW = 8  # rows that begin in the time of one window
SLOPE_SHARE = 0.2  # of the window, before and after a sample, over which its speed is taken
COUNTS = 2.0 - 1e-6  # that have to pass in that time, but for rounding
SLOWEST = 0.02  # of the top speed, below which a sample is not taken to slip
KNEES = (0.6, 0.8, 1.0, 1.2)  # of the model's first knee: where friction may bend
FREE_KNEES = (0.4, 0.55, 0.7, 0.85)  # of the top speed, where the model has none
GAP_SPREAD = 1.3  # widest backlash over the bench's, where the bench gives no range
ZONES = 6  # of the travel, where friction varies over it
LEAST_FRICTION = 1e-9  # of what the drive can give at its limit: less is none


@dataclass(frozen=True)
class WeakFormLayout:
    """SI. period [s]; window, every, reach: samples of a window, between rows, of the slope to
    either side of a sample.

    phi (window,): the bell, 0 at either end; second (window,): its second difference [1/s^2].
    effort (3,): what the samples before, at and after weigh in the effort. slowest [rad/s | m/s].
    knees (h,) [rad/s | m/s]. edges (z + 1,) of the zones [rad | m], beyond them as at the ends. dry
    (2, c): polynomials of the model's friction backward, forward [N m | N], held beyond `mapped`
    (2,) [rad | m]. count: of the encoder. gap: widest backlash and a count; 0: none. stops (2,):
    between which the axis is free. load: plant/position_load.py. offset [N m | N]. friction [N m |
    N]: mean of the dry friction over the travel and both directions.
    """

    period: float
    window: int
    every: int
    reach: int
    phi: Vector
    second: Vector
    effort: Vector
    slowest: float
    fastest: float
    knees: Vector
    edges: Vector
    dry: Vector
    mapped: Vector
    count: float
    gap: float
    stops: Vector
    load: Vector
    offset: float
    friction: float

    @property
    def zones(self) -> int:
        """How many zones."""
        return self.edges.size - 1

    @property
    def names(self) -> tuple[str, ...]:
        """The columns of a row, in their order; the effort follows them."""
        zones = range(self.zones)
        bends = [f"bend_{k}" for k in range(self.knees.size)]
        dry = [f"dry_{side}_{zone}" for side in ("backward", "forward") for zone in zones]
        return ("inertia", "viscous", *bends, *dry, "level_backward", "level_forward", "asymmetry")


def layout_of(
    model: Model, period: float | None = None, window: int | None = None, zones: int | None = None
) -> WeakFormLayout:
    """The rows for a model at its bench's period, or another [s].

    Raises FrictoolError where the model has no dry friction, whose wear there is none of, and for a
    window that is too short.
    """
    bench, axis = model.bench, axis_of(model).as_array()
    period = period or bench.sample_period_s
    dry, mapped = _dry(axis)
    travel, top = bench.mechanics.travel, bench.mechanics.top_speed
    low, high = (
        (travel.low, travel.high) if travel is not None else (float(mapped[0]), float(mapped[1]))
    )
    friction = _mean(dry, mapped, low, high)
    constant, count = bench.actuator.constant.value, bench.encoder.resolution
    if not friction > LEAST_FRICTION * constant * bench.actuator.limit.value:
        raise FrictoolError(
            f"{model.name}: coulomb: found {friction:.3g}; allowed: > 0, since wear is that of the dry friction; identify from logs that "
            "slip in both directions"
        )
    if window is None:
        inertia = model.parameters.inertia.value
        window = _window(
            inertia,
            count,
            friction,
            period,
            (high - low) / top.value if top is not None and high > low else math.inf,
        )
    if window < 5 or window % 2 == 0:
        raise FrictoolError(f"window: found {window} samples; allowed: an odd number of at least 5")
    reach = max(1, round(SLOPE_SHARE * window))
    phi = np.concatenate(([0.0], bell(window), [0.0]))
    stribeck = model.parameters.stribeck_velocity
    exponent = model.laws.stribeck_exponent if model.laws is not None else 2.0
    return WeakFormLayout(
        period=period,
        window=window,
        every=max(1, window // PER_WINDOW),
        reach=reach,
        phi=phi,
        second=np.convolve(bell(window), [1.0, -2.0, 1.0]) / period**2,
        effort=np.array(effort_weights(period, bench.actuator.loop_time_constant_s)),
        slowest=max(
            COUNTS * count / (reach * period),
            SLOWEST * top.value if top is not None else 0.0,
            straight_from(stribeck.value, exponent) if stribeck is not None else 0.0,
        ),
        fastest=3.0 * top.value if top is not None else math.inf,
        knees=_knees(model),
        edges=np.linspace(
            low, high, (zones or (ZONES if high > low and np.isfinite(high - low) else 1)) + 1
        ),
        dry=dry,
        mapped=mapped,
        count=count,
        gap=_gap(model, count),
        stops=np.array(
            [travel.low + count, travel.high - count]
            if travel is not None
            else [-math.inf, math.inf]
        ),
        load=np.asarray(load_of(model).as_array()),
        offset=model.parameters.offset.value,
        friction=friction,
    )


def _window(inertia: float, count: float, friction: float, period: float, travelling: float) -> int:
    """Samples, odd. The counts' error in a row is inertia count/sqrt(12) |phi''|, which falls with
    the window's length to the 2.5th."""
    longest = max(SHORTEST, MOVE_SHARE * travelling / period)
    window = 2 * (max(SHORTEST, round(SHORTEST_S / period)) // 2) + 1
    while window + 2 <= longest:
        second = np.convolve(bell(window), [1.0, -2.0, 1.0]) / period**2
        if (
            inertia * count / math.sqrt(12.0) * float(np.linalg.norm(second))
            <= NOISE_SHARE * friction
        ):
            break
        window += 2
    return window


def _dry(axis: Vector) -> tuple[Vector, Vector]:
    """Coefficients (2, MAX_TERMS) backward, forward [N m | N], lowest power first, and between
    which positions (2,) they hold."""
    dry, mapped = np.zeros((2, MAX_TERMS)), np.array([-math.inf, math.inf])
    if axis.size == PLAIN_SIZE:
        dry[:, 0] = axis[COULOMB]
    elif axis[MAPPED] > 0.0:
        dry[:] = axis[COULOMB_MAPS : COULOMB_MAPS + 2 * MAX_TERMS].reshape(2, MAX_TERMS)
        mapped = axis[MAP_LOW : MAP_HIGH + 1].copy()
    else:
        dry[:, 0] = axis[COULOMB_PAIR : COULOMB_PAIR + 2]
    return dry, mapped


def _mean(dry: Vector, mapped: Vector, low: float, high: float) -> float:
    """The mean friction over [low, high] and both directions [N m | N]."""
    if not np.all(np.isfinite(mapped)) or not low < high:
        return float(np.mean(dry[:, 0]))
    return float(
        np.mean([mean_over(side, float(mapped[0]), float(mapped[1]), low, high) for side in dry])
    )


def _knees(model: Model) -> Vector:
    """Where friction over speed may bend, rising [rad/s | m/s]; of the model's own knees none is
    missing."""
    top = model.bench.mechanics.top_speed
    regimes = model.laws.regimes if model.laws is not None else ()
    if regimes:
        first = regimes[0].above.value
        return np.array(
            sorted(
                {
                    *(share * first for share in KNEES),
                    *(regime.above.value for regime in regimes[1:]),
                }
            )
        )
    return np.array([share * top.value for share in FREE_KNEES] if top is not None else [])


def _gap(model: Model, count: float) -> float:
    """The widest that the backlash may be, with the count that hides where it begins [rad | m]; 0:
    there is none."""
    width = model.bench.mechanics.backlash
    if width is None or width.value == 0.0:
        return 0.0
    return max(*width.interval, GAP_SPREAD * width.value) + count
