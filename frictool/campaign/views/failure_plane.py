"""Plot of trials in the plane of two factors: points or, for many trials, shaded cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from numpy.typing import NDArray

from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, Trials
from frictool.campaign.views.figure_style import BAD, OPEN
from frictool.presentation.colours import MUTED
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_POINTS = 1500
CELLS = 24  # number of cells per side
STEPS = 16  # number of shades
SCALE = LinearSegmentedColormap.from_list("failing", ["#f2f4f7", "#f0c3a8", "#d9694a", "#8c1d18"])


def plane(axes: Axes, trials: Trials, first: int, second: int) -> str:
    """Draw the trials on the empty `axes`; return a text for the caption."""
    x, y = edges(trials, first), edges(trials, second)
    axes.set(xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    for axis, factor, bounds in ((axes.xaxis, first, x), (axes.yaxis, second, y)):
        if bounds.size <= CELLS // 2 + 1:
            axis.set_ticks(np.unique(trials.values[:, factor]))
    # if a factor has few values, points would hide one another
    few = trials.count <= MOST_POINTS and min(x.size, y.size) > CELLS
    return (
        _points(axes, trials, first, second) if few else _cells(axes, trials, first, second, x, y)
    )


def edges(trials: Trials, factor: int) -> Vector:
    """Return the edges of CELLS equal cells over the range of a factor (varied quantity).

    If the factor has at most CELLS / 2 different values, each value has one cell.
    """
    one = trials.space.factors[factor]
    levels = np.unique(trials.values[:, factor])
    if 1 < levels.size <= CELLS // 2:
        middles = 0.5 * (levels[:-1] + levels[1:])
        return np.concatenate(
            [[2.0 * levels[0] - middles[0]], middles, [2.0 * levels[-1] - middles[-1]]]
        )
    return np.linspace(one.low, one.high, CELLS + 1)


def _points(axes: Axes, trials: Trials, first: int, second: int) -> str:
    x, y = trials.values[:, first], trials.values[:, second]
    for mark, colour, size in ((MET, MUTED, 2.0), (UNDECIDED, OPEN, 2.6), (BROKEN, BAD, 3.4)):
        chosen = trials.passed == mark
        if chosen.any():
            _dots(axes, x[chosen], y[chosen], colour, size, 0.45 if mark == MET else 0.8)
    undecided = ", brown the undecided trials" if (trials.passed == UNDECIDED).any() else ""
    return f"Red: trials that fail, grey: trials that pass{undecided}."


def _dots(axes: Axes, x: Vector, y: Vector, colour: str, size: float, opacity: float) -> None:
    corners = np.repeat(np.stack([x, y], axis=1), 2, axis=0)
    codes = np.tile(np.array([Path.MOVETO, Path.LINETO], dtype=Path.code_type), x.size)
    path = Path(corners, codes)
    path.should_simplify = False  # simplification removes segments without length
    axes.add_patch(
        PathPatch(
            path, fill=False, edgecolor=colour, linewidth=size, capstyle="round", alpha=opacity
        )
    )


def _cells(axes: Axes, trials: Trials, first: int, second: int, x: Vector, y: Vector) -> str:
    decided = trials.passed != UNDECIDED
    u, v = trials.values[decided, first], trials.values[decided, second]
    everything = np.histogram2d(u, v, bins=(x, y))[0]
    failing = np.histogram2d(
        u, v, bins=(x, y), weights=(trials.passed[decided] == BROKEN).astype(float)
    )[0]
    share = np.divide(
        failing, everything, out=np.full_like(failing, np.nan), where=everything > 0.0
    )
    for step in range(STEPS + 1):  # one path per colour instead of one element per cell
        chosen = np.argwhere(np.rint(share * STEPS) == step)
        if chosen.size:
            axes.add_patch(
                PathPatch(
                    _boxes(x, y, chosen),
                    facecolor=SCALE(step / STEPS),
                    edgecolor=SCALE(step / STEPS),
                    linewidth=0.4,
                )
            )
    axes.grid(visible=False)
    return "Share of failing trials in each cell, from none (pale) to all (dark)."


def _boxes(x: Vector, y: Vector, cells: NDArray[np.int64]) -> Path:
    i, j = cells.T
    corners = np.stack([x[[i, i + 1, i + 1, i, i]], y[[j, j, j + 1, j + 1, j]]], axis=-1)
    codes = np.tile(
        np.array([Path.MOVETO, *[Path.LINETO] * 3, Path.CLOSEPOLY], dtype=Path.code_type), i.size
    )
    return Path(corners.transpose(1, 0, 2).reshape(-1, 2), codes)
