"""Figure of a log, with one panel for each signal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictool.presentation.colours import INK
from frictool.presentation.decimation import drawn_indices, finite_or_nan
from frictool.presentation.svg import drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from frictool.logs.log import Log

PANEL_WIDTH, PANEL_HEIGHT = 7.0, 1.6  # inches
MAIN, FURTHER = (1.0, 1.2, 3.0), (0.35, 0.7, 2.0)  # opacity, width, order of a stream's curves


def log_figure(log: Log) -> Figure:
    """Return a figure with one panel for each signal of the main stream, plotted against time.

    If another stream contains the same signal, that stream's curve is drawn faintly in the same
    panel.
    """
    from matplotlib.figure import Figure

    main = log.main
    names = list(main.signals)
    with drawing("log"):
        figure = Figure(figsize=(PANEL_WIDTH, PANEL_HEIGHT * len(names)), layout="constrained")
        panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
        for axes, name in zip(panels, names, strict=True):
            for stream in (*(one for one in log.axes if one is not main), main):
                if name not in stream.signals:
                    continue
                opacity, width, order = MAIN if stream is main else FURTHER
                values = finite_or_nan(stream.signals[name])
                kept = drawn_indices(stream.time, values)
                axes.plot(
                    stream.time[kept],
                    values[kept],
                    color="#1f5fa8",
                    alpha=opacity,
                    linewidth=width,
                    zorder=order,
                    label=stream.topic,
                )
            axes.set_ylabel(f"{name} [{main.units.get(name, '')}]", color=INK)
        panels[-1].set_xlabel("time [s]")
        panels[0].set_title(log.source, loc="left", fontsize=10.0, color=INK)
    return figure
