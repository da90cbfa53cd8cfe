"""Layout of the weak form's rows for a model: columns, windows and constants of the kernels.

    effort - offset - load(x) = inertia a + g viscous v + g asymmetry |v|
                                + g sum_j bend_j (|v| - knee_j)+ s
                                + q sum_j fall_j exp(-(v/w_j)^n) s
                                + sum_d,z dry_d,z f(x, v) + sum_d level_d s
                                + delay d(effort)/dt

A row is this equation, averaged over a window of samples.

    x, v, a        position, velocity and acceleration
    s              direction of the motion, 1 or -1
    (...)+         positive part
    f              dry friction of the model with its Stribeck curve, times q
    bend_j         change of the slope of friction at the speed knee_j
    fall_j         friction that falls with speed on the scale w_j and is not in the model; n is
                   the exponent of the Stribeck curve
    dry_d,z        factor of f in direction d and zone z
    level_d        friction in direction d that is added to f
    delay          time by which the effort acts later than its samples
    g, q           factors of viscous and dry friction at the logged temperature; 1 if the model or
                   the log has no temperature

If the axis equals the model, every dry_d,z is 1, and fall_j, level_d and delay are 0. The same row
is used for all kinds of wear: uniform, by direction, by zone, or additive
(parameter_restriction.py).

The window is so long that the rounding of the encoder disturbs a row by at most NOISE_SHARE of the
dry friction. To fit into a move, the window is at most a third of the time that the axis takes for
the travel at top speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictool.adapters.axis_model import extended_axis, load_of
from frictool.documents.laws import FrictionOverTemperature
from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.friction.position_polynomial import mean_over
from frictool.plant.axis_friction_laws import (
    COULOMB_MAPS,
    COULOMB_PAIR,
    MAP_HIGH,
    MAP_LOW,
    MAPPED,
    MAX_TERMS,
)
from frictool.plant.weak_form import effort_weights, sampled_test_function
from frictool.typing import Vector

SHORTEST = 21  # samples, shortest window
SHORTEST_S = 0.02  # s, shortest window
MOVE_SHARE = 1.0 / 3.0  # longest window relative to the time for the travel at top speed
# standard deviation of a row's error from the encoder's rounding, relative to the mean dry friction
NOISE_SHARE = 0.007
PER_WINDOW = 8  # number of rows that begin within one window
# time on each side of a sample from which its speed is computed, relative to the window
SLOPE_SHARE = 0.2
COUNTS = 2.0 - 1e-6  # counts that must pass in the time SLOPE_SHARE; below 2 because of rounding
SLOWEST = 0.02  # speed relative to the top speed, below which a sample is not used
KNEES = (0.6, 0.8, 1.0, 1.2)  # possible bends of the friction, relative to the model's first knee
# possible bends relative to the top speed, for a model without a knee
FREE_KNEES = (0.4, 0.55, 0.7, 0.85)
# speeds w_j of unmodelled falls, relative to the top speed as in identify/rows/effects.py
FALLS = (0.05, 0.075, 0.115, 0.175, 0.265, 0.4)
KNOWN_FALLS = (0.4, 0.6, 0.85, 1.2, 1.7, 2.5)  # the same, relative to the model's Stribeck velocity
GAP_SPREAD = 1.3  # widest backlash relative to the bench's value, if the bench has no range
ZONES = 6  # number of zones, if the bench or the friction map has a travel
LEAST_FRICTION = 1e-9  # smallest dry friction relative to the effort at the drive's limit


@dataclass(frozen=True)
class WeakFormLayout:
    """Constants of the weak-form rows, SI.

    - period: sample period [s]
    - window: number of samples in a window
    - every: number of samples between two rows
    - reach: number of samples on each side of a sample; their positions determine the speed at the
      sample
    - phi: (window,), weight function, 0 at both ends
    - second: (window,), second difference of phi [1/s^2]
    - effort: (3,), weights of the effort at the sample before, at the sample and at the next sample
    - slowest, fastest: speed limits of usable samples [rad/s | m/s]
    - knees: (h,), speeds at which the slope of friction may change [rad/s | m/s]
    - falls: (m,), speed scales w of friction that falls with speed [rad/s | m/s]
    - edges: (z + 1,), boundaries of the zones [rad | m]; the first and the last zone extend beyond
      the outer boundaries
    - axis: parameters of the axis for the kernels (plant/axis_friction_laws.py)
    - dry: (2, c), polynomials of the model's Coulomb friction [N m | N], backward and forward,
      constant outside `mapped` (2,) [rad | m]
    - count: encoder step [rad | m]
    - gap: widest backlash plus one count [rad | m]; 0 if there is no backlash
    - stops: (2,), positions of the end stops [rad | m]
    - load: array of plant/position_load.py
    - offset: the model's offset [N m | N]
    - friction: mean Coulomb friction over the travel and both directions [N m | N]
    - temperature: dependence of friction on temperature, or None
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
    falls: Vector
    edges: Vector
    axis: Vector
    dry: Vector
    mapped: Vector
    count: float
    gap: float
    stops: Vector
    load: Vector
    offset: float
    friction: float
    temperature: FrictionOverTemperature | None = None

    @property
    def zones(self) -> int:
        """Return the number of zones of the travel."""
        return self.edges.size - 1

    @property
    def acceleration_noise(self) -> float:
        """Return the rms error that rounding causes in a row's acceleration [rad/s^2 | m/s^2]."""
        return _acceleration_noise(self.count, self.second)

    @property
    def fall_names(self) -> tuple[str, ...]:
        """Return the names of the regressors of friction that falls with speed."""
        return tuple(f"fall_{k}" for k in range(self.falls.size))

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the p regressors of a row; the effort is the column after them."""
        zones = range(self.zones)
        bends = [f"bend_{k}" for k in range(self.knees.size)]
        dry = [f"dry_{side}_{zone}" for side in ("backward", "forward") for zone in zones]
        over_speed = ("inertia", "viscous", *bends, *self.fall_names)
        return (*over_speed, *dry, "level_backward", "level_forward", "asymmetry", "delay")


def layout_of(
    model: Model, period: float | None = None, window: int | None = None, zones: int | None = None
) -> WeakFormLayout:
    """Return the layout of the weak-form rows for a model.

    - period: sample period [s]; None for the period in bench.yaml
    - window, zones: number of samples of a window, and number of zones; None for the defaults

    Raises FrictoolError if the model has no dry friction, or if the window is not odd or too short.
    """
    bench = model.bench
    axis = extended_axis(model)
    period = period or bench.sample_period_s
    dry, mapped = _dry(axis)
    travel, top = bench.mechanics.travel, bench.mechanics.top_speed
    low, high = (
        (travel.low, travel.high) if travel is not None else (float(mapped[0]), float(mapped[1]))
    )
    friction = _mean(dry, mapped, low, high)
    constant = bench.actuator.constant.value
    count = bench.encoder.resolution
    if not friction > LEAST_FRICTION * constant * bench.actuator.limit.value:
        raise FrictoolError(
            f"{model.name}: coulomb: found {friction:.3g}; allowed: > 0, "
            "because the wear multiplies the dry friction; identify from logs "
            "in which the axis slips in both directions"
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
    phi = np.concatenate(([0.0], sampled_test_function(window), [0.0]))
    slowest = max(
        COUNTS * count / (reach * period), SLOWEST * top.value if top is not None else 0.0
    )
    return WeakFormLayout(
        period=period,
        window=window,
        every=max(1, window // PER_WINDOW),
        reach=reach,
        phi=phi,
        second=np.convolve(sampled_test_function(window), [1.0, -2.0, 1.0]) / period**2,
        effort=np.array(effort_weights(period, bench.actuator.logged_lag_s)),
        slowest=slowest,
        fastest=3.0 * top.value if top is not None else math.inf,
        knees=_knees(model),
        falls=_falls(model, slowest),
        edges=_edges(low, high, zones),
        axis=axis,
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
        temperature=model.laws.temperature if model.laws is not None else None,
    )


def _edges(low: float, high: float, zones: int | None) -> Vector:
    """Return the boundaries (z + 1,) of the zones; an unbounded travel is one zone."""
    count = zones or (ZONES if high > low and np.isfinite(high - low) else 1)
    return np.array([low, high]) if count == 1 else np.linspace(low, high, count + 1)


def _window(inertia: float, count: float, friction: float, period: float, travelling: float) -> int:
    """Return the length of a window [samples, odd] that averages out the encoder's rounding."""
    longest = max(SHORTEST, MOVE_SHARE * travelling / period)
    window = 2 * (max(SHORTEST, round(SHORTEST_S / period)) // 2) + 1
    while window + 2 <= longest:
        second = np.convolve(sampled_test_function(window), [1.0, -2.0, 1.0]) / period**2
        if inertia * _acceleration_noise(count, second) <= NOISE_SHARE * friction:
            break
        window += 2
    return window


def _acceleration_noise(count: float, second: Vector) -> float:
    return count / math.sqrt(12.0) * float(np.linalg.norm(second))


def _dry(axis: Vector) -> tuple[Vector, Vector]:
    """Return polynomials of the friction over position, and their range of positions (2,).

    The polynomials (2, MAX_TERMS) are backward and forward; the coefficients begin with the lowest
    power.
    """
    dry = np.zeros((2, MAX_TERMS))
    mapped = np.array([-math.inf, math.inf])
    if axis[MAPPED] > 0.0:
        dry[:] = axis[COULOMB_MAPS : COULOMB_MAPS + 2 * MAX_TERMS].reshape(2, MAX_TERMS)
        mapped = axis[MAP_LOW : MAP_HIGH + 1].copy()
    else:
        dry[:, 0] = axis[COULOMB_PAIR : COULOMB_PAIR + 2]
    return dry, mapped


def _mean(dry: Vector, mapped: Vector, low: float, high: float) -> float:
    """Return the mean friction [N m | N] of both directions between positions `low` and `high`."""
    if not np.all(np.isfinite(mapped)) or not low < high:
        return float(np.mean(dry[:, 0]))
    return float(
        np.mean([mean_over(side, float(mapped[0]), float(mapped[1]), low, high) for side in dry])
    )


def _knees(model: Model) -> Vector:
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


def _falls(model: Model, slowest: float) -> Vector:
    known, top = model.parameters.stribeck_velocity, model.bench.mechanics.top_speed
    if known is not None:
        return known.value * np.array(KNOWN_FALLS)
    return np.array(FALLS) * (top.value if top is not None else slowest / SLOWEST)


def _gap(model: Model, count: float) -> float:
    width = model.bench.mechanics.backlash
    if width is None or width.value == 0.0:
        return 0.0
    return max(*width.interval, GAP_SPREAD * width.value) + count
