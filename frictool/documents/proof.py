"""`proof.yaml`: outcome of `frictool prove` for a step test, with the documents of the test."""

from __future__ import annotations

import hashlib
import json
from typing import Annotated, Any, Literal

import msgspec

from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec

Count = Annotated[int, msgspec.Meta(ge=0)]


class ProvedRequirement(
    msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """One requirement of the specification with its outcome.

    - `key`: Key of the specification.
    - `state`: `proved`: the requirement is met from every initial position in `starts`. `refuted`:
      the requirement is violated from the initial position `start`. `undecided`: `reason` says why.
    - `limit`: Limit of the specification.
    - `value`: Worst value over all plants and initial positions.
    - `box`: Bound of the value for every plant whose parameters are in their intervals. If this key
      is absent, the outcome is valid only for the plants listed in the proof.
    - `share`: Fraction of the parameter box that the cells of the proof cover, 0 to 1. The
      requirement is proved for every plant in these cells.
    - `plant`: Plant for which the requirement is refuted or undecided.
    - `start`: Position at rest [rad | m] from which the requirement is violated.
    - `reason`: Reason for an undecided requirement.
    """

    key: str
    state: Literal["proved", "refuted", "undecided"]
    limit: float
    value: float | None = None
    plant: str = ""
    start: float | None = None
    reason: str = ""
    box: float | None = None
    share: float | None = None


class Proof(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Proof of a step test for every initial position within an encoder count: `proof.yaml`.

    The file contains the documents of the test, so that `frictool verify` needs this file only.

    - `number`: Number format of the controller.
    - `plants`: Plants, by the names of the scenario's variants.
    - `starts`: Lowest and highest position [rad | m] with the same encoder count as the scenario's
      start.
    - `runs`: Number of intervals of initial positions, summed over the plants. All initial
      positions in an interval give the same encoder readings.
    - `open_share`: Fraction of the initial positions for which nothing is proved; the largest of
      all plants.
    - `requirements`: Requirements in the order of the specification.
    - `cells`: Cells of the parameter box for which the requirements are proved. A cell is a
      sequence of letters, each of which halves the box. c, f and v select the lower half of
      constant, Coulomb friction and viscous friction, each divided by the inertia; C, F and V
      select the upper half.
    - `model`, `controller`, `scenario`, `spec`: Documents of the step test.
    - `digest`: SHA-256 of the other keys.
    """

    format: Literal["proof/1"]
    name: str
    axis: Axis
    number: ProgramNumber
    plants: tuple[str, ...]
    starts: tuple[float, float]
    runs: Count
    open_share: float
    requirements: tuple[ProvedRequirement, ...]
    model: Model
    controller: Controller
    scenario: Scenario
    spec: Spec
    provenance: Provenance
    cells: tuple[str, ...] = ()
    digest: str = ""


def proof_digest(proof: Proof) -> str:
    """Return the SHA-256 of all values of a proof except `digest`.

    The digest does not depend on the layout of the file.
    """
    values: dict[str, Any] = msgspec.to_builtins(msgspec.structs.replace(proof, digest=""))
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()
