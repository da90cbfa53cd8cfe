"""Figures of the whole log: position, velocity, drive and phase plane.

Streams of plant variants are drawn first, and the nominal stream on top of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.presentation.colours import INK
from frictool.presentation.decimation import (
    decimated_indices,
    decimated_path_indices,
    drawn_indices,
)
from frictool.presentation.plot import DASHED, PlotPanel
from frictool.presentation.sections import PageFigure
from frictool.report.evidence import StreamEvidence
from frictool.report.figure_style import LIMIT, LOG_COLOURS, new_plot
from frictool.report.plotted_velocity import used_velocity
from frictool.typing import Vector

DETAIL_COLUMNS = 1000  # columns of a decimated curve; fine enough for a reader who enlarges it


def log_colours(evidence: list[StreamEvidence]) -> dict[str, str]:
    """Return the colour of each log's curves, by the name of the log."""
    names = list(dict.fromkeys(item.source for item in evidence))
    return {name: LOG_COLOURS[k % len(LOG_COLOURS)] for k, name in enumerate(names)}


def draw(
    panel: PlotPanel,
    item: StreamEvidence,
    colour: str,
    abscissa: Vector,
    ordinate: Vector,
    *,
    over_time: bool = True,
) -> None:
    """Draw one signal of a stream as a curve.

    The curve is opaque for a nominal stream, transparent for a plant variant, and red for the
    stream with the worst value.

    - over_time: True if the abscissa is time
    """
    kept = (
        drawn_indices(abscissa, ordinate)
        if over_time
        else decimated_path_indices(abscissa, ordinate)
    )
    alpha, width, order = (1.0, 1.4, 3.0) if item.nominal else (0.35, 0.8, 2.0)
    if item.worst:
        colour, alpha, width, order = LIMIT, 1.0, 1.4, 3.5
    finer = decimated_indices(ordinate, columns=DETAIL_COLUMNS)
    panel.line(
        abscissa[kept],
        ordinate[kept],
        colour,
        alpha=alpha,
        width=width,
        order=order,
        label=item.plant,
        group="" if item.nominal or item.worst else f"{item.source}, variants",
        detail=(abscissa[finer], ordinate[finer]) if over_time else None,
    )


def nominal_last(evidence: list[StreamEvidence]) -> list[StreamEvidence]:
    """Return the streams in the order of drawing: variants, nominal streams, the worst stream."""
    return sorted(evidence, key=lambda item: item.drawing_order)


def draw_references(panel: PlotPanel, evidence: Sequence[StreamEvidence]) -> None:
    """Draw the references of all nominal streams or, without these, of one variant."""
    with_reference = [item for item in evidence if item.has("reference")]
    for item in [i for i in with_reference if i.nominal] or with_reference[:1]:
        reference = item.plotted("reference")
        kept = decimated_indices(reference)
        panel.line(
            item.stream.time[kept],
            reference[kept],
            INK,
            width=1.0,
            dash=DASHED,
            order=4.0,
            label="reference",
        )


def overview_figures(spec: Spec, evidence: list[StreamEvidence]) -> list[PageFigure]:
    """Return the figures of all available curves over the whole duration of the logs."""
    unit = si_unit("position", spec.axis)
    positions = [item for item in evidence if item.has("position")]
    pictures = []
    if positions:
        pictures.append(_position(positions, unit))
    smooth = [
        item
        for item in positions
        if item.has("reference") and not any(hold.origin is not None for hold in item.holds)
    ]
    if smooth:
        pictures.append(_error(smooth, unit))
    loaded = [item for item in evidence if item.has_backlash]
    if loaded:
        pictures.append(_load(loaded, unit))
    wrong = [item for item in positions if item.sensor_error is not None]
    if wrong:
        pictures.append(_sensor(wrong, unit))
    driven = [item for item in evidence if item.drive is not None]
    if driven:
        pictures.append(_drive(spec, driven))
    moving = [(item, shown) for item in positions if (shown := item.velocity) is not None]
    if moving:
        pictures += [_velocity(moving, unit), _phase_plane(moving, unit)]
    used = [
        (item, *speeds)
        for item in evidence
        if not isinstance(speeds := used_velocity(item.stream, item.simulated), str)
    ]
    if used:
        pictures.append(_used(used, unit))
    return pictures


def _over_time(
    name: str,
    ordinate: str,
    texts: tuple[str, str, str],
    curves: list[tuple[StreamEvidence, Vector]],
    references: Sequence[StreamEvidence] = (),
) -> PageFigure:
    title, label, caption = texts
    colours = log_colours([item for item, _ in curves])
    plot = new_plot(ordinate, x_label="time [s]")
    (panel,) = plot.panels
    for item, values in sorted(curves, key=lambda entry: entry[0].drawing_order):
        draw(panel, item, colours[item.source], item.stream.time, values)
    draw_references(panel, references)
    return PageFigure(title, plot.svg(label), caption, key=name.replace(" ", "-"))


