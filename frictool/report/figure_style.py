"""Common style of a report's figures: settings, margins and colours.

Texts in a figure are constants of the program. Names from files appear in the page's legend, which
escapes them.
"""

from __future__ import annotations

from frictool.presentation.plot import FigureMargins, Plot, PlotPanel

ZONE = "#cfe3d4"
LIMIT = "#b3261e"
# one colour per log, distinguishable with deficient colour vision and in grey
LOG_COLOURS = ("#1f5fa8", "#c4620a", "#2f7d4f", "#8a3d8f", "#5c6b00", "#8c2f39")
MARGINS = FigureMargins(left=0.8, right=0.12, bottom=0.5, top=0.18, label=0.12)
WIDTH, HEIGHT = 5.0, 2.7  # inches


def new_plot(*y_labels: str, height: float = HEIGHT, x_label: str = "") -> Plot:
    """Return an empty figure with one panel per ordinate label and a common abscissa.

    The first panel is the tallest.
    """
    panels = [PlotPanel(label, ratio=1.0 if index else 1.6) for index, label in enumerate(y_labels)]
    return Plot((WIDTH, height), MARGINS, panels, x_label=x_label)
