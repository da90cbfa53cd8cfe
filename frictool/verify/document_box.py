"""Parameter intervals of a controller document, from its certificate or its vertices."""

from __future__ import annotations

from frictool.adapters.parameter_intervals import bench_intervals
from frictool.documents.controller import Controller
from frictool.errors import NoSolutionError
from frictool.plant.parameter_box import enclosing_box
from frictool.plant.polytope import PARAMETERS, PlantPoint, corner_points
from frictool.verify.loop_wording import plant_words
from frictool.verify.vertices import vertex_points


def box_of(controller: Controller) -> dict[str, tuple[float, float]]:
    """Return the interval (low, high) [SI] of each plant parameter.

    The certificate states the intervals. Without a certificate, the function returns the smallest
    intervals that contain all vertices.
    """
    if controller.certificate is None:
        return enclosing_box(vertex_points(controller))
    low_and_high = {name: getattr(controller.certificate.box, name) for name in PARAMETERS}
    return {name: (low, high) for name, (low, high) in low_and_high.items()}


def check_box(controller: Controller) -> None:
    """Check that a document's parameter intervals contain its vertices and the bench's ranges.

    Raises NoSolutionError if an interval is too narrow, or if the document has no vertex.
    """
    vertices = vertex_points(controller)
    holder = "the vertices" if controller.certificate is None else "the certificate"
    for name, (low, high) in box_of(controller).items():
        for point in vertices:
            if not low <= (value := getattr(point, name)) <= high:
                raise NoSolutionError(
                    f"{controller.name}: not proved: {name} is {value:.6g} in vertex {point.name}, "
                    f"but {low:.6g} to {high:.6g} in {holder}; run frictool synth again"
                )
        least, most = bench_intervals(controller.bench)[name]
        if least < low or most > high:
            raise NoSolutionError(
                f"{controller.name}: not proved: {name} is {least:.6g} to {most:.6g} in the bench, "
                f"but {low:.6g} to {high:.6g} in {holder}; run frictool synth again"
            )


def check_corners(controller: Controller) -> None:
    """Check that every corner of the certificate's parameter intervals is a vertex of the document.

    A document without a certificate passes. Raises NoSolutionError if a corner is not a vertex.
    """
    if controller.certificate is None:
        return
    vertices = {_parameters(point) for point in vertex_points(controller)}
    for corner in corner_points(box_of(controller)):
        if _parameters(corner) not in vertices:
            words = plant_words(corner, controller.bench)
            raise NoSolutionError(
                f"{controller.name}: not verified: the certificate's intervals have a corner that "
                f"is no vertex of the document: {words}; run frictool synth again"
            )


def _parameters(point: PlantPoint) -> tuple[float, ...]:
    return tuple(getattr(point, name) for name in PARAMETERS)
