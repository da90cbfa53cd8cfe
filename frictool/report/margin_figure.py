"""Bar chart of the modulus margin of every vertex against the required margin."""

from __future__ import annotations

from matplotlib.ticker import MaxNLocator

from frictool.documents.controller import Controller
from frictool.documents.spec import Spec
from frictool.presentation.sections import PageFigure
from frictool.presentation.svg import MUTED, render_compact
from frictool.report.figure_style import LIMIT, LOG_COLOURS, drawing, new_figure


def margin_figure(spec: Spec, controller: Controller) -> PageFigure | None:
    """Return a chart with one bar per vertex, in the controller's order; None without vertices.

    A bar is red if the vertex is unstable or has less than the required margin.
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
    with drawing("modulus margin"):
        figure, (axes,) = new_figure()
        axes.bar(range(1, len(vertices) + 1), heights, color=colours, width=0.7)
        axes.axhline(specified, color=MUTED, linewidth=1.2, linestyle=(0, (4, 2)))
        axes.grid(visible=False, axis="x")
        axes.xaxis.set_major_locator(MaxNLocator(16, integer=True, min_n_ticks=1))
        axes.set(
            xlabel="vertex, in the order of the table",
            ylabel="modulus margin",
            ylim=(0.0, max(1.0, *heights)),
            xlim=(0.4, len(vertices) + 0.6),
        )
        svg = render_compact(figure, "modulus margin of each vertex")
    return PageFigure(
        "Modulus margin at the vertices",
        svg,
        f"Dashed: the specified margin, {specified:g}. An unstable vertex has no margin.",
    )
