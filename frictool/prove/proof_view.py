"""Text and JSON of a proof."""

from __future__ import annotations

from typing import Any

import msgspec

from frictool.documents.metric_table import REQUIREMENTS, requirement_title
from frictool.documents.proof import Proof, ProvedRequirement
from frictool.documents.quantity import si_unit
from frictool.verify.rest_proof import prove_rest
from frictool.verify.rest_view import rest_lines

STATES = {"proved": "PROVED", "refuted": "REFUTED", "undecided": "UNDECIDED"}


def verdict_of(proof: Proof) -> str:
    """Return the worst state of all requirements: `refuted`, `undecided` or `proved`."""
    states = {one.state for one in proof.requirements}
    return "refuted" if "refuted" in states else "proved" if states == {"proved"} else "undecided"


def json_view(proof: Proof, differing: tuple[str, ...] | None) -> dict[str, Any]:
    """Return a proof as JSON values.

    differing: keys in which a repeated proof differs from the stored proof; None if the proof was
    not repeated.
    """
    return {
        "name": proof.name,
        "verdict": verdict_of(proof),
        "plants": list(proof.plants),
        "number": proof.number,
        "starts": list(proof.starts),
        "runs": proof.runs,
        "open_share": proof.open_share,
        "cells": len(proof.cells),
        "requirements": [
            {
                "key": one.key,
                "state": one.state,
                "limit": one.limit,
                "value": one.value,
                "plant": one.plant,
                "start": one.start,
                "reason": one.reason,
                "box": one.box,
                "share": one.share,
            }
            for one in proof.requirements
        ],
        "rest_in_band": None
        if proof.controller.certificate is None
        else msgspec.to_builtins(proof.controller.certificate.rest),
        "differing": None if differing is None else list(differing),
    }


def lines(proof: Proof) -> list[str]:
    """Return a proof as lines of text."""
    unit = si_unit("position", proof.axis)
    low, high = proof.starts
    head = (
        f"{proof.name}: {_plants(proof)}, every start from {low:.6g} to {high:.6g} {unit}, "
        f"controller in {proof.number}: {proof.runs} runs cover the starts"
    )
    if proof.open_share:
        share = 100.0 * proof.open_share
        head += f"; nothing is proved for up to {share:.3g} % of the starts of a plant"
    return [head, *(_requirement(one, unit) for one in proof.requirements), *_rest_in_band(proof)]


def _rest_in_band(proof: Proof) -> list[str]:
    controller, certificate = proof.controller, proof.controller.certificate
    if certificate is None:
        return []
    rest = prove_rest(controller, certificate)
    if rest is None or rest.verdict != "proved":
        return []
    again = msgspec.structs.replace(certificate, rest=rest, cycle=None)
    figures = 2 if rest.speed > 0.0 else 1  # the lines after these are the checks of the proof
    return rest_lines(controller, again)[:figures]


def _plants(proof: Proof) -> str:
    if len(proof.plants) == 1:
        return f"{proof.plants[0]} plant"
    return f"{len(proof.plants)} plants ({proof.plants[0]}, {proof.plants[1]} ...)"


def confirmation(again: Proof, differing: tuple[str, ...]) -> list[str]:
    """Return lines of text that state whether a repeated proof confirms the stored proof.

    - again: repeated proof
    - differing: keys in which the stored proof differs from `again`; empty if the stored proof is
      confirmed
    """
    if not differing:
        return [
            *lines(again),
            "proved again from the documents in the file: all results are confirmed",
        ]
    return [
        *lines(again),
        f"not confirmed: file and repeated proof differ in {', '.join(differing)}",
    ]


def _requirement(one: ProvedRequirement, unit: str) -> str:
    metric = REQUIREMENTS[one.key]
    value = "" if one.value is None else f", at most {one.value:.4g}"
    if one.key == "modulus_margin":
        value = "" if one.value is None else f", above {one.value:.4g}"
    if one.box is not None and one.box != one.value:
        value += f"; for every plant of the box at most {one.box:.4g}"
    elif one.box is not None:
        value += " for every plant of the box"
    if one.share is not None:
        value += f"; limit proved for {100.0 * one.share:.3g} % of the box"
    text = f"  {STATES[one.state]:<10} {requirement_title(metric.requirement_name)}{value}"
    text += f" (limit {one.limit:.4g})"
    if one.start is not None:
        text += f", violated by the {one.plant} plant from the start {one.start!r} {unit}"
    elif one.plant:
        text += f", undecided for the {one.plant} plant"
    return f"{text}: {one.reason}" if one.reason else text
