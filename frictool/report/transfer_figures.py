"""Gains of all vertices over frequency, with limiting templates (thesis figures 5.13 to 5.16)."""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.presentation.colours import INK
from frictool.presentation.plot import DASHED
from frictool.presentation.sections import PageFigure
from frictool.presentation.tie_rule import largest
from frictool.report.figure_style import LIMIT, LOG_COLOURS, new_plot
from frictool.report.requirement import number
from frictool.verify.vertex_transfers import Name, VertexTransfer, VertexTransfers

DEEPEST = 100.0  # dB below the largest gain, lower end of the plot
TITLES: dict[Name, str] = {
    "error": "Sensitivity e/{y}<sub>c</sub>",
    "drive": "Drive {u}/{y}<sub>c</sub>",
    "disturbance": "Error from friction, e/w",
    "output": "{output} {y}/{y}<sub>c</sub>",
}
TEMPLATES: dict[Name, str] = {"error": "γ/|W₂|", "drive": "γ/W₃", "disturbance": "γ/|W₁ W₂|"}


def transfer_views(controller: Controller, curves: VertexTransfers) -> list[PageFigure]:
    """Return one figure for each transfer function, with a curve for each vertex of the controller.

    The curve of the worst vertex is thick, and the template is dashed.
    """
    return [_view(controller, curves, transfer) for transfer in curves.transfers]


def symbols(controller: Controller) -> dict[str, str]:
    """Return the symbols y (controlled quantity) and u (drive), and the name of y, for titles."""
    rotary, position = controller.axis == "rotary", controller.structure == "position"
    y = ("θ" if rotary else "x") if position else ("ω" if rotary else "v")
    return {
        "y": y,
        "u": "i" if controller.drive == "current" else "u",
        "output": "Position" if position else "Speed",
    }


def _view(controller: Controller, curves: VertexTransfers, transfer: VertexTransfer) -> PageFigure:
    title = Markup(TITLES[transfer.name]).format(**symbols(controller))
    strong = (
        curves.vertices.index(transfer.worst.vertex)
        if transfer.worst
        else largest(transfer.gains.max(axis=1))[1]
    )
    outside = transfer.worst is not None and transfer.worst.ratio > 1.0
    levels = _decibels(transfer.gains)
    top = float(levels.max())
    plot = new_plot("gain [dB]", x_label="angular frequency [rad/s]")
    plot.is_log = True
    plot.x_range = float(curves.frequencies[0]), float(curves.frequencies[-1])
    (panel,) = plot.panels
    for index, level in enumerate(levels):
        alpha, width, order = (1.0, 1.4, 3.0) if index == strong else (0.35, 0.8, 2.0)
        colour = LIMIT if index == strong and outside else LOG_COLOURS[0]
        panel.line(curves.frequencies, level, colour, alpha=alpha, width=width, order=order)
    if transfer.template is not None:
        template = _decibels(transfer.template)
        top = max(top, min(float(template.max()), top + 40.0))
        panel.line(curves.frequencies, template, INK, width=1.0, dash=DASHED, order=4.0)
    high = top + 5.0
    panel.y_range = (max(float(levels.min()), high - DEEPEST) - 5.0, high)
    svg = plot.svg(f"transfer of the {transfer.name} at every vertex")
    return PageFigure(title, svg, _caption(controller, curves, transfer))


def _decibels(
    gains: np.ndarray[tuple[int, ...], np.dtype[np.float64]],
) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return 20.0 * np.log10(np.maximum(gains, 1e-300))


def _caption(controller: Controller, curves: VertexTransfers, transfer: VertexTransfer) -> str:
    unit = _unit(controller, transfer.name)
    vertices = f"{len(curves.vertices)} vertices, sampled with the bench's delay" + (
        f"; 0 dB is 1 {unit}" if unit else ""
    )
    if transfer.name == "output":
        peak, at = largest(transfer.gains.max(axis=1))
        before = " Without the prefilter." if controller.prefilter is not None else ""
        return f"{vertices}; largest {number(peak)} at vertex {curves.vertices[at]}.{before}"
    if transfer.worst is None or transfer.template is None:
        return f"{vertices}; no template, because its weight is 0 or not in the document."
    worst = transfer.worst
    share = (
        f"largest gain {100.0 * worst.ratio:.3g} % of the template, at vertex {worst.vertex}, "
        f"{number(worst.frequency)} rad/s"
    )
    gamma = f"γ = {number(curves.gamma)} {'requested' if curves.is_requested else 'verified'}"
    return (
        f"{vertices}. Dashed: the template {TEMPLATES[transfer.name]}, {gamma}; "
        f"{'OUTSIDE: ' if worst.ratio > 1.0 else ''}{share}."
    )


def _unit(controller: Controller, name: Name) -> str:
    moved = si_unit(
        "position" if controller.structure == "position" else "velocity", controller.axis
    )
    drive = si_unit(controller.drive, controller.axis)
    return {
        "error": "",
        "output": "",
        "drive": f"{drive} per {moved}",
        "disturbance": f"{moved} per full friction",
    }[name]
