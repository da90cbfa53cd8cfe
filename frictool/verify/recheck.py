"""Comparison of the norms and margins in a controller document with recomputed values."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import msgspec

from frictool.documents.controller import Controller, Robustness, Rounded, Schedule, Verified
from frictool.documents.digests import SOLVED, changed_blocks, uncomputed_figures
from frictool.documents.model import Model
from frictool.plant.polytope import corner_points
from frictool.presentation.tie_rule import TOLERANCE
from frictool.runtime.object_view import ResultView
from frictool.verify.certificate_document import prove_document
from frictool.verify.document_box import box_of, check_box, check_corners
from frictool.verify.document_check import check_document
from frictool.verify.interior_search import points_inside
from frictool.verify.loop_values import (
    CLAIM,
    HELD,
    OFFERED,
    LinearLoops,
    loops_of,
    tolerates_rounding,
)
from frictool.verify.model_check import ModelCheck, check_model
from frictool.verify.proved_bound import ProvedBound
from frictool.verify.rest_proof import prove_rest
from frictool.verify.ringing_loop import RingingCheck, ringing_check
from frictool.verify.scheduled_loop import scheduled_figures
from frictool.verify.vertices import vertex_points

# Relative differences that rounding on another processor may cause; figures without an entry here
# agree within TOLERANCE.
SEARCHED = 1e-3  # figures of a search, which may end at another plant nearby
ROOTS = 1e-3  # spectral radius: a multiple eigenvalue moves by a root of the rounding error
TOLERANCES = {"interior": SEARCHED, "spectral_radius": ROOTS}


@dataclass(frozen=True)
class FigureDifference:
    """Stored value of a document that differs from the computed value.

    - key: path of the value in the document
    - stored, computed: the two values; None stands for a missing value
    """

    key: str
    stored: Any
    computed: Any


@dataclass(frozen=True, eq=False, repr=False)
class Verification(ResultView):
    """Result of `verify`.

    - model: check with a model; None if there was no model
    - proved: proved bounds of the certificate
    - differences: stored values that differ from the computed values
    - changed: blocks that were changed after the verification
    - not_computed: stored values that `verify` cannot compute, by their keys
    - ringing: margin on plants of two inertias; None if the document has no `ringing`, or if
      `model` contains this margin
    """

    controller: Controller
    model: ModelCheck | None
    proved: tuple[ProvedBound, ...]
    differences: tuple[FigureDifference, ...]
    changed: tuple[str, ...]
    not_computed: dict[str, float]
    ringing: RingingCheck | None = None

    @property
    def unaltered(self) -> bool:
        """Return True if no value differs from its stored value, and no block was changed."""
        return not self.differences and not self.changed

    @property
    def holds(self) -> bool:
        """Return True if at least one bound is proved, nothing was altered, and all checks pass."""
        shown = self.ringing is None or self.ringing.shown
        return (
            bool(self.proved)
            and self.unaltered
            and shown
            and (self.model is None or self.model.holds)
        )


def verify(controller: Controller, model: Model | None = None) -> Verification:
    """Prove the certificate of a controller, and recompute the stored values.

    The document stores these values under the keys `verified` and `schedule`.

    Parameters
    ----------
    controller : Controller
        Controller document.
    model : Model, optional
        Model for which the controller must be verified.

    Returns
    -------
    Verification
        Differences of stored and computed values beyond rounding errors, blocks of the document
        that were changed after its verification, and the check with the model.

    Raises
    ------
    NoSolutionError
        If a bound is missing or not proved, the certificate's intervals do not contain the
        parameter ranges of the bench, a loop is unstable or has less than the specified margin, or
        the stored forms of the linear controller differ.
    FrictoolError
        If axis, drive or timing differ between the model's bench and the controller.
    """
    checked = None if model is None else check_model(controller, model)
    check_box(controller)
    certificate = controller.certificate
    proved = () if certificate is None else prove_document(controller, certificate)
    check_document(controller)
    differences = (*_differences(controller), *_contradicted_bounds(controller.verified))
    ringing = None
    if controller.ringing is not None and (checked is None or checked.ringing is None):
        ringing = ringing_check(controller, vertex_points(controller), controller.ringing)
    return Verification(
        controller,
        checked,
        proved,
        differences,
        changed_blocks(controller),
        uncomputed_figures(controller.verified),
        ringing,
    )


def recheck(controller: Controller) -> None:
    """Check a document before its coefficients are used: intervals, stability and margins.

    Raises NoSolutionError in these cases:

    - The document's intervals do not contain the parameter ranges of the bench.
    - A corner of the certificate's intervals is not a vertex of the document.
    - A loop at a vertex is unstable or has less than the specified margin.
    - A margin under `verified` differs from the margin of the coefficients.
    """
    check_document(controller, margins=True)
    check_box(controller)
    check_corners(controller)


def _differences(controller: Controller) -> tuple[FigureDifference, ...]:
    computed: dict[str, Any] = {"verified": computed_figures(controller)}
    stored: dict[str, Any] = {"verified": controller.verified, "schedule": controller.schedule}
    if controller.schedule is not None:
        computed["schedule"] = _scheduled(controller, controller.schedule)
    certificate = controller.certificate
    if certificate is not None and certificate.rest is not None:
        computed["certificate.rest"] = prove_rest(controller, certificate)
        stored["certificate.rest"] = certificate.rest
    return tuple(
        difference
        for name, figures in computed.items()
        for difference in _compared(
            name, msgspec.to_builtins(stored[name]), msgspec.to_builtins(figures)
        )
    )


def computed_figures(controller: Controller) -> Verified:
    """Return the values under `verified` that need no solver, computed from the coefficients.

    The loops are evaluated at the corners of the parameter intervals.
    """
    verified = controller.verified
    loops = loops_of(controller, corner_points(box_of(controller)))
    vertices = tuple(loops.vertex(point) for point in loops.points)
    gamma = max(vertex.sampled_norm for vertex in vertices)
    by_observer = (
        controller.velocity.observer is not None and controller.linear.input == "speed_error"
    )
    return msgspec.structs.replace(
        verified,
        gamma_verified=gamma,
        vertices=vertices,
        count_drive=loops.count_drive(),
        rounded=() if by_observer else _rounded(loops, verified, gamma),
        margins=loops.margins(),
        robustness=None if by_observer else _robustness(controller, loops),
    )


def _rounded(loops: LinearLoops, verified: Verified, gamma: float) -> tuple[Rounded, ...]:
    """Return norm and margin after rounding, for each number format that the loop tolerates.

    If the result of a format is within TOLERANCE of a limit, the document decides: a format that it
    lists counts as tolerated.
    """
    listed = {one.number for one in verified.rounded}
    differences = []
    for number in (*HELD, *OFFERED):
        one = loops.rounded(number)
        tolerance = TOLERANCE if number in listed else -TOLERANCE
        if tolerates_rounding(
            one, gamma * (1.0 + tolerance), verified.modulus_margin_specified * (1.0 - tolerance)
        ):
            differences.append(one)
    return tuple(differences)


def needs_search(controller: Controller) -> bool:
    """Return True if a search must estimate the largest norm between the vertices.

    No search is needed if a bound proves that the norm is at most CLAIM times the norm at the
    vertices. For a loop without weights, the sensitivity replaces the norm.
    """
    bounds = () if controller.certificate is None else controller.certificate.bounds
    most = CLAIM * controller.verified.gamma_verified
    of = "sensitivity" if controller.judged_by is None else "norm"
    return not any(bound.of == of and bound.below <= most for bound in bounds)


def _robustness(controller: Controller, loops: LinearLoops) -> Robustness | None:
    known = controller.verified.robustness
    if known is None and (controller.certificate is None or not needs_search(controller)):
        return None
    count = points_inside(loops.points)
    interior = loops.seen_inside()
    return msgspec.structs.replace(
        known or Robustness(count, interior), interior_points=count, interior=interior
    )


def _scheduled(controller: Controller, schedule: Schedule) -> Schedule:
    loops = loops_of(controller, ())
    figures = scheduled_figures(
        schedule.corners, schedule.parameters, loops.plant, loops.lag, loops.delay, loops.period
    )
    return msgspec.structs.replace(
        schedule, gamma=figures.gamma, modulus_margin=figures.modulus_margin, points=figures.points
    )


def _contradicted_bounds(verified: Verified) -> Iterator[FigureDifference]:
    """Yield each stored upper bound of the norm that is below the verified norm, thus false."""
    if verified.robustness is None:
        return
    for name in SOLVED:
        bound = getattr(verified.robustness, name)
        if bound is not None and bound < verified.gamma_verified * (1.0 - SEARCHED):
            yield FigureDifference(
                f"verified.robustness.{name}", bound, f"at least {verified.gamma_verified:.6g}"
            )


def _compared(key: str, stored: Any, computed: Any) -> Iterator[FigureDifference]:
    if isinstance(stored, dict) and isinstance(computed, dict):
        for name in {**stored, **computed}:
            yield from _compared(f"{key}.{name}", stored.get(name), computed.get(name))
    elif isinstance(stored, (list, tuple)) and isinstance(computed, (list, tuple)):
        if len(stored) != len(computed):
            yield FigureDifference(key, f"{len(stored)} entries", f"{len(computed)} entries")
            return
        for index, pair in enumerate(zip(stored, computed, strict=True)):
            yield from _compared(f"{key}[{index}]", *pair)
    elif not _agree(key, stored, computed):
        yield FigureDifference(key, stored, computed)


def _agree(key: str, stored: Any, computed: Any) -> bool:
    if not all(
        isinstance(value, (int, float)) and not isinstance(value, bool)
        for value in (stored, computed)
    ):
        return bool(stored == computed)
    tolerance = TOLERANCES.get(key.rpartition(".")[2], TOLERANCE)
    return bool(
        stored == computed or abs(stored - computed) <= tolerance * max(abs(stored), abs(computed))
    )
