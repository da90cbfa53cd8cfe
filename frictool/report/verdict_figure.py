"""Figure of a verdict: position and drive of the judged streams; the worst one is red."""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictool.documents.quantity import si_unit
from frictool.report.curve_figures import draw, draw_references, log_colours, nominal_last
from frictool.report.figure_style import drawing, new_figure
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
    with drawing("verdict"):
        figure, (position, drive) = new_figure(2, HEIGHT)
        for item in evidence:
            colour = colours[item.source]
            if item.has("position"):
                draw(position, item, colour, item.stream.time, item.stream.signals["position"])
            if item.drive is not None:
                draw(drive, item, colour, item.stream.time, item.drive)
        draw_references(position, [item for item in evidence if item.has("reference")])
        position.set_ylabel(f"position [{si_unit('position', spec.axis)}]")
        drive.set(xlabel="time [s]", ylabel=f"{spec.drive} [{si_unit(spec.drive, spec.axis)}]")
        met = sum(one.met is True for one in verdict.requirements)
        position.set_title(
            f"{spec.name}: {verdict.state}, {met} of {len(verdict.requirements)} requirements met",
            loc="left",
            fontsize=9.0,
        )
    return figure
