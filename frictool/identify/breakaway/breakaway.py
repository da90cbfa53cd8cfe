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
- The interval includes the scatter between onsets (jackknife), and the effect of every value within
  the intervals of the axis's parameters (`combined_interval`). A sampled ramp rises by one step per
  sample. Two errors of half a step, which do not average out, are added: the breakaway lies
  anywhere within a step, and the time of an encoder change is uncertain by half a sample.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.identify.breakaway.breakaway_fit import (
    BreakawayErrors,
    BreakawayFit,
    breakaway_errors,
    fit_breakaway,
)
from frictool.identify.breakaway.onset_friction import OnsetData
from frictool.identify.breakaway.onset_load import NO_LOAD, OnsetLoad
from frictool.identify.breakaway.position_law import sides_of
from frictool.identify.breakaway.rising_friction import RisingFriction, rising_friction
from frictool.identify.breakaway.stribeck_velocity import StribeckVelocityRange
from frictool.identify.breakaway.unknown_load import (
    inseparable,
    load_slope,
    onset_data_under,
    with_further_orders,
    without_free_load,
)
from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.interval_checks import too_vague
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.regression import SingularRegressors
from frictool.typing import Vector

GRID_POINTS = 200  # number of positions at which a breakaway law must be positive


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


@dataclass(frozen=True)
class Breakaway:
    """Breakaway identified from logs of ramps.

    - interval: mean breakaway, N m | N; if `rising` is not None, the breakaway after a long rest
    - forward, backward: mean |effort| at the onsets of each direction, N m | N; NaN without onsets
    - onsets: number of onsets
    - delay: mean rise of the effort until the encoder shows the motion, which was subtracted, N m |
      N
    - position: position of each onset, (n,), rad | m
    - direction: direction of each onset, (n,), +1 or -1
    - friction: |effort - offset| at each onset, (n,), N m | N
    - fall: range of Stribeck velocities with which friction may fall after an onset; `interval`
      includes the effect of this range
    - by_position: polynomials over position; None if the breakaway is constant
    - rising: law over the time at rest; None if the breakaway does not grow with this time
    - load_slope: slope [N m/rad | N/m] of a load that explains the onsets as well as `by_position`
      does (`unknown_load.load_slope`); None if there is no such load
    - load: unknown part of the load; `interval` includes its effect
    - rejected: number of detected motions that were left out because they are no breakaway
    - after_reversals: number of onsets that were left out because they directly follow a reversal
      and need far less effort than later onsets in the same direction
    - reversed_onsets: number of onsets, among `onsets`, that directly follow a reversal
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
    load_slope: float | None = None
    load: OnsetLoad = NO_LOAD
    rejected: int = 0
    after_reversals: int = 0
    reversed_onsets: int = 0

    @property
    def parameter(self) -> Interval:
        """Return the mean breakaway.

        If the breakaway varies with position, this is the mean of the forward direction.
        """
        return self.interval if self.by_position is None else self.by_position.forward


def breakaway(
    records: list[MotionRecord],
    bench: Bench,
    axis: Mapping[str, Interval],
    confidence: float,
    stribeck: StribeckVelocityRange | None = None,
    load: OnsetLoad = NO_LOAD,
) -> Breakaway:
    """Compute the breakaway from records of ramps.

    - axis: intervals of `inertia`, `viscous`, `coulomb` and `offset`
    - stribeck: Stribeck velocity that was identified from another log; None to use the range of
      Stribeck velocities that the onsets allow
    - load: unknown part of the load over position

    If all ramps have the same direction, the offset in `axis` is subtracted. Raises UnusableLogs if
    neither direction has five onsets, if a load starts the axis against the drive, or if the ramps
    do not separate an unknown load from the friction.
    """
    if not load.free:
        return _breakaway(records, bench, axis, confidence, stribeck, load)
    found: list[Breakaway] = []
    reasons: list[UnusableLogs] = []
    for one in (load, load.bounded) if load.most else (load,):
        try:
            freed, fitted = without_free_load(records, bench, axis, one)
            found.append(_breakaway(freed, bench, fitted, confidence, stribeck, one))
        except UnusableLogs as error:
            reasons.append(error)
    if not found:
        raise reasons[0]
    best = min(found, key=lambda one: one.parameter.half_width)
    known = best.parameter
    if not np.isfinite(known.half_width) or too_vague("breakaway", known) is not None:
        raise inseparable(load, f"breakaway in [{known.low:.3g}, {known.high:.3g}]")
    if best is found[0]:
        return best
    # the interval allows for every load up to `load.most`; the value is the breakaway with the
    # fitted load
    value = min(max(found[0].parameter.value, known.low), known.high)
    return replace(best, interval=replace(known, value=value))


def _breakaway(
    records: list[MotionRecord],
    bench: Bench,
    axis: Mapping[str, Interval],
    confidence: float,
    stribeck: StribeckVelocityRange | None,
    load: OnsetLoad,
) -> Breakaway:
    data = onset_data_under(records, bench, axis, load)
    nominal = {name: known.value for name, known in axis.items()}
    try:
        fit = fit_breakaway(data, nominal)
        fall = stribeck or data.fall_range(axis, fit.shape, confidence)
        if fall.velocity > 0.0:
            data = replace(data, fall=fall.value)
            fit = fit_breakaway(data, nominal)
        lag_free = any(record.effort_lag == 0.0 for record in records)
        half_step = 0.5 * max(o.rate for o in data.onsets) * records[0].period if lag_free else 0.0
        errors = breakaway_errors(data, fit, axis, fall, load, half_step, confidence)
        mean = errors.interval(np.mean(fit.levels, axis=0))
        if load.free:
            further = with_further_orders(data, fit)
            wide = breakaway_errors(data, further, axis, fall, load, half_step, confidence)
            other = wide.interval(further.levels[0])
            mean = replace(mean, low=min(mean.low, other.low), high=max(mean.high, other.high))
    except SingularRegressors as error:
        if load.free:
            raise inseparable(load, "too few positions in each direction") from None
        raise UnusableLogs(
            f"the breakaways do not determine how friction varies with position: {error}; "
            "record more ramps"
        ) from None
    positions = data.positions
    rising = law = slope = None
    if fit.structure.constant:
        rested = np.array([onset.rested for onset in data.onsets])
        rising = rising_friction(rested, positions.direction, fit.friction, confidence)
    elif len(fit.levels) == 2:
        law = _by_position(data, fit, errors)
        if load.free:
            law = replace(law, forward=mean, backward=mean)
        elif not load.errors:
            slope = load_slope(data.positions, fit, bench)
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
        slope,
        load,
        data.rejected,
        data.after_reversals,
        sum(onset.after_reversal for onset in data.onsets),
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
    """Return the breakaway `full` after a long rest, with an interval widened by that of `mean`.

    On each side, the half width h becomes sqrt(h^2 + m^2). m is the half width of the mean
    breakaway `mean`, which includes the uncertainty of the axis parameters.
    """
    down = float(np.hypot(full.half_width, mean.value - mean.low))
    up = float(np.hypot(full.half_width, mean.high - mean.value))
    return Interval(full.value, full.value - down, full.value + up)


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
    levels = [errors.interval(weights) for weights in fit.levels]
    return BreakawayOverPosition(
        positions.low,
        positions.high,
        levels[0],
        levels[1],
        (forward, backward),
        (first, second),
        fit.structure.common,
    )
