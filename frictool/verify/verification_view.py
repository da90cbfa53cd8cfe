"""Text and JSON of the result of `verify`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import msgspec

from frictool.documents.quantity import drive_dimension, si_unit
from frictool.verify.loop_wording import delay_words, plant_words, rounded_down
from frictool.verify.model_check import ModelCheck
from frictool.verify.proved_bound import ProvedBound
from frictool.verify.recheck import Verification
from frictool.verify.rest_view import rest_lines
from frictool.verify.ringing_loop import RingingCheck, unknown_resonance

NAMES = ("inertia", "viscous", "coulomb", "constant")
MOST_LINES = 12  # differences that the text lists


def json_view(verification: Verification) -> dict[str, Any]:
    """Return the result of `verify` as JSON values."""
    controller, checked = verification.controller, verification.model
    certificate = controller.certificate
    bounds = [
        {
            "of": one.of,
            "below": one.below,
            "cells": one.cells,
            "modulus_margin_above": one.modulus_margin,
            "stable": True,
        }
        for one in verification.proved
    ]
    return {
        "name": controller.name,
        "sample_period_s": controller.sample_period_s,
        "delay_samples": controller.delay_samples,
        "certificate": bounds or None,
        "box": None
        if certificate is None
        else {name: list(getattr(certificate.box, name)) for name in NAMES},
        "not_proved": {} if certificate is None else certificate.not_proved,
        "rest": None if certificate is None else msgspec.to_builtins(certificate.rest),
        "cycle": None if certificate is None else msgspec.to_builtins(certificate.cycle),
        "vertices_rechecked": len(controller.verified.vertices),
        "differences": [asdict(one) for one in verification.differences],
        "changed": list(verification.changed),
        "not_computed": verification.not_computed,
        "model": None if checked is None else _model_json(checked),
        **ringing_json(verification.ringing),
    }


def _model_json(checked: ModelCheck) -> dict[str, Any]:
    resonant, sprung = checked.resonant, checked.sprung
    return {
        "holds": checked.holds,
        "outside": list(checked.beyond),
        "modulus_margin": checked.margin,
        "modulus_margin_with_resonances": None if resonant is None else resonant.modulus_margin,
        "modulus_margin_with_spring": None if sprung is None else sprung.modulus_margin,
        "modulus_margin_specified": checked.specified,
        "at": {name: getattr(checked.plant, name) for name in NAMES},
        "plants": checked.plants,
        "outside_margins": list(checked.outside_margins),
        **ringing_json(checked.ringing),
    }


def ringing_json(rings: RingingCheck | None) -> dict[str, Any]:
    """Return the margin on plants of two inertias as JSON values; {} without a check."""
    if rings is None:
        return {}
    return {
        "ringing": {
            "rad_s": rings.plant.oscillation.rad_s,
            "plant": rings.plant.name,
            "modulus_margin": rings.modulus_margin,
            "shown": rings.shown,
        }
    }


def lines(verification: Verification) -> list[str]:
    """Return the result of `verify` as lines of text."""
    checked = verification.model
    rings = verification.ringing if checked is None else checked.ringing or verification.ringing
    return [
        *_proved(verification),
        *_computed(verification),
        *_model(verification),
        *([] if rings is None else [ringing_line(rings)]),
    ]


def ringing_line(rings: RingingCheck) -> str:
    """Return a line on the margin of an axis that rings after it stops."""
    if rings.doubt:
        return f"undecided: {rings.doubt}"
    return (
        f"on plants of two inertias with the ringing: stable, modulus margin at least "
        f"{rings.modulus_margin:.3f} ({rings.plant.name})"
    )


def _proved(verification: Verification) -> list[str]:
    controller = verification.controller
    certificate = controller.certificate
    if certificate is None or not verification.proved:
        reasons = () if certificate is None else certificate.not_proved.values()
        why = "; ".join(reasons) or "frictool synth computes a certificate"
        return [
            f"{controller.name}: no certificate; the margins are verified at the vertices only "
            f"({why})",
            "  smallest modulus margin of the vertices "
            f"{rounded_down(controller.verified.modulus_margin)}",
        ]
    output = [f"{controller.name}: proved for every constant"]
    constant = drive_dimension(controller.drive, constant=True)
    for name, dimension in zip(NAMES, ("inertia", "viscous", "effort", constant), strict=True):
        low, high = getattr(certificate.box, name)
        output.append(f"  {name:<9} {low:.6g} to {high:.6g} {si_unit(dimension, controller.axis)}")
    output.append(
        f"the sampled loop ({controller.sample_period_s * 1e3:g} ms, "
        f"{delay_words(controller.delay_samples)}) is stable, and"
    )
    return [
        *output,
        *map(_bound, verification.proved),
        *(f"not proved: {reason}" for reason in certificate.not_proved.values()),
        *unknown_resonance(controller),
        *rest_lines(controller, certificate),
    ]


def _bound(one: ProvedBound) -> str:
    cells = f"({one.cells} cell{'s' if one.cells != 1 else ''})"
    if one.modulus_margin is None:
        return f"  norm from the weighted inputs to the weighted outputs < {one.below:.6g} {cells}"
    return (
        f"  largest sensitivity < {one.below:.6g}, modulus margin > "
        f"{rounded_down(one.modulus_margin)} {cells}"
    )


def _computed(verification: Verification) -> list[str]:
    output = []
    controller, differences = verification.controller, verification.differences
    if not differences:
        inside = "" if controller.verified.robustness is None else " and inside the box"
        output.append(
            f"figures recomputed at {len(controller.verified.vertices)} "
            f"vertices{inside}: all equal the stored figures"
        )
    shown = differences[:MOST_LINES]
    output += [
        f"{one.key}: found {_shown(one.stored)}, the coefficients give {_shown(one.computed)}"
        for one in shown
    ]
    if len(differences) > MOST_LINES:
        output.append(
            f"... and {len(differences) - MOST_LINES} more differences (--json lists them)"
        )
    if not controller.verified.digests:
        output.append(
            "verified.digests: missing; a change of the position law or the prefilter "
            "cannot be detected; run synth again"
        )
    elif verification.changed:
        output.append(
            f"changed after verification: {', '.join(verification.changed)}; run synth again"
        )
    if verification.not_computed:
        names = ", ".join(name.removeprefix("verified.") for name in verification.not_computed)
        output.append(f"not computed again, because a design or a solver gave them: {names}")
    return output


def _model(verification: Verification) -> list[str]:
    checked = verification.model
    if checked is None:
        return []
    output = [
        f"model: not covered by the controller's verification: {phrase}"
        for phrase in checked.beyond
    ] or [
        "model: within the controller's intervals, with the same timing, drive limit, winding "
        "and encoder"
    ]
    output.append(
        f"model: smallest modulus margin of {checked.plants} corners {checked.margin:.4f}, "
        f"specified {checked.specified:g}, at "
        f"{plant_words(checked.plant, verification.controller.bench)}"
    )
    for part, check in (("resonances", checked.resonant), ("spring", checked.sprung)):
        if check is not None:
            output.append(
                f"model: smallest modulus margin with its {part} {check.modulus_margin:.4f}, "
                f"specified {checked.specified:g}, at {check.where}"
            )
    output.append(
        "model: nonlinear parts, which no margin covers but simulate includes: "
        f"{', '.join(checked.outside_margins)}"
    )
    return output


def _shown(value: Any) -> str:
    return (
        "nothing" if value is None else f"{value:.6g}" if isinstance(value, float) else str(value)
    )
