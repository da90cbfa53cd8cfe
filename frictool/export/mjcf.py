"""Model of MuJoCo (MJCF), and the ranges of its attributes for domain randomisation.

    joint    armature = J, damping = viscous friction, frictionloss = Coulomb friction,
             stiffness = spring of the load, range = travel
    general  effort = gear (drive + bias), drive with the lag of its loop; bias = -offset / gear
    dcmotor  without input: LuGre friction instead of frictionloss, and the effort ripple as
             cogging; the winding of this motor conducts no current

    LuGre    dz/dt = v - |v| z sigma_0/g(v),  g = F_c + (F_s - F_c) exp(-(v/v_s)^2),
             friction = sigma_0 z + sigma_1 dz/dt; the joint has the viscous friction
    cogging  effort = A sin(N x + phase)

J is the inertia and x the position of the joint. friction/lugre.py and friction/stribeck.py define
the symbols of LuGre. A is the amplitude of the effort ripple, N its angular wave number.

MuJoCo regularises `frictionloss`: below breakaway the joint creeps in proportion to the effort. The
file requests the stiffest regularisation that MuJoCo allows at the file's time step.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from frictool import __version__
from frictool.documents.laws import Load, Ripple
from frictool.documents.model import Model
from frictool.documents.presliding import Contact
from frictool.documents.quantity import Quantity
from frictool.errors import NoSolutionError
from frictool.export.c_identifier import c_identifier
from frictool.export.export_origin import ExportOrigin
from frictool.export.model_features import left_out_levels, without_features

JOINTS = {"rotary": "hinge", "linear": "slide"}
LONGEST_STEP = 1e-3  # longest time step [s]
BRISTLE_STEP = 0.1  # longest time step relative to sqrt(J / sigma_0)
BODY_SHARE = 1e-6  # inertia of the body relative to the armature; MuJoCo does not allow 0
# centre of mass of the body. MuJoCo computes the stiffness of the friction on a slide joint without
# the armature if the centre is the origin of the body's frame.
CENTRES = {"rotary": "0 0 0", "linear": "0.001 0 0"}
STIFFEST = 0.9999  # largest impedance of a constraint (mjMAXIMP)
INSULATED = 'motorconst="1e-9" resistance="1e9"'  # almost no current; MuJoCo does not allow 0
STRIBECK_EXPONENT = 2.0
RANGES = "mjcf-ranges/1"


@dataclass(frozen=True)
class MjcfAttribute:
    """Number in the MJCF file, with an interval.

    - element, attribute: element of the file and its attribute
    - field: array of mjModel; for an array with several columns, also the column, as in
      "actuator_gear.0"
    - value: value with its interval, SI
    """

    element: str
    attribute: str
    field: str
    value: Quantity


def time_step(model: Model) -> float:
    """Return the time step [s]: the sample period in bench.yaml divided by an integer."""
    longest = LONGEST_STEP
    contact = _contact(model)
    if contact is not None:
        inertia = model.parameters.inertia.value
        longest = min(longest, BRISTLE_STEP * math.sqrt(inertia / contact.stiffness.value))
    period = model.bench.sample_period_s
    return period / math.ceil(period / longest - 1e-9)


def exported_model(model: Model, without: Collection[str]) -> tuple[Model, list[str]]:
    """Return the model without the features that MJCF omits, and a note on each omitted feature.

    Raises NoSolutionError if the model has a feature that MJCF cannot represent and that is not in
    `without`.
    """
    held = {"spring", "ripple"}
    if _contact(model) is not None and "presliding" not in without:
        held |= {"presliding", "stribeck"}
    model, notes = without_features(model, "MJCF", held, without)
    exponent = model.laws.stribeck_exponent if model.laws else STRIBECK_EXPONENT
    if model.parameters.stribeck_velocity is None:
        return model, notes + left_out_levels(model, "breakaway")
    if exponent != STRIBECK_EXPONENT:
        raise NoSolutionError(
            f"{model.name}: MJCF cannot represent stribeck_exponent {exponent:g}; allowed: "
            f"{STRIBECK_EXPONENT:g}, or --without stribeck"
        )
    return model, notes


def mjcf_files(
    model: Model, origin: ExportOrigin, without: Collection[str]
) -> tuple[Mapping[str, str | bytes], list[str]]:
    """Return the MJCF file and the file with the attributes' ranges (contents by name), and notes.

    Raises NoSolutionError if the model has a feature that MJCF cannot represent and that is not in
    `without`.
    """
    model, notes = exported_model(model, without)
    name = c_identifier(model.name)
    attributes = mjcf_attributes(model)
    ranges = {
        "format": RANGES,
        "model": model.name,
        "sha256": origin.sha256,
        "command": origin.command,
        "confidence": model.confidence,
        "attributes": [
            {
                "element": one.element,
                "attribute": one.attribute,
                "mjModel": one.field,
                "value": one.value.value,
                "low": one.value.interval[0],
                "high": one.value.interval[1],
                "unit": one.value.unit,
            }
            for one in attributes
        ],
    }
    fixed = [one.attribute for one in attributes if one.value.interval[0] == one.value.interval[1]]
    if fixed:
        notes.append(f"no interval in the model: {', '.join(fixed)}")
    files = {
        f"{name}.xml": mjcf_text(model, attributes, origin),
        f"{name}_ranges.json": json.dumps(ranges, indent=1, ensure_ascii=False) + "\n",
    }
    return files, notes


def mjcf_attributes(model: Model) -> list[MjcfAttribute]:
    """Return the MJCF attributes of a model without unsupported features (`exported_model`)."""
    today, contact = model.parameters, _contact(model)
    load = model.laws.load if model.laws and model.laws.load else Load()
    out = [
        MjcfAttribute("joint", "armature", "dof_armature", today.inertia),
        MjcfAttribute("joint", "damping", "dof_damping", today.viscous),
        MjcfAttribute("general", "gear", "actuator_gear.0", model.bench.actuator.constant),
    ]
    if contact is None:
        out.append(MjcfAttribute("joint", "frictionloss", "dof_frictionloss", today.coulomb))
    else:
        static = today.coulomb if today.stribeck_velocity is None else today.breakaway
        # the velocity has no effect if both levels are equal; MuJoCo requires a velocity above 0
        velocity = today.stribeck_velocity or Quantity(1.0)
        out += [
            MjcfAttribute("dcmotor", "lugre 0", "actuator_dynprm.5", contact.stiffness),
            MjcfAttribute("dcmotor", "lugre 1", "actuator_dynprm.6", contact.damping),
            MjcfAttribute("dcmotor", "lugre 2", "actuator_biasprm.3", today.coulomb),
            MjcfAttribute("dcmotor", "lugre 3", "actuator_biasprm.4", static),
            MjcfAttribute("dcmotor", "lugre 4", "actuator_biasprm.5", velocity),
        ]
    if load.stiffness is not None:
        out.append(MjcfAttribute("joint", "stiffness", "jnt_stiffness", load.stiffness))
    if load.ripple is not None:
        amplitude = _amplitude(load.ripple)
        out.append(MjcfAttribute("dcmotor", "cogging 0", "actuator_biasprm.0", amplitude))
    return out


def mjcf_text(model: Model, attributes: list[MjcfAttribute], origin: ExportOrigin) -> str:
    """Return the MJCF text of a model without unsupported features (`exported_model`)."""
    values = {(one.element, one.attribute): one.value.value for one in attributes}
    gear = values["general", "gear"]
    step, inertia = time_step(model), values["joint", "armature"]
    kind = JOINTS[model.axis]
    joint = {"name": "axis", "type": kind, "axis": "0 0 1"}
    joint |= {key: repr(x) for (element, key), x in values.items() if element == "joint"}
    if "frictionloss" in joint:
        joint["solreffriction"] = f"{2.0 * step!r} 1"
        joint["solimpfriction"] = f"{STIFFEST} {STIFFEST} 1 0.5 2"
    travel = model.bench.mechanics.travel
    if travel is not None:
        joint["range"] = f"{travel.low!r} {travel.high!r}"
    limit = model.bench.actuator.limit.value
    drive = {"name": "drive", "joint": "axis", "gear": repr(gear)}
    drive["ctrlrange"] = f"{-limit!r} {limit!r}"
    lag = model.bench.actuator.loop_time_constant_s
    if lag > 0.0:
        drive |= {"dyntype": "filterexact", "dynprm": repr(lag)}
    offset = model.parameters.offset.value
    if offset != 0.0:
        drive |= {"biastype": "affine", "biasprm": f"{-offset / gear!r} 0 0"}
    passive = _passive(values, model.laws.load.ripple if model.laws and model.laws.load else None)
    tiny = repr(BODY_SHARE * inertia)
    comment = (
        f"{model.name}: {origin.command} (frictool {__version__}), model SHA-256 {origin.sha256}"
    )
    lines = [
        f"<mujoco model={quoteattr(model.name)}>",
        f"  <!-- {escape(comment).replace('--', '- -')} -->",
        '  <compiler angle="radian" autolimits="true"/>',
        f'  <option timestep="{step!r}" gravity="0 0 0" integrator="implicitfast"/>',
        "  <worldbody>",
        '    <body name="axis">',
        f'      <inertial pos="{CENTRES[model.axis]}" mass="{tiny}" '
        f'diaginertia="{tiny} {tiny} {tiny}"/>',
        f"      {_element('joint', joint)}",
        "    </body>",
        "  </worldbody>",
        "  <actuator>",
        f"    {_element('general', drive)}",
        *([f"    {passive}"] if passive else []),
        "  </actuator>",
        "</mujoco>",
    ]
    return "\n".join(lines) + "\n"


def _contact(model: Model) -> Contact | None:
    return model.presliding.lugre if model.presliding is not None else None


def _element(name: str, attributes: Mapping[str, str]) -> str:
    words = [name, *(f'{key}="{text}"' for key, text in attributes.items())]
    return f"<{' '.join(words)}/>"


def _passive(values: Mapping[tuple[str, str], float], ripple: Ripple | None) -> str | None:
    lugre = [repr(values["dcmotor", key]) for key in LUGRE if ("dcmotor", key) in values]
    texts = [f'lugre="{" ".join(lugre)}"'] if lugre else []
    if ripple is not None:
        number = 2.0 * math.pi * ripple.cycles / ripple.per.value
        phase = math.atan2(-ripple.cosine.value, -ripple.sine.value)  # the load opposes the drive
        texts.append(f'cogging="{values["dcmotor", "cogging 0"]!r} {number!r} {phase!r}"')
    if not texts:
        return None
    return (
        " ".join(['<dcmotor name="friction" joint="axis" input="none"', INSULATED, *texts]) + "/>"
    )


LUGRE = tuple(f"lugre {index}" for index in range(5))


def _amplitude(ripple: Ripple) -> Quantity:
    sine, cosine = ripple.sine, ripple.cosine

    def least(one: Quantity) -> float:
        low, high = one.interval
        return 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))

    ends = [math.hypot(a, b) for a, b in itertools.product(sine.interval, cosine.interval)]
    return Quantity(
        math.hypot(sine.value, cosine.value),
        math.hypot(least(sine), least(cosine)),
        max(ends),
        sine.unit,
    )
