"""Friction map over position and speed, from ramps and sliding logs (thesis 4.40 to 4.42).

Sliding logs do not show how friction varies with position; ramps do not show the friction in slip.
Ramps give the breakaway C_s(x) in each direction as a function of the position x (`breakaway`). The
friction in slip C_r(x) is assumed to be proportional to C_s(x):

    C_r(x, direction) = level(direction) C_s(x, direction)/mean C_s
    beta = mean C_s/mean C_r

A level is the mean friction in slip of one direction. The levels and the viscous friction come from
means over strokes (`sines`). In the equation of a stroke, C_s/mean C_s is averaged over the
positions of this stroke, so that strokes may cover different positions. If each direction has a
separate polynomial, an offset of the effort looks like half the difference between the two levels.
The offset is then taken from bench.yaml, or is 0 if bench.yaml states no offset.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.laws import Backward, Dwell, FrictionOverPosition, Laws, Polynomial
from frictool.documents.quantity import Span, si_unit
from frictool.identify.breakaway.breakaway import Breakaway, BreakawayOverPosition, breakaway
from frictool.identify.estimators.sines import (
    StrokeRows,
    checked_stroke_rows,
    fit_rows,
    not_negative,
    regimes_of,
)
from frictool.identify.fit_result import Interval, SlidingFit
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.typing import Vector

OFFSET_REASON = (
    "friction differs between the directions by an amount that varies with position; the logs "
    "cannot separate this difference from an offset; state mechanics.offset in the bench"
)


@dataclass(frozen=True)
class IdentifiedFrictionMap:
    """Friction map from sliding logs and ramps.

    - fit: fit of the sliding logs, with laws over position and speed
    - ramp: breakaway, evaluated with the Coulomb friction of `fit`
    - beta: mean breakaway divided by mean friction in slip
    """

    fit: SlidingFit
    ramp: Breakaway
    beta: float


def friction_map(
    records: list[MotionRecord],
    ramps: list[MotionRecord],
    first: Breakaway,
    axis: Mapping[str, Interval],
    bench: Bench,
    settings: IdentificationSettings,
) -> IdentifiedFrictionMap:
    """Fit a friction map to sliding `records` and `ramps`.

    - first: breakaway by a first evaluation of the ramps, as a function of the position
    - axis: intervals of `inertia`, `viscous`, `coulomb` and `offset`; bench.yaml gives the offset

    The ramps are evaluated again with the Coulomb friction of the map. Raises UnusableLogs if the
    strokes do not determine viscous friction and the mean friction in slip of each direction.
    """
    rows = checked_stroke_rows(records, bench)
    offset = axis["offset"].value
    law = first.by_position
    assert law is not None
    start, levels = _fitted(rows, law, offset, bench, settings)
    sliding = {**start.parameters, "coulomb": _mean(levels)}
    ramp = breakaway(ramps, bench, {**axis, **sliding}, settings.confidence, load=first.load)
    law = ramp.by_position or law
    fit, levels = _fitted(rows, law, offset, bench, settings)
    beta = (law.forward.value + law.backward.value) / (levels[0].value + levels[-1].value)
    return IdentifiedFrictionMap(replace(fit, details={**fit.details, "beta": beta}), ramp, beta)


def _mean(levels: list[Interval]) -> Interval:
    ends = np.mean([[level.value, level.low, level.high] for level in levels], axis=0)
    return Interval(float(ends[0]), float(ends[1]), float(ends[2]))


def _fitted(
    rows: StrokeRows,
    law: BreakawayOverPosition,
    offset: float,
    bench: Bench,
    settings: IdentificationSettings,
) -> tuple[SlidingFit, list[Interval]]:
    """Return the fit of a friction proportional to the breakaway `law`, and intervals of levels.

    A level is the mean friction in slip of one direction; the forward direction is first. If both
    directions have the same polynomial, there is one level.
    """
    means = rows.means
    shaped = means.sign * means.mean(shape_along(rows, law))
    forward = (means.sign > 0.0).astype(np.float64)
    second = np.ones(shaped.size) if law.common else shaped * (1.0 - forward)
    first = shaped if law.common else shaped * forward
    changed = replace(
        means,
        columns=np.column_stack((first, second)),
        effort=means.effort - (0.0 if law.common else offset),
    )
    pieces, half = fit_rows(replace(rows, means=changed), bench, settings.confidence)
    value = pieces.solution.value
    place = len(pieces.knees) + 1
    pair = [Interval.around(value[k], half[k]) for k in (0, place, place + 1)]
    estimates = {"viscous": not_negative(pair[0]), "coulomb": pair[1]}
    refused = {} if law.common or bench.mechanics.offset is not None else {"offset": OFFSET_REASON}
    if law.common:
        estimates["offset"] = pair[2]
    levels = pair[1:2] if law.common else pair[1:]
    laws = Laws(
        backward=None
        if law.common
        else Backward(coulomb=levels[1].estimate("effort", bench.axis, 0.0)),
        regimes=regimes_of(pieces, half, bench),
    )
    error = float(np.linalg.norm(pieces.residual) / np.linalg.norm(means.effort))
    details: dict[str, float | int] = {"strokes": means.effort.size, "knees": len(pieces.knees)}
    return SlidingFit(
        estimates, refused, error, None, pieces.solution.condition, means.speed.size, details, laws
    ), levels


def shape_along(rows: StrokeRows, law: BreakawayOverPosition) -> Vector:
    """Return breakaway/(mean breakaway) (n,) at the samples of the strokes (`shape_at`)."""
    lengths = np.diff(np.append(rows.means.starts, rows.position.size))
    return shape_at(rows.position, np.repeat(rows.means.sign, lengths), law)


def shape_at(position: Vector, direction: Vector, law: BreakawayOverPosition) -> Vector:
    """Return the breakaway (n,) at positions (n,), divided by the mean breakaway.

    `direction` (n,) is positive for forward motion. Outside the positions of the ramps, the
    breakaway at the nearest position is used.
    """
    place = np.clip(position, law.low, law.high)
    curves = [
        np.polynomial.polynomial.polyval(place, np.array(side)) / level.value
        for side, level in zip(law.powers, (law.forward, law.backward), strict=True)
    ]
    return np.asarray(np.where(direction > 0.0, *curves), dtype=np.float64)


def breakaway_laws(ramp: Breakaway, bench: Bench, sliding: Laws | None = None) -> Laws:
    """Add the laws of the breakaway `ramp` to the laws `sliding`."""
    law = ramp.by_position
    laws = sliding or Laws()
    if ramp.rising is not None:
        fresh, rise = ramp.rising.fresh, ramp.rising.rise_time
        laws = msgspec.structs.replace(
            laws,
            dwell=Dwell(fresh.value, rise.value, (fresh.low, fresh.high), (rise.low, rise.high)),
        )
    if law is None:
        return laws
    span = Span(law.low, law.high, si_unit("position", bench.axis))
    backward = laws.backward
    if not law.common:
        backward = msgspec.structs.replace(
            backward or Backward(), breakaway=law.backward.estimate("effort", bench.axis, 0.0)
        )
    polynomials = [
        Polynomial(
            powers, forward_interval=tuple((one.low, one.high) for one in law.coefficients[k])
        )
        for k, powers in enumerate(law.powers)
    ]
    both = msgspec.structs.replace(
        polynomials[0],
        backward=polynomials[1].forward,
        backward_interval=polynomials[1].forward_interval,
    )
    position = FrictionOverPosition(span, polynomials[0] if law.common else both)
    return msgspec.structs.replace(laws, backward=backward, position=position)
