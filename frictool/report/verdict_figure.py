"""Figure of a verdict: position and drive of the judged streams; the worst stream is red."""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictool.documents.quantity import si_unit
from frictool.presentation.svg import PAGE, drawing, panels
from frictool.report.curve_figures import draw, draw_references, log_colours, nominal_last
from frictool.report.figure_style import MARGINS, WIDTH, new_plot
from frictool.report.stream_selection import select_streams

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from frictool.report.requirement import Verdict

HEIGHT = 4.5  # inches


def verdict_figure(verdict: Verdict) -> Figure:
    """Return the figure; its title states how many requirements are met."""
    spec = verdict.request.spec
    evidence = nominal_last([item for item, _ in select_streams(verdict)])
    colours = log_colours(evidence)
    plot = new_plot(
        f"position [{si_unit('position', spec.axis)}]",
        f"{spec.drive} [{si_unit(spec.drive, spec.axis)}]",
    )
    position, drive = plot.panels
    for item in evidence:
        colour = colours[item.source]
        if item.has("position"):
            draw(position, item, colour, item.stream.time, item.stream.signals["position"])
        if item.drive is not None:
            draw(drive, item, colour, item.stream.time, item.drive)
    draw_references(position, [item for item in evidence if item.has("reference")])
    with drawing("verdict", PAGE):
        figure, axes = panels((WIDTH, HEIGHT), MARGINS, 2, ratios=[1.6, 1.0], space=plot.space)
        for one, panel in zip(axes, plot.panels, strict=True):
            for mark in panel.marks:
                one.plot(
                    mark.x,
                    mark.y,
                    color=mark.colour,
                    alpha=mark.alpha,
                    linewidth=mark.width,
                    linestyle=(0, mark.dash) if mark.dash else "-",
                    zorder=mark.order,
                    label=mark.label,
                )
            one.set_ylabel(panel.y_label)
        axes[-1].set_xlabel("time [s]")
        met = sum(one.met is True for one in verdict.requirements)
        axes[0].set_title(
            f"{spec.name}: {verdict.state}, {met} of {len(verdict.requirements)} requirements met",
            loc="left",
            fontsize=9.0,
        )
    return figure
