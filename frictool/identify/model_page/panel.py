"""Panel of a model's figures, drawn alone or as one of several panels in a picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from matplotlib.figure import Figure

from frictool.presentation.colours import INK
from frictool.presentation.sections import PageFigure
from frictool.presentation.svg import PAGE, drawing, render, render_compact
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORWARD, BACKWARD, MEASURED = "#1f5fa8", "#c4620a", "#4a4a4a"
SIMULATED = "#b3261e"
WIDTH, HEIGHT = 5.0, 2.9  # size of a figure on the page, inches
PICTURE_WIDTH = 7.0  # inches
DOTS_PER_INCH = 200  # resolution of the samples, which are drawn as an image
STYLE: dict[str, Any] = {**PAGE, "lines.linewidth": 1.3, "legend.fontsize": 7.5}


@dataclass(frozen=True)
class FigurePanel:
    """Title and caption of a panel, and the function that draws it into axes."""

    title: str
    caption: str
    draw: Callable[[Axes], None]

    def figure(self) -> PageFigure:
        """Return the panel as a figure of a page."""
        with drawing(self.title, STYLE):
            figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained", dpi=DOTS_PER_INCH)
            axes = figure.subplots()
            self.draw(axes)
            _legend(axes)
            text = render_compact(figure, self.title)
        return PageFigure(self.title, text, self.caption)


def picture(panels: Sequence[FigurePanel], label: str) -> str:
    """Return one `<svg>` element with all panels and their titles, one below the other."""
    with drawing("identify", STYLE):
        return render(panel_figure(panels), label)


def panel_figure(panels: Sequence[FigurePanel]) -> Figure:
    """Return a figure with all panels and their titles, one below the other."""
    with drawing("identify", STYLE):
        figure = Figure(
            figsize=(PICTURE_WIDTH, HEIGHT * len(panels)), layout="constrained", dpi=DOTS_PER_INCH
        )
        every = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
        for axes, panel in zip(every, panels, strict=True):
            panel.draw(axes)
            axes.set_title(panel.title, loc="left", fontsize=10.0, color=INK)
            _legend(axes, "right")  # the title is on the left
        return figure


def scatter(axes: Axes, abscissa: Vector, ordinate: Vector, colour: str, label: str) -> None:
    """Draw samples (n,) as faint dots, in a raster image."""
    axes.plot(
        abscissa,
        ordinate,
        linestyle="",
        marker=".",
        markersize=2.0,
        markeredgewidth=0.0,
        alpha=0.35,
        color=colour,
        label=label,
        rasterized=True,
        zorder=2.0,
    )


def _legend(axes: Axes, side: Literal["left", "right"] = "left") -> None:
    handles, labels = axes.get_legend_handles_labels()
    if len(labels) > 1:
        axes.legend(
            handles,
            labels,
            loc="lower right" if side == "right" else "lower left",
            bbox_to_anchor=(1.0 if side == "right" else 0.0, 1.0),
            ncols=2,
            columnspacing=1.0,
            handlelength=1.4,
            frameon=False,
            borderaxespad=0.1,
            markerscale=2.0,
        )
