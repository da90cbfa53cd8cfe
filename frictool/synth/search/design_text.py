"""Text of a design document with a comment on each value, for engineers who edit the values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from frictool.documents.design import Design
from frictool.documents.writing import drop_unset, tree_to_yaml

COLUMN = 64  # column at which comments begin, if the value is shorter

# key with its parents -> effect of the value
EFFECTS = {
    "structure": "a speed loop inside a position law",
    "pid.speed_gain": "K of the speed loop; larger: stiffer, with less modulus margin",
    "pid.integral_time_s": "T_i; smaller: overcomes friction sooner, and overshoots more",
    "weights.bandwidth_rad_s": "least bandwidth of the loop; larger: faster",
    "weights.disturbance": "weight of friction; larger: better rejection, less modulus margin",
    "weights.drive": "weight of the drive that reaches the actuator; larger: softer",
    "weights.command": "weight of the command; larger: less drive after an encoder count",
    "weights.noise": "weight of encoder noise; larger: softer at high frequency",
    "weights.modulus_margin": "margin that the error weight requires; larger: safer and slower",
    "weights.static_error": "static error that the error weight allows, relative to the reference",
    "channel_effort": "unit of the uncertainty channel",
    "schedule": "parameters that span the polytope; the channel represents all others",
    "position_law.formula": "gain k of the law: speed = k sqrt(error)",
    "position_law.virtual_coulomb_factor": "factor on the friction F of the formula; larger: "
    "brakes later, with more effort",
    "position_law.gain_per_s": "gain of the law; larger: faster, and overshoots more",
    "position_law.action": "the drive brakes inside the band, then becomes 0",
    "position_law.band": "half-width; larger: rests sooner, with a larger static error",
    "position_law.settled_speed": "speed of the prefilter below which the band acts",
    "position_law.rest_speed": "measured speed below which the drive becomes 0",
    "velocity.filter_rad_s": "filter of the measured speed; smaller: quieter, with more lag",
    "velocity.order": "order of the filter of the measured speed",
    "prefilter.natural_frequency_rad_s": "larger: faster, and overshoots more",
    "prefilter.damping": "larger: overshoots less",
    "profile": "from the present position to the reference, within the drive's limit",
    "feedforward": "effort of the model along the reference",
    "friction_compensation.source": "friction of the model, added to the drive",
    "friction_compensation.velocity": "speed that determines the sign of the friction",
    "friction_compensation.smoothing_speed": "speed below which the added friction fades",
    "friction_compensation.gain": "share of the model's friction; larger: starts sooner",
    "recentring": "the inequalities are solved at this multiple of the smallest gamma",
    "ease": "multiple of the gamma of the inequalities; larger: lower gains and more margin",
}
# the same for a position law with `action: none`
EFFECTS_DRIVEN = {
    "position_law.action": "the drive stays on at rest, because the load may exceed the friction",
    "position_law.band": "half-width of the law's linear part; larger: softer at the target",
}


def design_text(design: Design, head: str) -> str:
    """Return the text of a design document with comments, which `synth` reads as the same design.

    head: comment above the document, of one or more lines.
    """
    lines = [f"# {line}" for line in head.splitlines()]
    law = design.position_law
    driven = law is not None and law.action == "none"
    effects = {**EFFECTS, **EFFECTS_DRIVEN} if driven else EFFECTS
    lines += _lines(drop_unset(msgspec.to_builtins(design)), (), effects)
    return "\n".join(lines) + "\n"


def _lines(
    values: Mapping[str, Any], parents: tuple[str, ...], effects: Mapping[str, str]
) -> Iterator[str]:
    for key, value in values.items():
        if isinstance(value, dict) and value and "value" not in value:
            yield f"{'  ' * len(parents)}{key}:"
            yield from _lines(value, (*parents, key), effects)
            continue
        pair = tree_to_yaml({key: value}).strip()  # in flow style if the value is a scalar
        text = "  " * len(parents) + (pair[1:-1] if pair.startswith("{") else pair)
        effect = effects.get(".".join((*parents, key)))
        yield text if effect is None else f"{text:<{COLUMN}}  # {effect}"
