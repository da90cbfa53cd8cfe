"""Dynamic friction law of an axis, such as LuGre, which replaces stick and slip."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from frictool.friction.law import Law
from frictool.friction.law_extension import NO_EXTENSION, FrictionExtension
from frictool.friction.position_polynomial import normalised_coefficients
from frictool.plant.axis_friction_laws import AxisLaws
from frictool.typing import Vector

TOLERANCE = 1e-7  # largest error of a step, relative to the scales of AxisDynamicLaw


class AxisDynamicLaw(NamedTuple):
    """Dynamic friction law of an axis.

    - p: parameter array, the result of `law.pack(...)`
    - speed_scale [rad/s | m/s], length_scale [rad | m]: speed and length to which errors are
      relative
    - extension: friction levels by direction and position, and viscous coefficients by speed range
    """

    law: Law
    p: Vector
    speed_scale: float
    length_scale: float
    extension: FrictionExtension = NO_EXTENSION


def extension_of(law: Law, laws: AxisLaws, viscous: float) -> FrictionExtension:
    """Return the `AxisLaws` of an axis as an extension of its dynamic friction law.

    viscous: coefficient in the lowest speed range [N m s/rad | N s/m]. Raises ValueError if `laws`
    contain a property that no dynamic law supports; `FrictionExtension.pack` checks the other
    properties.
    """
    names = {parameter.name for parameter in law.parameters}
    levels = {} if laws.backward is None else laws.backward._asdict()
    extension = FrictionExtension(
        backward_values={name: value for name, value in levels.items() if name in names},
        fresh=laws.fresh,
        rise_time=laws.rise_time,
        regimes=_knees(laws, viscous),
    )
    shape = laws.shape
    if shape is None:
        return extension
    if shape.breakaway != shape.coulomb:
        raise ValueError(
            "position.breakaway differs from position.coulomb; a dynamic law needs equal "
            "polynomials"
        )
    ends = (shape.low, shape.high)
    forward, backward = (tuple(normalised_coefficients(one, *ends)) for one in shape.coulomb)
    return replace(extension, forward=forward, backward=backward, travel=ends)


def _knees(laws: AxisLaws, viscous: float) -> tuple[tuple[float, float], ...]:
    """Return pairs (knee speed, increase of the viscous coefficient), valid in both directions.

    Raises ValueError if the increases of the two directions differ.
    """
    knees = []
    slopes = (viscous, viscous if laws.backward is None else laws.backward.viscous)
    for regime in laws.regimes:
        added = regime.forward - slopes[0]
        if regime.backward - slopes[1] != added:
            raise ValueError(
                f"above the speed {regime.knee:g}, viscous friction rises by {added:g} forward and "
                f"{regime.backward - slopes[1]:g} backward; a dynamic law needs equal rises"
            )
        knees.append((regime.knee, added))
        slopes = (regime.forward, regime.backward)
    return tuple(knees)
