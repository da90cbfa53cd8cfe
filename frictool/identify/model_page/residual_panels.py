"""Panels of the residual, of the intervals compared with bench.yaml, and of predicted strokes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from frictool.documents.quantity import Axis, si_unit
from frictool.identify.absolute_intervals import ParameterIntervals
from frictool.identify.model_page.evidence import (
    HeldOutPositions,
    SlipSamples,
    mean_over_position,
    position_spectrum,
)
from frictool.identify.model_page.friction_panels import MARGIN, SIDES
from frictool.identify.model_page.panel import FORWARD, MEASURED, SIMULATED, FigurePanel, scatter
from frictool.presentation.colours import MUTED
from frictool.presentation.decimation import decimated_indices

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROW = 0.28  # half of a bar's height, relative to the distance between two rows


def residual_panels(samples: SlipSamples, axis: Axis, has_position: bool) -> list[FigurePanel]:
    """Return panels of the residual: over position, over time, and its spectrum over position.

    `has_position` is False for logs of the velocity, whose absolute position is unknown.
    """
    over_time = _residual_over_time(samples, axis)
    if not has_position:
        return [over_time]
    spectrum = position_spectrum(samples)
    panels = [_residual_over_position(samples, axis), over_time]
    return panels if spectrum is None else [*panels, _spectrum(*spectrum, axis)]


def _residual_over_position(samples: SlipSamples, axis: Axis) -> FigurePanel:
    def draw(axes: Axes) -> None:
        for side, colour, name, style in SIDES:
            chosen = np.sign(samples.velocity) == side
            scatter(
                axes,
                samples.position[chosen],
                samples.residual[chosen],
                colour,
                f"samples {name}",
            )
            centre, mean = mean_over_position(samples, side)
            axes.plot(centre, mean, color=colour, linestyle=style, label=f"mean {name}")
        _zero_line(axes)
        axes.set(
            xlabel=f"position [{si_unit('position', axis)}]",
            ylabel=f"residual [{si_unit('effort', axis)}]",
        )

    return FigurePanel(
        "Residual over position",
        "Measured effort minus the effort of the model, and its mean at each position. A load or "
        "a cogging torque leaves the same residual in both directions of motion; the residual of "
        "friction changes its sign with the direction.",
        draw,
    )


def _residual_over_time(samples: SlipSamples, axis: Axis) -> FigurePanel:
    def draw(axes: Axes) -> None:
        for side, colour, name, _ in SIDES:
            chosen = np.sign(samples.velocity) == side
            scatter(axes, samples.time[chosen], samples.residual[chosen], colour, f"samples {name}")
        _zero_line(axes)
        axes.set(xlabel="time [s]", ylabel=f"residual [{si_unit('effort', axis)}]")

    return FigurePanel(
        "Residual over time",
        "Measured effort minus the effort of the model; several logs follow each other. A slope "
        "is a drift of the offset or of the friction.",
        draw,
    )


def _zero_line(axes: Axes) -> None:
    axes.margins(MARGIN)
    axes.axhline(0.0, color=MUTED, linewidth=0.8, zorder=1.0)


def _spectrum(numbers: np.ndarray, amplitudes: np.ndarray, axis: Axis) -> FigurePanel:
    cycles = 2.0 * np.pi * numbers if axis == "rotary" else numbers
    unit = "cycles per turn" if axis == "rotary" else "cycles per m"
    largest = int(np.argmax(amplitudes))

    def draw(axes: Axes) -> None:
        axes.plot(cycles, amplitudes, color=FORWARD, label="amplitude")
        axes.margins(MARGIN)
        axes.set(xlabel=f"wave number [{unit}]", ylabel=f"amplitude [{si_unit('effort', axis)}]")

    return FigurePanel(
        "Spectrum of the residual",
        f"Amplitude of the mean residual over position; the largest is {amplitudes[largest]:.3g} "
        f"{si_unit('effort', axis)} at {cycles[largest]:.4g} {unit}.",
        draw,
    )


def interval_panel(rows: Sequence[ParameterIntervals]) -> FigurePanel:
    """Return a panel of the intervals as deviations from the values in bench.yaml, in per cent.

    If a value in bench.yaml is 0, the deviation is relative to the Coulomb friction in bench.yaml.
    """
    coulomb = next((row.bench for row in rows if row.name == "coulomb"), None)
    scaled = []
    for row in rows:
        if row.bench is None:
            continue
        scale = abs(row.bench.value) or (coulomb.value if coulomb is not None else 0.0)
        if scale > 0.0:
            scaled.append((row, row.bench, scale))
    scaled.reverse()

    def draw(axes: Axes) -> None:
        for place, (row, bench, scale) in enumerate(scaled):
            ends = [100.0 * (end - bench.value) / scale for end in bench.interval]
            axes.barh(place, ends[1] - ends[0], 2.0 * ROW, ends[0], color=MUTED, alpha=0.3)
            if not row.from_logs:
                continue
            own = [100.0 * (end - bench.value) / scale for end in row.estimate.interval]
            whole = [
                100.0 * (end - bench.value) / scale for end in (row.absolute.low, row.absolute.high)
            ]
            axes.plot(whole, [place] * 2, color=FORWARD, linewidth=1.0)
            axes.plot(own, [place] * 2, color=FORWARD, linewidth=4.0, solid_capstyle="butt")
            axes.plot(
                100.0 * (row.estimate.value - bench.value) / scale,
                place,
                "|",
                color=SIMULATED,
                markersize=9,
            )
        axes.axvline(0.0, color=MUTED, linewidth=0.8, zorder=1.0)
        axes.set_yticks(range(len(scaled)), [row.name.replace("_", " ") for row, _, _ in scaled])
        axes.set(xlabel="deviation from the bench's value [%]", ylim=(-0.6, len(scaled) - 0.4))
        axes.margins(x=MARGIN)

    return FigurePanel(
        "Intervals and the bench's ranges",
        "Grey: range of the bench. Wide line: interval for the nominal drive constant. Thin line: "
        "absolute interval, with the error of the constant. Red: estimate. If the bench's value is "
        "0, the deviation is relative to the bench's Coulomb friction.",
        draw,
    )


def prediction_panel(held_out: HeldOutPositions, axis: Axis) -> FigurePanel:
    """Return a panel of measured and simulated position over time, with the fit in per cent."""
    how = (
        "Each half of the logs is simulated by a model that was identified from the other half"
        if held_out.held_out
        else "The logs are too short for halves: the model simulates the logs of its own fit"
    )

    def draw(axes: Axes) -> None:
        begin = 0.0
        for number, one in enumerate(held_out.segments):
            several = len({segment.log for segment in held_out.segments}) > 1
            time = one.time - one.time[0] + begin if several else one.time
            for values, colour, name, style in (
                (one.measured, MEASURED, "measured", "-"),
                (one.simulated, SIMULATED, "simulated", (0, (4, 2))),
            ):
                kept = decimated_indices(values)
                axes.plot(
                    time[kept],
                    values[kept],
                    color=colour,
                    linestyle=style,
                    label=f"_{name}" if number else name,
                )
            begin = float(time[-1])
        axes.margins(MARGIN)
        axes.set(xlabel="time [s]", ylabel=f"position [{si_unit('position', axis)}]")

    logs = ", ".join(dict.fromkeys(Path(one.log).name for one in held_out.segments))
    title = "Strokes left out of the fit" if held_out.held_out else "Strokes of the fit"
    return FigurePanel(
        f"{title}: fit {held_out.fit:.4g} %",
        f"{how}, driven by the measured effort alone ({logs}). The fit is 100 % minus the norm "
        "of the error in per cent of the norm of the measured position about its mean.",
        draw,
    )
