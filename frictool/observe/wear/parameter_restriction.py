"""Linear map from wear and friction parameters to the coefficients of a row, with a prior.

A weak-form row has p columns (`WeakFormLayout.names`), each with a coefficient. For each kind of
wear, the p coefficients are linear functions of r parameters. The prior has a mean and a standard
deviation for each parameter.

    multiplicative   dry_d,z = wear            additive   dry_d,z = 1, level_d = added
    directional      dry_d,z = wear_d          zones      dry_d,z = wear_z

Here dry_d,z and level_d are coefficients of weak_form_layout.py for the direction d (1 or -1) and
the zone z; wear, wear_d, wear_z and added are parameters. Every kind also has these parameters:

- inertia
- viscous friction with its bends (changes of the slope over speed)
- falls of the friction with speed
- delay of the effort
- offset of the effort, for example of the current sensor; it is added to level_1 and subtracted
  from level_-1

The prior is wide for parameters that differ between actuators or change with age: inertia, wear and
viscous friction. `UnmodelledFriction` bounds friction that depends on speed and is not in the
model: a slope below the model's first bend, an additional bend, or a fall with rising speed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from frictool.documents.model import Model
from frictool.documents.quantity import Quantity
from frictool.observe.wear.weak_form_layout import FALLS, WeakFormLayout
from frictool.typing import Vector

INERTIA_SPREAD = 0.3  # relative standard deviation, in addition to the model's interval
VISCOUS_SPREAD = 0.5  # relative standard deviation of the viscous friction
# standard deviation of the difference between directions, relative to the viscous friction
ASYMMETRY = 0.25
OFFSET_SPREAD = 0.02  # standard deviation relative to the dry friction
WEAR_SPREAD = 0.5  # standard deviation of the wear
QUANTILE = 1.96  # half the width of an interval, in standard deviations
# standard deviation of an unknown delay of the effort, in sample periods: a uniform distribution
DELAY_SPREAD = 1.0 / np.sqrt(12.0)
# standard deviation of the model's own fall, relative to its breakaway minus Coulomb friction
FALL_SPREAD = 0.3


@dataclass(frozen=True)
class UnmodelledFriction:
    """Friction over speed that the model does not include, relative to the dry friction.

    - slope, deviation: mean and standard deviation of the part proportional to speed, at top speed
    - bend: standard deviation of the friction that each bend (change of slope) adds, at top speed
    - fall: mean of friction that falls with speed, at speed 0; `at`: index of its speed scale w
    - fallen: standard deviation of the friction that falls on each scale w, at speed 0
    """

    slope: float = 0.0
    deviation: float = 0.03
    bend: float = 0.03
    fall: float = 0.0
    at: int = 0
    fallen: tuple[float, ...] = (0.0,) * len(FALLS)


@dataclass(frozen=True)
class ParameterRestriction:
    """Linear map coefficients = fixed + matrix @ parameters, with the prior of the parameters.

    - names: names of the parameters, (r,)
    - matrix: coefficients per unit of each parameter, (p, r)
    - fixed: part of the coefficients that does not depend on the parameters, (p,)
    - mean, deviation: prior mean and prior standard deviation of each parameter, (r,)
    """

    names: tuple[str, ...]
    matrix: Vector
    fixed: Vector
    mean: Vector
    deviation: Vector

    def index(self, name: str) -> int:
        """Return the index of the parameter `name` in `names`."""
        return self.names.index(name)


PLAIN = UnmodelledFriction()


def restriction(
    model: Model,
    layout: WeakFormLayout,
    wear: Mapping[str, tuple[Vector, float, float]],
    fixed: Vector | None = None,
    unmodelled: UnmodelledFriction = PLAIN,
) -> ParameterRestriction:
    """Return the map from friction and wear parameters to the coefficients of a weak-form row.

    The first parameters are common to all kinds of wear (list at the top of this module). The
    parameters of `wear` follow.

    Parameters
    ----------
    model
        Axis; its parameters are the prior means of the common parameters.
    layout
        Names of the p columns of a row.
    wear
        Parameters of the kind of wear, by name: coefficients (p,) per unit of the parameter,
        prior mean, and prior standard deviation.
    fixed
        Part (p,) of the coefficients that does not depend on the parameters; None stands for 0.
    unmodelled
        Friction that depends on speed and is not in the model; it widens the priors of the viscous
        friction, its bends and the falls.
    """
    known = _known(model, layout, unmodelled)
    columns = [np.eye(len(layout.names))[:, layout.names.index(name)] for name in known]
    entries = [(name, *values) for name, values in known.items()]
    return ParameterRestriction(
        names=(*known, *wear),
        matrix=np.column_stack([*columns, *(column for column, _, _ in wear.values())])
        if columns
        else np.empty((0, 0)),
        fixed=np.zeros(len(layout.names)) if fixed is None else fixed,
        mean=np.array([*(mean for _, mean, _ in entries), *(mean for _, mean, _ in wear.values())]),
        deviation=np.array(
            [*(spread for _, _, spread in entries), *(spread for _, _, spread in wear.values())]
        ),
    )


def dry_columns(layout: WeakFormLayout, side: str | None = None, zone: int | None = None) -> Vector:
    """Return a vector (p,) with 1 at the columns of the dry friction, and 0 at the other columns.

    - side: `forward` or `backward`; None for both directions
    - zone: index of a zone of the travel; None for all zones
    """
    chosen = np.zeros(len(layout.names))
    for index, name in enumerate(layout.names):
        kind, *rest = name.split("_")
        if kind == "dry" and side in (None, rest[0]) and zone in (None, int(rest[1])):
            chosen[index] = 1.0
    return chosen


def level_columns(layout: WeakFormLayout, backward: float, forward: float) -> Vector:
    """Return weights (p,): `backward` at level_backward, `forward` at level_forward, else 0."""
    weights = {"level_backward": backward, "level_forward": forward}
    return np.array([weights.get(name, 0.0) for name in layout.names])


def offset_of(
    model: Model, layout: WeakFormLayout, share: float = OFFSET_SPREAD
) -> tuple[Vector, float, float]:
    """Return the regressor of the drive's offset, its prior mean and deviation [N m | N].

    The regressor (p,) contains the coefficients of a row for an offset of 1 N m | N. The offset is
    relative to the model's offset; a positive offset opposes a positive effort. The prior deviation
    is sqrt(a^2 + b^2). a is `share` times the dry friction. b follows from the range of the offset
    in the model or in bench.yaml, whichever is wider.
    """
    known = max(
        _half(quantity)
        for quantity in (model.parameters.offset, model.bench.mechanics.offset)
        if quantity is not None
    )
    return (
        level_columns(layout, -1.0, 1.0),
        0.0,
        float(np.hypot(share * layout.friction, known / QUANTILE)),
    )


def multiplicative(
    model: Model, layout: WeakFormLayout, unmodelled: UnmodelledFriction = PLAIN
) -> ParameterRestriction:
    """Return the map for wear that multiplies all dry friction by one factor, `wear`."""
    return restriction(
        model,
        layout,
        {"offset": offset_of(model, layout), "wear": (dry_columns(layout), 1.0, WEAR_SPREAD)},
        unmodelled=unmodelled,
    )


def _known(
    model: Model, layout: WeakFormLayout, unmodelled: UnmodelledFriction
) -> dict[str, tuple[float, float]]:
    """Return the prior (mean, deviation) of each parameter that all kinds of wear have in common.

    The range of the viscous friction in bench.yaml applies to the steepest slope
    (adapters/friction_levels.py). If the model has bends, this is the slope above the last bend.
    """
    today = model.parameters
    bench = model.bench.mechanics
    fastest = max([2.0 * float(knee) for knee in layout.knees], default=layout.slowest)
    top = bench.top_speed.value if bench.top_speed is not None else fastest
    regime_viscous = {
        regime.above.value: regime.viscous
        for regime in (model.laws.regimes if model.laws is not None else ())
    }
    inertia = today.inertia
    slope = today.viscous
    steepest = max(regime_viscous, default=0.0)
    unsure = {
        speed: max(
            _spread(viscous), _half(viscous), _half(bench.viscous) if speed == steepest else 0.0
        )
        for speed, viscous in regime_viscous.items()
    }
    opposite = (
        model.laws.backward.viscous
        if model.laws is not None and model.laws.backward is not None
        else None
    )
    opposite = opposite or slope
    mean = 0.5 * (slope.value + opposite.value)
    first = _spread(slope) if regime_viscous else max(_spread(slope), _half(bench.viscous))
    out = {
        "inertia": (
            inertia.value,
            float(np.hypot(INERTIA_SPREAD * inertia.value, _half(inertia) / QUANTILE)),
        ),
        "viscous": (
            max(mean, unmodelled.slope * layout.friction / top),
            float(np.hypot(first, unmodelled.deviation * layout.friction / top)),
        ),
    }
    if slope.value > 0.0:
        out["asymmetry"] = (0.5 * (slope.value - opposite.value), ASYMMETRY * slope.value)
    out["delay"] = (0.0, DELAY_SPREAD * layout.period)
    for index, knee in enumerate(map(float, layout.knees)):
        width = unmodelled.bend * layout.friction / max(top - knee, 0.25 * top)
        bend = 0.0
        if knee in regime_viscous:
            bend = regime_viscous[knee].value - slope.value
            width = max(width, unsure[knee])
            slope = regime_viscous[knee]
        out[f"bend_{index}"] = (bend, width)
    falling = today.stribeck_velocity is not None
    drop = today.breakaway.value - today.coulomb.value + _half(today.breakaway) if falling else 0.0
    for index, fallen in enumerate(unmodelled.fallen):
        out[f"fall_{index}"] = (
            unmodelled.fall * layout.friction * (index == unmodelled.at),
            float(np.hypot(fallen * layout.friction, FALL_SPREAD * drop)),
        )
    return out


def _half(quantity: Quantity) -> float:
    low, high = quantity.interval
    return 0.5 * (high - low)


def _spread(viscous: Quantity) -> float:
    """Return the prior deviation of a viscous friction [N m s/rad | N s/m]."""
    return float(np.hypot(VISCOUS_SPREAD * viscous.value, _half(viscous) / QUANTILE))
