"""Transmission of a link: its ratio, its loss in each direction of power, its compliance and play.

    q_b = ratio q_a        effort at a: ratio lambda + loss, with lambda the effort at b

If power flows from end a to end b with the efficiency eta, effort_a = ratio lambda/eta, so that
drive_loss = |ratio| (1/eta - 1) per unit of lambda. If power flows from end b to end a with the
efficiency eta_back, effort_a = ratio lambda eta_back, so that back_loss = |ratio| (1 - eta_back).
The same friction in both directions means eta_back = 2 - 1/eta. For a thread, let alpha be the lead
angle and mu = tan phi the friction coefficient. The torque at the screw per force of the nut is
radius tan(alpha + phi) if the screw drives. It is radius tan(alpha - phi) if the nut drives. The
screw jams if alpha + phi >= 90 deg. Equations of the thesis: gear (2.3), with stiffness and damping
(2.4)-(2.5); belt (2.6); thread (2.10)-(2.13); pistons (2.16); play (2.18); rack (2.19)-(2.20).
"""

from __future__ import annotations

import math

from frictool.adapters.mechanism.block_references import BlockNames, check_compliance
from frictool.documents.mechanism import (
    Backlash,
    Belt,
    Compliance,
    Coupling,
    Gear,
    Hydraulic,
    Rack,
    Screw,
)
from frictool.plant.mechanism.element_error import ElementError
from frictool.plant.mechanism.link_graph import Transmission

Transmitting = Gear | Belt | Screw | Rack | Hydraulic | Coupling
HINTS_FOR_FIXED_BLOCKS = {
    "gear": "leave the fixed block out, or press it on a compliant spring",
    "belt": "leave the fixed block out, or hold it by a spring",
    "screw": "leave the fixed block out, or hold it by a spring",
    "rack": "leave the fixed block out, or hold it by a spring",
    "hydraulic": "leave the fixed block out, or hold it by a spring",
    "coupling": "hold it by a spring, or let it move between stops",
}


def transmission(name: str, link: Transmitting, blocks: BlockNames) -> Transmission:
    """Return the transmission of the link called `name`.

    Raises ElementError with the link's key if ends, units or numbers do not fit.
    """
    key = f"links.{name}"
    kind = str(link.__struct_config__.tag)
    ends = blocks.moving(key, link.between, HINTS_FOR_FIXED_BLOCKS[kind])
    ratio, at_b = _ratio(key, link, ends, blocks)
    drive_loss, back_loss, thread, thesis_screw = _losses(key, link, abs(ratio))
    gap, restitution = 0.0, 0.0
    backlash: Backlash | None = getattr(link, "backlash", None)
    if backlash is not None:
        gap = 0.5 * _width_at_b(key, backlash, ends, abs(ratio), blocks)
        restitution = backlash.restitution
    compliance = _compliance(key, link, ends[1], blocks)
    return Transmission(
        name,
        blocks.index(key, ends[0]),
        blocks.index(key, ends[1]),
        ratio,
        drive_loss,
        back_loss,
        thread,
        thesis_screw,
        gap,
        restitution,
        None if compliance is None else compliance.stiffness.value * at_b**2,
        0.0 if compliance is None else compliance.damping.value * at_b**2,
    )


def _ratio(
    key: str, link: Transmitting, ends: tuple[str, str], blocks: BlockNames
) -> tuple[float, float]:
    """Return the signed ratio, and (deflection of the compliance)/(motion of the second end).

    The second value is the pulley radius for a belt, whose compliance is along the belt. For other
    links, it is 1.
    """
    match link:
        case Gear():
            blocks.sequence(key, "a gear", ends, ("rotary", "rotary"))
            if not (link.ratio > 0.0 and math.isfinite(link.ratio)):
                hint = (
                    "for a gear that keeps the direction, write internal: true"
                    if link.ratio < 0.0
                    else "a ratio of 0 would transmit nothing"
                )
                raise ElementError(f"{key}.ratio", f"found {link.ratio:g}; allowed: > 0; {hint}")
            return (link.ratio if link.internal else -link.ratio), 1.0
        case Belt():
            blocks.sequence(key, "a belt", ends, ("rotary", "rotary"))
            ratio = link.radius_a.value / link.radius_b.value
            return (-ratio if link.crossed else ratio), link.radius_b.value
        case Screw():
            blocks.sequence(key, "a screw", ends, ("rotary", "linear"))
            lead = link.radius.value * tangent_of_lead(key, link)
            return (-lead if link.left_handed else lead), 1.0
        case Rack():
            blocks.sequence(key, "a rack", ends, ("rotary", "linear"))
            return (-link.radius.value if link.reversed else link.radius.value), 1.0
        case Hydraulic():
            blocks.sequence(key, "a hydraulic link", ends, ("linear", "linear"))
            return link.area_a.value / link.area_b.value, 1.0
        case Coupling():
            first = blocks.kind(f"{key}.between", ends[0])
            blocks.sequence(key, "a coupling", ends, (first, first))
            return 1.0, 1.0


