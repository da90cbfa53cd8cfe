"""Breakaway from ramps (thesis 4.3), corrected for the delay of the encoder.

In a breakaway ramp, the effort rises until the axis starts to move. This start is the onset. The
thesis takes the largest effort before each visible motion. This maximum is too high by several
steps of the ramp, because the axis moves for some time before the encoder shows the motion. Here a
line is fitted to the effort at rest. The breakaway is the value of this line at the time of the
onset. The time of the onset is computed from the later motion (`onset`), with the inertia and the
friction in slip. The uncertainty of inertia and friction widens the interval of the breakaway.

The breakaway is constant, or a function of position and direction (`position_law`). The friction in
slip is assumed to be proportional to the breakaway (thesis 4.42).

- The mean over both directions cancels an offset of the effort.
- After the onset, friction decreases with speed from the breakaway to Coulomb friction (Stribeck
  curve). The Stribeck velocity comes from another log, or from the times at which the encoder's
  count changes (`stribeck_velocity`). If the Stribeck velocity 0 agrees with these times, friction
  is assumed to drop at the onset. The interval covers every Stribeck curve that agrees with these
  times.
- The interval contains the spread between onsets (jackknife) and the ranges of the axis's
  parameters (`combined_interval`). A sampled ramp rises by one step per sample. Two errors of half
  a step, which do not average out, are added: the breakaway lies anywhere within a step, and the
  log shows a change of the encoder up to half a sample late.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.polynomial.polynomial import polyval

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.breakaway.onset_friction import OnsetData, onset_data
from frictool.identify.breakaway.position_law import (
    PolynomialOrders,
    choose_structure,
    fit_polynomials,
    sides_of,
)
from frictool.identify.breakaway.rising_friction import RisingFriction, rising_friction
from frictool.identify.breakaway.stribeck_velocity import StribeckVelocityRange
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import LeastSquaresSolution, SingularRegressors
from frictool.typing import Vector

UNIFORM = float(np.sqrt(3.0))  # ratio of half a range to its standard deviation
LIKE_A_LOAD = 3.0  # least ratio of the changes of load and friction over the travel
ROUNDS = 3  # iterations between the onsets and the shape of friction over position
GRID_POINTS = 200  # grid points over the range at which the breakaway law must be positive


@dataclass(frozen=True)
class BreakawayOverPosition:
    """Breakaway as a polynomial of the position over [low, high], rad | m.

    - forward, backward: mean breakaway in each direction, N m | N
    - powers: polynomial coefficients of the forward and of the backward direction, in SI units,
      constant term first
    - coefficients: intervals of the polynomial coefficients
    - common: True if both directions have the same polynomial
    """

    low: float
    high: float
    forward: Interval
    backward: Interval
    powers: tuple[tuple[float, ...], tuple[float, ...]]
    coefficients: tuple[tuple[Interval, ...], tuple[Interval, ...]]
    common: bool

    def load_slope(self) -> float | None:
        """Return the slope of a load [N m/rad | N/m] that explains the law better than friction.

        A load raises the breakaway in one direction and lowers it in the other; friction over
        position changes both alike. The result is the slope of (forward - backward)/2 if this
        varies over the travel at least LIKE_A_LOAD times as much (standard deviation) as the mean
        of both. Otherwise, and if both directions have a common law, the result is None.
        """
        position = np.linspace(self.low, self.high, 50)
        forward, backward = (polyval(position, powers) for powers in self.powers)
        load, friction = 0.5 * (forward - backward), 0.5 * (forward + backward)
        if self.common or np.std(load) < LIKE_A_LOAD * np.std(friction):
            return None
        return float(np.polyfit(position, load, 1)[0])


@dataclass(frozen=True)
class Breakaway:
    """Breakaway identified from logs of ramps.

    - interval: mean breakaway, N m | N; if `rising` is not None, the breakaway after a long rest
    - forward, backward: mean |effort| at the onsets of each direction, N m | N; NaN without onsets
    - onsets: number of onsets
    - delay: mean effort that was subtracted because the encoder shows the motion late, N m | N
    - position: position of each onset, (n,), rad | m
    - direction: direction of each onset, (n,), +1 or -1
    - friction: |effort - offset| at each onset, (n,), N m | N
    - fall: Stribeck curves after the onset for which `interval` is valid
    - by_position: polynomials over position; None if the breakaway is constant
    - rising: law over the time at rest; None if the breakaway does not grow with this time
    """

    interval: Interval
    forward: float
    backward: float
    onsets: int
    delay: float
    position: Vector
    direction: Vector
    friction: Vector
    fall: StribeckVelocityRange
    by_position: BreakawayOverPosition | None = None
    rising: RisingFriction | None = None

    @property
    def parameter(self) -> Interval:
        """Return the mean breakaway; of forward ramps only, if breakaway varies with position."""
        return self.interval if self.by_position is None else self.by_position.forward


def breakaway(
    records: list[MotionRecord],
    bench: Bench,
    axis: Mapping[str, Interval],
    confidence: float,
    stribeck: StribeckVelocityRange | None = None,
) -> Breakaway:
    """Compute the breakaway from records of ramps.

    - axis: intervals of `inertia`, `viscous`, `coulomb` and `offset`
    - stribeck: Stribeck velocity that was identified from another log; None to use the range that
      the onsets allow

    If all ramps have the same direction, the offset is subtracted. Raises UnusableLogs if neither
    direction has five onsets, or if a load starts the axis.
    """
    data = onset_data(records, bench)
    nominal = {name: known.value for name, known in axis.items()}
    try:
        fit = _fit(data, nominal)
        fall = stribeck or data.fall_range(axis, fit.shape, confidence)
        if fall.velocity > 0.0:
            data = replace(data, fall=fall.value)
            fit = _fit(data, nominal)
        lag_free = any(record.lag == 0.0 for record in records)
        half_step = 0.5 * max(o.rate for o in data.onsets) * records[0].period if lag_free else 0.0
        errors = _errors(data, fit, axis, fall, half_step, confidence)
    except SingularRegressors as error:
        raise UnusableLogs(
            f"the breakaways do not determine how friction varies with position: {error}"
        ) from None
    positions = data.positions
    levels = _levels(fit.structure)
    mean = errors.interval(np.mean(levels, axis=0))
    rising = law = None
    if fit.structure.constant:
        rested = np.array([onset.rested for onset in data.onsets])
        rising = rising_friction(rested, positions.direction, fit.friction, confidence)
    elif len(levels) == 2:
        law = _by_position(data, fit, errors)
        _refuse_loaded(law, bench)
    if rising is not None:
        mean = _wider(rising.full, mean)
    start = data.rest(nominal, fit.shape)[0]
    seen = data.table.efforts(nominal, fit.shape, start, fall.value)[0]
    forward, backward = (
        float(np.mean(seen[side])) if side.any() else np.nan
        for side in (positions.direction > 0.0, positions.direction < 0.0)
    )
    delay = float(np.mean([onset.level for onset in data.onsets]) - np.mean(seen))
    friction = fit.friction
    if law is None and data.offset is not None:  # `law` keeps the offset of the bench
        friction = friction + (data.offset - nominal["offset"]) * positions.direction
    return Breakaway(
        mean,
        forward,
        backward,
        len(data.onsets),
        delay,
        positions.position,
        positions.direction,
        friction,
        fall,
        law,
        rising,
    )


def _refuse_loaded(law: BreakawayOverPosition, bench: Bench) -> None:
    position = np.linspace(law.low, law.high, GRID_POINTS)
    for side, powers in zip(("forward", "backward"), law.powers, strict=True):
        level = np.polynomial.polynomial.polyval(position, np.array(powers))
        least = int(np.argmin(level))
        if level[least] <= 0.0:
            length, unit = si_unit("position", bench.axis), si_unit("effort", bench.axis)
            raise UnusableLogs(
                f"the breakaway {side} is {level[least]:.3g} {unit} at {position[least]:.3g} "
                f"{length}; allowed: above 0; remove the load (gravity, a spring), or name it in "
                "load.terms and add a log of sliding"
            )


def _wider(full: Interval, mean: Interval) -> Interval:
    """Return `full` with both half widths enlarged to sqrt(full^2 + mean^2).

    The half width of `mean` includes the uncertainty of the axis parameters.
    """
    down = float(np.hypot(full.half_width, mean.value - mean.low))
    up = float(np.hypot(full.half_width, mean.high - mean.value))
    return Interval(full.value, full.value - down, full.value + up)


@dataclass(frozen=True)
class BreakawayFit:
    """Breakaway over position as fitted polynomials, and the friction at the onsets.

    - structure: orders of the polynomials
    - shape: breakaway at the onsets divided by the mean, (n,); None if the breakaway is constant
    - solution: least-squares solution for the coefficients of the polynomials
    - friction: breakaway at the onsets, (n,), N m | N
    """

    structure: PolynomialOrders
    shape: Vector | None
    solution: LeastSquaresSolution
    friction: Vector


def _fit(data: OnsetData, nominal: Mapping[str, float]) -> BreakawayFit:
    shape: Vector | None = None
    for _ in range(ROUNDS):
        friction = data.friction(nominal, shape)
        structure = choose_structure(data.positions, friction)
        solution = fit_polynomials(data.positions, friction, structure)
        if structure.constant:
            break
        shape = data.shape(structure, solution.value)
    return BreakawayFit(structure, shape, solution, friction)


def _levels(structure: PolynomialOrders) -> list[Vector]:
    """Return weights (p,) for each direction with onsets.

    The sum of the fitted coefficients (p,) times these weights is the direction's mean breakaway.
    """
    if structure.common:
        unit = np.eye(structure.orders[0] + 2)
        return [unit[0], unit[0]]
    sizes = [order + 1 for order in structure.orders]
    unit = np.eye(sum(sizes))
    return [unit[first] for first, size in zip((0, sizes[0]), sizes, strict=True) if size]


@dataclass(frozen=True)
class BreakawayErrors:
    """Errors of the coefficients (p,) of the polynomials of a `BreakawayFit`.

    - ranges: for each axis parameter and for the rest position, changes (p,) of the coefficients
      if the parameter or position is at the low and at the high end of its interval
    - falls: for each allowed Stribeck curve, changes (p,) of the coefficients relative to those for
      the nominal curve
    - half_step: half of the increase of a ramp in one sample, N m | N
    """

    solution: LeastSquaresSolution
    ranges: list[tuple[Vector, Vector]]
    falls: list[Vector]
    half_step: float
    confidence: float

    def interval(self, weights: Vector) -> Interval:
        """Return the interval of the sum of the coefficients times `weights` (p,)."""
        value = float(weights @ self.solution.value)
        statistical = np.linalg.norm(weights * self.solution.half_width(self.confidence))
        deviation = float(statistical) / float(scipy.special.ndtri(0.5 + 0.5 * self.confidence))
        ends = [(float(weights @ low), float(weights @ high)) for low, high in self.ranges]
        other = [float(weights @ shift) for shift in self.falls]
        down, up = (
            self.half_step
            + max(0.0, *(sign * shift for shift in other))
            + half_width(
                self.confidence,
                deviation,
                [self.half_step, *(max(0.0, sign * low, sign * high) for low, high in ends)],
            )
            for sign in (-1.0, 1.0)
        )
        return Interval(value, value - down, value + up)


def _errors(
    data: OnsetData,
    fit: BreakawayFit,
    axis: Mapping[str, Interval],
    fall: StribeckVelocityRange,
    half_step: float,
    confidence: float,
) -> BreakawayErrors:
    nominal = {name: known.value for name, known in axis.items()}
    design = data.positions.design(fit.structure)
    friction = data.friction(nominal, fit.shape)

    def moved(end: Vector) -> Vector:
        return np.asarray(np.linalg.lstsq(design, end - friction, rcond=None)[0], dtype=np.float64)

    def at(name: str, value: float) -> Vector:
        return moved(data.friction({**nominal, name: value}, fit.shape))

    low, high = (moved(data.friction(nominal, fit.shape, end)) for end in (-UNIFORM, UNIFORM))
    falls = [replace(data, fall=end) for end in fall.ends]
    return BreakawayErrors(
        fit.solution,
        [*((at(name, one.low), at(name, one.high)) for name, one in axis.items()), (low, high)],
        [moved(fallen.friction(nominal, fit.shape)) for fallen in falls],
        half_step,
        confidence,
    )


def _by_position(
    data: OnsetData, fit: BreakawayFit, errors: BreakawayErrors
) -> BreakawayOverPosition:
    positions = data.positions
    value = fit.solution.value
    forward, backward = (positions.powers(side) for side in sides_of(fit.structure, value))
    first, second = (
        tuple(map(errors.interval, positions.power_weights(rows)))
        for rows in sides_of(fit.structure, np.eye(value.size))
    )
    levels = [errors.interval(weights) for weights in _levels(fit.structure)]
    return BreakawayOverPosition(
        positions.low,
        positions.high,
        levels[0],
        levels[1],
        (forward, backward),
        (first, second),
        fit.structure.common,
    )