def _origin(evidence: list[StreamEvidence]) -> str:
    if all(item.simulated for item in evidence):
        return "Simulated"
    return "Measured and simulated" if any(item.simulated for item in evidence) else "Measured"


def _position(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    caption = f"{_origin(evidence)} position; the reference is dashed."
    return _over_time(
        "position",
        f"position [{unit}]",
        ("Position", "position over time", caption),
        [(item, item.plotted("position")) for item in evidence],
        evidence,
    )


def draw_load(
    panel: PlotPanel, item: StreamEvidence, colour: str, time: Vector, part: slice
) -> None:
    """Draw the load's position behind the backlash: a curve, or the area between its bounds.

    `part`: slice of the samples that are drawn.
    """
    assert item.load is not None
    low, high = (load[part] for load in item.load)
    if not item.load_is_bounded:
        draw(panel, item, colour, time[part], low)
        return
    kept = np.union1d(drawn_indices(time[part], low), drawn_indices(time[part], high))
    along = time[part][kept]
    panel.area(
        np.concatenate((along, along[::-1])),
        np.concatenate((low[kept], high[kept][::-1])),
        colour,
        alpha=0.35 if item.nominal else 0.15,
        order=1.0,
    )


def _load(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    colours = log_colours(evidence)
    plot = new_plot(f"load [{unit}]", x_label="time [s]")
    (panel,) = plot.panels
    for item in nominal_last(evidence):
        draw_load(panel, item, colours[item.source], item.stream.time, slice(None))
    draw_references(panel, evidence)
    known = (
        "If only the motor's position was measured, the figure shows the bounds of the load's "
        "position."
    )
    bounded = any(item.load_is_bounded for item in evidence)
    return PageFigure(
        "Mechanical position",
        plot.svg("load over time"),
        f"Behind the backlash. {known if bounded else ''}".rstrip(),
    )


def _sensor(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    caption = (
        "Position of the sensor minus the true position. All other figures and the requirements "
        "use the sensor's position."
    )
    return _over_time(
        "sensor",
        f"error [{unit}]",
        ("Sensor error", "sensor error over time", caption),
        [(item, item.sensor_error) for item in evidence if item.sensor_error is not None],
    )


def _error(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    caption = "Reference minus position, of the logs without a step."
    return _over_time(
        "error",
        f"error [{unit}]",
        ("Tracking error", "error over time", caption),
        [(item, item.plotted("reference") - item.plotted("position")) for item in evidence],
    )


def _drive(spec: Spec, evidence: list[StreamEvidence]) -> PageFigure:
    measured = all(item.measured is not None for item in evidence)
    caption = f"{_origin(evidence) if measured else 'Commanded'} {spec.drive}."
    return _over_time(
        "drive",
        f"{spec.drive} [{si_unit(spec.drive, spec.axis)}]",
        (spec.drive.capitalize(), f"{spec.drive} over time", caption),
        [(item, item.drive) for item in evidence if item.drive is not None],
    )


def _velocity(moving: list[tuple[StreamEvidence, tuple[Vector, str]]], unit: str) -> PageFigure:
    return _over_time(
        "velocity",
        f"velocity [{unit}/s]",
        ("Velocity", "velocity over time", _velocity_source(moving)),
        [(item, velocity) for item, (velocity, _) in moving],
    )


def _used(used: list[tuple[StreamEvidence, Vector, Vector]], unit: str) -> PageFigure:
    caption = "Speed estimate of the controller, minus the true speed of the simulation."
    label = "error of the controller's speed estimate"
    return _over_time(
        "speed used",
        f"error [{unit}/s]",
        ("Error of the speed estimate", label, caption),
        [(item, estimated - velocity) for item, estimated, velocity in used],
    )


def _velocity_source(moving: list[tuple[StreamEvidence, tuple[Vector, str]]]) -> str:
    sources = list(dict.fromkeys(source for _, (_, source) in moving))
    return "; ".join(sources).capitalize() + "."


def _phase_plane(moving: list[tuple[StreamEvidence, tuple[Vector, str]]], unit: str) -> PageFigure:
    colours = log_colours([item for item, _ in moving])
    plot = new_plot(f"velocity [{unit}/s]", x_label=f"position [{unit}]")
    (panel,) = plot.panels
    for item, (velocity, _) in sorted(moving, key=lambda entry: entry[0].drawing_order):
        position = item.plotted("position")
        draw(panel, item, colours[item.source], position, velocity, over_time=False)
    caption = (
        f"{_velocity_source(moving)} An orbit that closes while the reference is held "
        "is a limit cycle."
    )
    return PageFigure("Phase plane", plot.svg("velocity over position"), caption)
