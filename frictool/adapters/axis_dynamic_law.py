"""Dynamic friction law of a model.yaml with the key `presliding`.

The parameters of the law are computed from the model as in the command `compare`
(`LawParameter.comparison_value`). If a plant has c times the Coulomb friction of the model, the
stiffness and the damping of the contact are multiplied by c, too, so that the deflections do not
change.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.model import Model
from frictool.documents.presliding import Contact, MaxwellSlip
from frictool.friction.elasto_plastic import PLASTIC_FROM
from frictool.friction.law_registry import LAWS
from frictool.friction.leuven import DEFAULT_EXPONENT
from frictool.friction.maxwell_bank import bank_tail
from frictool.plant.axis import AxisParameters
from frictool.plant.axis_dynamic_law import AxisDynamicLaw, extension_of
from frictool.typing import Vector

# laws whose parameter vector ends with the elements of a bank (friction/maxwell_bank.py)
BANKS = ("leuven", "maxwell_slip")


def dynamic_law_of(model: Model, axis: AxisParameters) -> AxisDynamicLaw | None:
    """Return the dynamic law of a plant `axis`; None if the model has no key `presliding`.

    Raises ValueError if the axis has a backlash, or if the law does not support the parameters.
    """
    document = model.presliding
    if document is None:
        return None
    if axis.backlash > 0.0:
        raise ValueError(
            "a presliding law does not work with a backlash; describe motor and load as a "
            "mechanism, or remove `presliding` from the model"
        )
    law = LAWS[document.law]
    coulomb = model.parameters.coulomb.value
    scale = axis.coulomb / coulomb if coulomb > 0.0 else 1.0
    fitted = getattr(document, document.law, None)
    contact = fitted if isinstance(fitted, Contact) else None
    stiffness = scale * (contact or document).stiffness.value
    damping = (
        2.0 * math.sqrt(axis.inertia * stiffness)
        if contact is None
        else scale * contact.damping.value
    )
    elastic = None if contact is None else contact.elastic_limit
    limit, tail = document.limit.value, None
    if document.law in BANKS and document.maxwell_slip is not None:
        limit, tail = _bank(document.maxwell_slip, model.parameters.breakaway.value, limit)
    contact_speed = axis.breakaway / math.sqrt(stiffness * axis.inertia)
    stribeck_velocity = axis.laws.stribeck_velocity or contact_speed
    values = {
        "coulomb": axis.coulomb,
        "breakaway": axis.breakaway,
        "viscous": axis.viscous,
        "stribeck_velocity": stribeck_velocity,
        "stribeck_exponent": axis.laws.stribeck_exponent,
        "stiffness": stiffness,
        "damping": damping,
        "presliding_limit": limit,
        "plastic_from": PLASTIC_FROM
        if elastic is None
        else elastic.value * stiffness / axis.breakaway,
        "leuven_exponent": DEFAULT_EXPONENT,
    }
    p = law.pack_shared(values, model.axis, tail)
    dynamic = AxisDynamicLaw(
        law,
        p,
        min(stribeck_velocity, contact_speed),
        min(limit, axis.breakaway / stiffness),
        extension_of(law, axis.laws, axis.viscous),
    )
    dynamic.extension.pack(law, p)  # also checks the extension
    return dynamic


def assumed_fall(model: Model) -> str:
    """Return a remark if the presliding law uses an assumed Stribeck velocity, else "".

    The velocity is assumed if the model states a breakaway above the Coulomb friction and no
    Stribeck velocity.
    """
    document, today = model.presliding, model.parameters
    if (
        document is None
        or today.stribeck_velocity is not None
        or today.breakaway.value <= today.coulomb.value
        or "breakaway" not in {parameter.name for parameter in LAWS[document.law].parameters}
    ):
        return ""
    contact = getattr(document, document.law, None) or document
    speed = today.breakaway.value / math.sqrt(contact.stiffness.value * today.inertia.value)
    return (
        f"the model has presliding by {document.law} without stribeck_velocity: simulations use "
        f"a Stribeck velocity of {speed:.3g} "
        f"{'rad/s' if model.axis == 'rotary' else 'm/s'}, the speed of the contact's oscillation"
    )


def _bank(fitted: MaxwellSlip, breakaway: float, limit: float) -> tuple[float, Vector]:
    """Return the displacement [rad | m] at breakaway, and the array (2 n,) of a Maxwell bank.

    The bank of n elements (`bank_tail`) follows the fitted curve of force over displacement up to
    the breakaway. If the curve ends below the breakaway, a straight line extends the curve to the
    point (`limit`, breakaway).
    """
    displacement, force = np.array(fitted.displacement), np.array(fitted.force)
    below = force < breakaway
    end = (
        limit
        if np.all(below)
        else float(np.interp(breakaway, np.append(0.0, force), np.append(0.0, displacement)))
    )
    kept = below & (displacement < end)
    return end, bank_tail(np.append(displacement[kept], end), np.append(force[kept], breakaway))
