"""SVG plot of a test over time, with one panel per column."""

from __future__ import annotations

from matplotlib.figure import Figure

from frictool.identify.excite.excitation_sequence import ExcitationSequence
from frictool.presentation.decimation import decimated_indices
from frictool.presentation.svg import drawing, render

WIDTH, HEIGHT = 7.0, 1.8  # size of each panel, inches


def picture(sequence: ExcitationSequence) -> str:
    """Return the plot as an `<svg>` element."""
    with drawing(sequence.kind):
        figure = Figure(figsize=(WIDTH, HEIGHT * len(sequence.columns)), layout="constrained")
        axes = figure.subplots(len(sequence.columns), 1, sharex=True, squeeze=False)[:, 0]
        for ax, (name, values) in zip(axes, sequence.columns.items(), strict=True):
            shown = decimated_indices(values)
            ax.plot(sequence.time[shown], values[shown], linewidth=0.9, color="#1f5fa8")
            unit = sequence.units[name]
            ax.set_ylabel(name.replace("_", "\n") + (f"\n{unit}" if unit != "1" else ""))
        axes[-1].set_xlabel("time, s")
        return render(figure, f"{sequence.kind} test over time")
