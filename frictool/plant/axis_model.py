"""The axis that a model.yaml describes, as the engine takes it."""

from __future__ import annotations

from typing import Any

from frictool.documents.model import Model
from frictool.plant.axis import BACKLASH_BREAKAWAY_RATIO, AxisParameters


def axis_of(model: Model, **overrides: float) -> AxisParameters:
    """The model's axis in SI; `overrides` replaces fields of AxisParameters.

    A Coulomb friction that is overridden scales the breakaway with it, unless that is given too. Friction inside the backlash is a
    part of the axis's friction (motor and brushes, thesis 4.4.4) and never above it; where the bench does not say, it is all of it.
    Raises ValueError naming what is out of range.
    """
    bench, today = model.bench, model.parameters
    values: dict[str, Any] = {
        "inertia": today.inertia.value,
        "viscous": today.viscous.value,
        "coulomb": today.coulomb.value,
        "offset": today.offset.value,
        "constant": bench.actuator.constant.value,
        "lag": bench.actuator.loop_time_constant_s,
        "drive_limit": bench.actuator.limit.value,
        "backlash": bench.mechanics.backlash.value if bench.mechanics.backlash else 0.0,
        "encoder_step": bench.encoder.resolution,
        **overrides,
    }
    ratio = today.breakaway.value / today.coulomb.value if today.coulomb.value > 0.0 else 0.0
    values.setdefault("breakaway", ratio * values["coulomb"] if ratio else today.breakaway.value)
    loose = bench.mechanics.backlash_coulomb
    values.setdefault("backlash_coulomb", min(loose.value if loose else values["coulomb"], values["coulomb"]))
    values.setdefault("backlash_breakaway", BACKLASH_BREAKAWAY_RATIO * values["backlash_coulomb"])
    return AxisParameters(**values).checked()
