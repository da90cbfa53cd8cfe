"""Vertices of a controller document as plants."""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.errors import NoSolutionError
from frictool.plant.polytope import PlantPoint


def vertex_points(controller: Controller) -> tuple[PlantPoint, ...]:
    """Return the plants that a document names as its vertices.

    Raises
    ------
    NoSolutionError
        If the document names no vertex, so that its loop cannot be verified.
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