def tangent_of_lead(key: str, link: Screw) -> float:
    """Return the tangent of the lead angle; raise ElementError for an impossible angle."""
    if link.lead is not None:
        return link.lead.value / (2.0 * math.pi * link.radius.value)
    assert link.lead_angle is not None
    if link.lead_angle.value >= 0.5 * math.pi:
        raise ElementError(
            f"{key}.lead_angle",
            f"found {math.degrees(link.lead_angle.value):g} deg; allowed: > 0 and < 90 deg",
        )
    return math.tan(link.lead_angle.value)


def _losses(key: str, link: Transmitting, ratio: float) -> tuple[float, float, float, float]:
    if isinstance(link, Screw) and link.friction_coefficient is not None:
        return _thread_losses(key, link, link.friction_coefficient)
    efficiency: float | None = getattr(link, "efficiency", None)
    if efficiency is None:
        return 0.0, 0.0, 0.0, 0.0
    back = back_efficiency(efficiency, getattr(link, "efficiency_back", None))
    return ratio * (1.0 / efficiency - 1.0), ratio * (1.0 - back), 0.0, 0.0


def back_efficiency(efficiency: float, efficiency_back: float | None) -> float:
    """Return the efficiency for power from the second end to the first.

    If `efficiency_back` is None, the result is 2 - 1/efficiency, which follows from the same
    friction in both directions. If the result is 0 or less, the load cannot drive the link.
    """
    return 2.0 - 1.0 / efficiency if efficiency_back is None else efficiency_back


def _thread_losses(key: str, link: Screw, coefficient: float) -> tuple[float, float, float, float]:
    radius = link.radius.value
    steep = tangent_of_lead(key, link)
    angle, phi = math.atan(steep), math.atan(coefficient)
    if angle + phi >= 0.5 * math.pi:
        most = 1.0 / steep
        raise ElementError(
            f"{key}.friction_coefficient",
            (
                f"found {coefficient:g}; the screw jams with this friction; "
                f"allowed: < {most:.4g} = 1/tan(lead angle)"
            ),
        )
    if link.friction_form == "thesis":
        return 0.0, 0.0, coefficient * radius, coefficient * steep
    return (
        radius * (math.tan(angle + phi) - steep),
        radius * (steep - math.tan(angle - phi)),
        0.0,
        0.0,
    )


def _width_at_b(
    key: str, backlash: Backlash, ends: tuple[str, str], ratio: float, blocks: BlockNames
) -> float:
    where = f"{key}.backlash"
    kinds = tuple(blocks.kind(where, end) for end in ends)
    units = {"rotary": "rad", "linear": "m"}
    fitting = [
        end for end, kind in zip(ends, kinds, strict=True) if units[kind] == backlash.width.unit
    ]
    if not fitting:
        whose = " or ".join(f"{end}'s {units[kind]}" for end, kind in zip(ends, kinds, strict=True))
        raise ElementError(
            f"{where}.width.unit",
            (
                f"found a multiple of {backlash.width.unit}, which is the unit of neither "
                f"end; allowed: {whose}"
            ),
        )
    if backlash.at is not None and backlash.at not in ends:
        raise ElementError(
            f"{where}.at",
            f"found {backlash.at!r}; allowed: an end of {key.partition('.')[2]}, "
            f"{' or '.join(ends)}",
        )
    if backlash.at is not None and backlash.at not in fitting:
        raise ElementError(
            f"{where}.at",
            (
                f"found {backlash.at}, whose position is not measured in {backlash.width.unit}"
                f"; allowed: {fitting[0]}"
            ),
        )
    at = backlash.at or fitting[-1]
    return backlash.width.value * (ratio if at == ends[0] else 1.0)


def _compliance(key: str, link: Transmitting, end: str, blocks: BlockNames) -> Compliance | None:
    backlash: Backlash | None = getattr(link, "backlash", None)
    flanks = None if backlash is None else backlash.compliance
    if link.compliance is not None and flanks is not None:
        raise ElementError(
            f"{key}.backlash.compliance",
            (
                "found a compliance of the link and one of its backlash; allowed: one compliance, "
                "with the elasticity and the damping of both"
            ),
        )
    if link.compliance is not None and backlash is not None and backlash.restitution:
        raise ElementError(
            f"{key}.backlash.restitution",
            (
                "found restitution and a compliance of the link; both determine the rebound; "
                "allowed: one of them"
            ),
        )
    where = f"{key}.compliance" if flanks is None else f"{key}.backlash.compliance"
    compliance = link.compliance or flanks
    if isinstance(link, Belt):
        check_compliance(where, compliance, "linear", "the compliance is along the belt, which")
    else:
        check_compliance(
            where, compliance, blocks.kind(key, end), f"the compliance is at {end}, which"
        )
    return compliance
