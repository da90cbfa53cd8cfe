"""What is taken to wear: the few parameters that the columns of a row are combinations of, and what
is known of them before any move.

    multiplicative   dry_d,z = wear            additive   dry_d,z = 1, level_d = d added
                     directional   dry_d,z = wear_d
    zones            dry_d,z = wear_z

Beside these every kind has the inertia, the viscous friction and its bends, and an offset: level_d
= d offset (a current sensor's, say).

What is known: wide where a unit may differ from the model, or grow old: inertia, wear, the viscous
friction that the model has. Of friction over speed that the model has not, a slope below its knee
or another bend, `Unmodelled` says how much there may be.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.observe.wear.weak_form_layout import WeakFormLayout

Vector = NDArray[np.float64]

INERTIA_SPREAD = 0.3  # standard deviations beside the model's intervals, of the value
VISCOUS_SPREAD = 0.5
ASYMMETRY = 0.25  # of the viscous friction, by which it differs between the directions
OFFSET_SPREAD = 0.02  # of the dry friction
WEAR_SPREAD = 0.5
QUANTILE = 1.96  # of an interval's half width


@dataclass(frozen=True)
class UnmodelledFriction:
    """Friction over speed that the model has not, as parts of the dry friction at top speed.

    slope, deviation: mean and deviation of what a slope from rest on adds; bend: deviation of what
    each bend adds.
    """

    slope: float = 0.0
    deviation: float = 0.03
    bend: float = 0.03


@dataclass(frozen=True)
class ParameterRestriction:
    """columns = fixed + matrix parameters: matrix (p, r), fixed (p,), names (r,); prior mean and
    deviation (r,) of each parameter."""

    names: tuple[str, ...]
    matrix: Vector
    fixed: Vector
    mean: Vector
    deviation: Vector

    def place(self, name: str) -> int:
        """Where a parameter is."""
        return self.names.index(name)


PLAIN = UnmodelledFriction()


def restriction(
    model: Model,
    layout: WeakFormLayout,
    wear: Mapping[str, tuple[Vector, float, float]],
    fixed: Vector | None = None,
    beside: UnmodelledFriction = PLAIN,
) -> ParameterRestriction:
    """`wear`: of each of its parameters the columns (p,), the mean and the deviation known
    beforehand. fixed (p,): 0 where not given."""
    known = _known(model, layout, beside)
    columns = [np.eye(len(layout.names))[:, layout.names.index(name)] for name in known]
    given = [(name, *values) for name, values in known.items()]
    return ParameterRestriction(
        names=(*known, *wear),
        matrix=np.column_stack([*columns, *(column for column, _, _ in wear.values())])
        if columns
        else np.empty((0, 0)),
        fixed=np.zeros(len(layout.names)) if fixed is None else fixed,
        mean=np.array([*(mean for _, mean, _ in given), *(mean for _, mean, _ in wear.values())]),
        deviation=np.array(
            [*(spread for _, _, spread in given), *(spread for _, _, spread in wear.values())]
        ),
    )


def dry_columns(layout: WeakFormLayout, side: str | None = None, zone: int | None = None) -> Vector:
    """1 at the columns (p,) of the dry friction, of one direction (`forward`, `backward`) or zone
    where that is given, 0 elsewhere."""
    chosen = np.zeros(len(layout.names))
    for place, name in enumerate(layout.names):
        kind, *rest = name.split("_")
        if kind == "dry" and side in (None, rest[0]) and zone in (None, int(rest[1])):
            chosen[place] = 1.0
    return chosen


def level_columns(layout: WeakFormLayout, backward: float, forward: float) -> Vector:
    """What a level of one unit of effort is in the columns (p,)."""
    given = {"level_backward": backward, "level_forward": forward}
    return np.array([given.get(name, 0.0) for name in layout.names])


def offset_of(
    model: Model, layout: WeakFormLayout, share: float = OFFSET_SPREAD
) -> tuple[Vector, float, float]:
    """An offset of the drive, which opposes a positive effort, beside the model's; `share` of the
    dry friction, and the bench's range."""
    known = max(
        _half(own)
        for own in (model.parameters.offset, model.bench.mechanics.offset)
        if own is not None
    )
    return (
        level_columns(layout, -1.0, 1.0),
        0.0,
        float(np.hypot(share * layout.friction, known / QUANTILE)),
    )


def multiplicative(
    model: Model, layout: WeakFormLayout, beside: UnmodelledFriction = PLAIN
) -> ParameterRestriction:
    """All dry friction is multiplied by `wear`."""
    return restriction(
        model,
        layout,
        {"offset": offset_of(model, layout), "wear": (dry_columns(layout), 1.0, WEAR_SPREAD)},
        beside=beside,
    )


def _known(
    model: Model, layout: WeakFormLayout, beside: UnmodelledFriction
) -> dict[str, tuple[float, float]]:
    """(mean, deviation) of inertia, viscous friction and its bends.

    The bench's range of the viscous friction is that of the steepest slope
    (plant/friction_levels.py): of the last bend where the model has some.
    """
    today, bench = model.parameters, model.bench.mechanics
    fastest = max([2.0 * float(knee) for knee in layout.knees], default=layout.slowest)
    top = bench.top_speed.value if bench.top_speed is not None else fastest
    own = {
        regime.above.value: regime.viscous
        for regime in (model.laws.regimes if model.laws is not None else ())
    }
    inertia, slope, steepest = today.inertia, today.viscous, max(own, default=0.0)
    unsure = {
        speed: max(
            _spread(viscous), _half(viscous), _half(bench.viscous) if speed == steepest else 0.0
        )
        for speed, viscous in own.items()
    }
    opposite = (
        model.laws.backward.viscous
        if model.laws is not None and model.laws.backward is not None
        else None
    )
    opposite = opposite or slope
    mean = 0.5 * (slope.value + opposite.value)
    first = _spread(slope) if own else max(_spread(slope), _half(bench.viscous))
    out = {
        "inertia": (
            inertia.value,
            float(np.hypot(INERTIA_SPREAD * inertia.value, _half(inertia) / QUANTILE)),
        ),
        "viscous": (
            max(mean, beside.slope * layout.friction / top),
            float(np.hypot(first, beside.deviation * layout.friction / top)),
        ),
    }
    if slope.value > 0.0:
        out["asymmetry"] = (0.5 * (slope.value - opposite.value), ASYMMETRY * slope.value)
    for place, knee in enumerate(map(float, layout.knees)):
        width, bend = beside.bend * layout.friction / max(top - knee, 0.25 * top), 0.0
        if knee in own:
            bend, width, slope = own[knee].value - slope.value, max(width, unsure[knee]), own[knee]
        out[f"bend_{place}"] = (bend, width)
    return out


def _half(quantity: Quantity) -> float:
    low, high = quantity.interval
    return 0.5 * (high - low)


def _spread(viscous: Quantity) -> float:
    """Deviation of a viscous friction [N m s/rad | N s/m], which goes with the temperature."""
    return float(np.hypot(VISCOUS_SPREAD * viscous.value, _half(viscous) / QUANTILE))
