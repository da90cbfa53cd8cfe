"""Figures of a validation: signals over time, and the residual effort over velocity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from frictool.documents.quantity import Axis, si_unit
from frictool.identify.model_page import panel
from frictool.identify.model_page.friction_panels import MARGIN, SIDES
from frictool.identify.model_page.panel import MEASURED, SIMULATED, FigurePanel, scatter
from frictool.identify.validate.validation import OPEN, Validation
from frictool.presentation.chart_data import with_detail
from frictool.presentation.colours import MUTED
from frictool.presentation.decimation import decimated_indices
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DETAIL_COLUMNS = 4000  # number of columns to which samples are decimated for a zoomed figure
REFERENCE = "#1f5fa8"
DASHES = (0, (4, 2))


def validation_panels(validation: Validation) -> list[FigurePanel]:
    """Return the panels of a validation; only a closed loop has a panel of the effort."""
    panels = [_signal(validation, "position"), _position_error(validation)]
    panels += [
        _signal(validation, name) for name in ("velocity", "effort") if _has(validation, name)
    ]
    if np.isfinite(validation.measured["force"]).any():
        panels.append(_missing_effort(validation))
    return panels


def picture(validation: Validation, panels: Sequence[FigurePanel], name: str) -> str:
    """Return the panels as one `<svg>` element."""
    return panel.picture(panels, f"{name}: measured and simulated, {validation.loop} loop")


def effort_label(axis: Axis) -> str:
    """Return the axis label of the effort, torque or force, with its unit."""
    return f"{'torque' if axis == 'rotary' else 'force'} [{si_unit('effort', axis)}]"


def _has(validation: Validation, name: str) -> bool:
    return name in validation.measured


def _signal(validation: Validation, name: str) -> FigurePanel:
    axis = validation.axis
    reference = validation.reference if name == "position" else None

    def draw(axes: Axes) -> None:
        if reference is not None:
            _curve(axes, validation.time, reference, REFERENCE, "reference", ":")
        _curve(axes, validation.time, validation.measured[name], MEASURED, "measured", "-")
        _curve(axes, validation.time, validation.simulated[name], SIMULATED, "simulated", DASHES)
        label = effort_label(axis) if name == "effort" else f"{name} [{si_unit(name, axis)}]"
        _finish(axes, label)

    captions = {
        "position": "The simulation starts from the measured position. "
        + (
            "The measured effort drives the model, without feedback."
            if validation.loop == OPEN
            else "The bench's controller drives the model along the measured reference."
        ),
        "velocity": "Velocity of the position after the low-pass filter.",
        "effort": "Effort of the bench's controller.",
    }
    return FigurePanel(name.capitalize(), captions[name], draw)


def _position_error(validation: Validation) -> FigurePanel:
    unit = si_unit("position", validation.axis)
    error = validation.measured["position"] - validation.simulated["position"]
    worst = validation.time[int(np.argmax(np.abs(error)))]

    def draw(axes: Axes) -> None:
        _curve(axes, validation.time, error, SIMULATED, "position error", "-")
        axes.axhline(0.0, color=MUTED, linewidth=0.8, zorder=1.0)
        _finish(axes, f"position error [{unit}]")

    return FigurePanel(
        "Position error",
        f"Measured minus simulated position: {validation.position_rmse:.4g} {unit} rms, at most "
        f"{validation.largest:.4g} {unit}, at {worst:.4g} s.",
        draw,
    )


def _missing_effort(validation: Validation) -> FigurePanel:
    velocity = validation.measured["velocity"]
    lacking = validation.measured["force"] - validation.simulated["force"]
    unit = si_unit("velocity", validation.axis)

    def draw(axes: Axes) -> None:
        for side, colour, name, _ in SIDES:
            chosen = np.isfinite(lacking) & (np.sign(velocity) == side)
            scatter(axes, velocity[chosen], lacking[chosen], colour, f"samples {name}")
        axes.axhline(0.0, color=MUTED, linewidth=0.8, zorder=1.0)
        axes.margins(MARGIN)
        axes.set(xlabel=f"velocity [{unit}]", ylabel=effort_label(validation.axis))

    return FigurePanel(
        "Effort that the model lacks",
        "Measured effort minus the effort of the model for the measured motion, at samples that "
        "certainly slip. A true model leaves the same scatter around 0 at every velocity.",
        draw,
    )


def _curve(axes: Axes, time: Vector, values: Vector, colour: str, label: str, style: Any) -> None:
    kept = decimated_indices(values)
    (line,) = axes.plot(time[kept], values[kept], color=colour, linestyle=style, label=label)
    finer = decimated_indices(values, columns=DETAIL_COLUMNS)
    with_detail(line, time[finer], values[finer])


def _finish(axes: Axes, label: str) -> None:
    axes.margins(MARGIN)
    axes.set(xlabel="time [s]", ylabel=label)
