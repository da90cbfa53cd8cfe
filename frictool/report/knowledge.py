"""Source of each requirement's outcome: measured, simulated, computed or proved."""

from __future__ import annotations

from dataclasses import replace

from frictool.documents.controller import Controller
from frictool.documents.proof import Proof
from frictool.report.evidence import StreamEvidence
from frictool.report.requirement import Requirement

PROVED = "proved for every initial position within the start's encoder count, with the plants {}"
BOX_PROVED = "proved for every start and every plant of the box"
CERTIFIED = "proved for every constant plant of the certificate's box"


def with_knowledge(
    requirement: Requirement,
    streams: list[StreamEvidence],
    controller: Controller | None,
    proof: Proof | None,
) -> Requirement:
    """Return a copy of the requirement whose field `known` states the source of the outcome.

    The field also names the proof if the proof shows that the requirement is met.
    """
    if requirement.key == "modulus_margin":
        return replace(requirement, known=_margin(requirement, controller))
    if requirement.met is None:
        return requirement
    simulated = len({one.stream.topic for one in streams if one.simulated})
    recorded = sum(not one.simulated for one in streams)
    parts = [f"simulated on {simulated} plant{'s' * (simulated > 1)}"] if simulated else []
    parts += [f"measured in {recorded} stream{'s' * (recorded > 1)}"] if recorded else []
    if requirement.met and proof is not None:
        parts += _proved(requirement, proof)
    return replace(requirement, known=", ".join(parts))


def _margin(requirement: Requirement, controller: Controller | None) -> str:
    certificate = None if controller is None else controller.certificate
    margins = [
        one.modulus_margin
        for one in (() if certificate is None else certificate.bounds)
        if one.modulus_margin is not None
    ]
    if requirement.met and margins and max(margins) >= requirement.limit:
        return CERTIFIED
    return "" if requirement.met is None else "computed for the plants"


def _proved(requirement: Requirement, proof: Proof) -> list[str]:
    claims = [
        one for one in proof.requirements if one.key == requirement.key and one.state == "proved"
    ]
    if any(one.box is not None and one.box <= requirement.limit for one in claims):
        return [BOX_PROVED]
    if any(one.value is not None and one.value <= requirement.limit for one in claims):
        shares = [one.share or 0.0 for one in claims if one.limit <= requirement.limit]
        share = max(shares, default=0.0)
        box = f", and for {100.0 * share:.3g} % of the box" if share else ""
        return [PROVED.format(", ".join(proof.plants)) + box]
    return []
