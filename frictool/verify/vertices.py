"""Vertices of a controller document as plants with constant parameters."""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.errors import NoSolutionError
from frictool.plant.polytope import PlantPoint


def vertex_points(controller: Controller) -> tuple[PlantPoint, ...]:
    """Return the plants of a controller document's vertices.

    Raises NoSolutionError if the document has no vertex, so that its loop cannot be verified.
    """
    vertices = controller.verified.vertices
    if not vertices:
        raise NoSolutionError(
            f"{controller.name}: not verified: the controller names no vertex; run "
            "frictool synth again"
        )
    return tuple(
        PlantPoint(one.name, one.inertia, one.viscous, one.coulomb, one.constant)
        for one in vertices
    )
