"""SVG figures of a comparison; identical inputs give identical bytes."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from frictool.compare.trajectory import LawTrajectory
from frictool.presentation.decimation import decimated_indices
from frictool.presentation.svg import PAGE, drawing, render
from frictool.typing import Vector

# colours that are distinguishable with deficient colour vision and in grey; line styles
COLOURS, DASHES = ("#1f5fa8", "#c4620a", "#2f7d4f"), ("-", (0, (5, 2)), (0, (1, 1.2)))
WIDTH, ROW_HEIGHT = 5.2, 1.5  # inches
STYLE: dict[str, Any] = {
    **PAGE,
    "font.size": 9.0,
    "axes.formatter.limits": (-3, 4),
    "lines.linewidth": 1.3,
    "legend.frameon": False,
}
# ordinate label, then (law, abscissa, ordinate) of each curve
Row = tuple[str, list[tuple[str, Vector, Vector]]]


def draw_rows(name: str, abscissa: str, rows: list[Row], thin: bool = True) -> str:
    """Return an `<svg>` element with a diagram for each row, and a common abscissa.

    `name`: description of the figure for screen readers.
    """
    with drawing(name, STYLE):
        figure = Figure(
            figsize=(WIDTH, 0.7 + ROW_HEIGHT * len(rows) + (1.0 if len(rows) == 1 else 0.0)),
            layout="constrained",
        )
        panels = figure.subplots(len(rows), 1, sharex=True, squeeze=False)[:, 0]
        for panel, (label, curves) in zip(panels, rows, strict=True):
            for k, (law, x, y) in enumerate(curves):
                shown = decimated_indices(y) if thin else slice(None)
                panel.plot(
                    x[shown], y[shown], color=COLOURS[k % 3], linestyle=DASHES[k % 3], label=law
                )
            panel.set_ylabel(label)
        if len(rows[0][1]) > 1:
            panels[0].legend(loc="best")
        panels[-1].set_xlabel(abscissa)
        return render(figure, name)


def over_time(
    runs: dict[str, LawTrajectory], units: tuple[str, str], window: slice = slice(None)
) -> list[Row]:
    """Return figure rows with position, velocity and friction of each law against time.

    - units: units of position and force
    - window: samples to show
    """
    length, force = units
    return [
        (
            f"x [{length}]",
            [(law, run.time[window], run.position[window]) for law, run in runs.items()],
        ),
        (
            f"v [{length}/s]",
            [(law, run.time[window], run.velocity[window]) for law, run in runs.items()],
        ),
        (
            f"F [{force}]",
            [(law, run.time[window], run.friction[window]) for law, run in runs.items()],
        ),
    ]
