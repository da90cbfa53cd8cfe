"""Bar chart of the modulus margin of every vertex against the required margin."""

from __future__ import annotations

import numpy as np

from frictool.documents.controller import Controller
from frictool.documents.spec import Spec
from frictool.presentation.colours import MUTED
from frictool.presentation.plot import DASHED
from frictool.presentation.sections import PageFigure
from frictool.report.figure_style import LIMIT, LOG_COLOURS, new_plot

BAR = 0.7  # width of a bar


def margin_figure(spec: Spec, controller: Controller) -> PageFigure | None:
    """Return a bar chart with the modulus margin of each vertex, in the controller's order.

    A bar is red if the vertex is unstable or has less than the required margin. The result is None
    if the controller has no vertices.
    """
    vertices = controller.verified.vertices
    if not vertices:
        return None
    specified = (
        spec.modulus_margin
        if spec.modulus_margin is not None
        else controller.verified.modulus_margin_specified
    )
    heights = [vertex.modulus_margin if vertex.stable else 0.0 for vertex in vertices]
    colours = [
        LOG_COLOURS[0] if vertex.stable and vertex.modulus_margin >= specified else LIMIT
        for vertex in vertices
    ]
    plot = new_plot("modulus margin", x_label="vertex, numbered as in the controller")
    plot.is_numbered = True
    plot.x_range = (0.4, len(vertices) + 0.6)
    (panel,) = plot.panels
    panel.y_range = (0.0, max(1.0, *heights))
    for index, (height, colour) in enumerate(zip(heights, colours, strict=True), start=1):
        sides = index + BAR * np.array([-0.5, 0.5, 0.5, -0.5, -0.5])
        panel.area(sides, height * np.array([0.0, 0.0, 1.0, 1.0, 0.0]), colour, order=1.0)
    panel.horizontal(specified, MUTED, width=1.2, dash=DASHED)
    svg = plot.svg("modulus margin of each vertex")
    return PageFigure(
        "Modulus margin at the vertices",
        svg,
        f"Dashed: the specified margin, {specified:g}. An unstable vertex has no margin.",
    )
