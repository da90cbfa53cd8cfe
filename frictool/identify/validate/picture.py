"""SVG plot of measured and simulated signals over time, and of the position error."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from frictool.documents.quantity import Axis, si_unit
from frictool.identify.validate.validation import Validation
from frictool.presentation.decimation import decimated_indices
from frictool.presentation.svg import drawing, render

WIDTH, HEIGHT = 7.0, 1.9  # inches, of each axes
MEASURED, SIMULATED, REFERENCE = "#444444", "#c0392b", "#1f5fa8"


def picture(validation: Validation, name: str) -> str:
    """Return the plot as an `<svg>` element; equal validations give identical bytes."""
    axis = validation.axis
    with drawing("validate"):
        figure = Figure(figsize=(WIDTH, HEIGHT * 4), layout="constrained")
        axes = figure.subplots(4, 1, sharex=True)
        if validation.reference is not None:
            shown = decimated_indices(validation.reference)
            axes[0].plot(
                validation.time[shown],
                validation.reference[shown],
                ":",
                linewidth=0.9,
                color=REFERENCE,
                label="reference",
            )
        effort = "effort" if "effort" in validation.measured else "force"
        for ax, signal in zip(axes, ("position", "velocity", effort), strict=False):
            for values, colour, label in (
                (validation.measured[signal], MEASURED, "measured"),
                (validation.simulated[signal], SIMULATED, "simulated"),
            ):
                shown = decimated_indices(np.nan_to_num(values))
                ax.plot(
                    validation.time[shown], values[shown], linewidth=0.9, color=colour, label=label
                )
            ax.set_ylabel(
                effort_label(axis) if signal == effort else f"{signal}\n{si_unit(signal, axis)}"
            )
        error = validation.measured["position"] - validation.simulated["position"]
        shown = decimated_indices(error)
        axes[3].plot(validation.time[shown], error[shown], linewidth=0.9, color=SIMULATED)
        axes[3].set_ylabel(f"position error\n{si_unit('position', axis)}")
        axes[0].legend(loc="upper right")
        axes[3].set_xlabel("time, s")
        return render(figure, f"{name}: measured and simulated over time, {validation.loop} loop")


def effort_label(axis: Axis) -> str:
    """Return the axis label of the effort, torque or force, with its unit."""
    return f"{'torque' if axis == 'rotary' else 'force'}\n{si_unit('effort', axis)}"
