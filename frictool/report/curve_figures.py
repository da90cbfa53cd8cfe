"""Curves over the whole log: position, velocity, drive and phase plane.

Variants are overlaid, with the nominal stream on top.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.presentation.decimation import decimated_indices, decimated_path_indices
from frictool.presentation.svg import INK, render_compact
from frictool.report.evidence import StreamEvidence
from frictool.report.figure_style import LOG_COLOURS, drawing, new_figure
from frictool.report.plotted_velocity import used_velocity
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class PageFigure:
    """Figure of the page: SVG text, title and caption."""

    title: str
    svg: str
    caption: str


def log_colours(evidence: list[StreamEvidence]) -> dict[str, str]:
    """Return the colour of each log by its name."""
    names = list(dict.fromkeys(item.source for item in evidence))
    return {name: LOG_COLOURS[k % len(LOG_COLOURS)] for k, name in enumerate(names)}


def draw(
    axes: Axes,
    item: StreamEvidence,
    colour: str,
    abscissa: Vector,
    ordinate: Vector,
    *,
    over_time: bool = True,
) -> None:
    """Draw one curve, strong for a nominal stream and faint for a variant.

    `over_time`: the abscissa is time, which allows a simpler decimation.
    """
    kept = decimated_indices(ordinate) if over_time else decimated_path_indices(abscissa, ordinate)
    alpha, width, order = (1.0, 1.4, 3.0) if item.nominal else (0.35, 0.8, 2.0)
    axes.plot(
        abscissa[kept], ordinate[kept], color=colour, alpha=alpha, linewidth=width, zorder=order
    )


def nominal_last(evidence: list[StreamEvidence]) -> list[StreamEvidence]:
    """Return the streams with the nominal ones last, so that they are drawn on top."""
    return sorted(evidence, key=lambda item: item.nominal)


def draw_references(axes: Axes, evidence: list[StreamEvidence]) -> None:
    """Draw the reference of each nominal stream, or else of the first one with a reference."""
    with_reference = [item for item in evidence if item.has("reference")]
    for item in [i for i in with_reference if i.nominal] or with_reference[:1]:
        reference = item.plotted("reference")
        kept = decimated_indices(reference)
        axes.plot(
            item.stream.time[kept],
            reference[kept],
            color=INK,
            linewidth=1.0,
            linestyle=(0, (4, 2)),
            zorder=4.0,
        )


def overview_figures(spec: Spec, evidence: list[StreamEvidence]) -> list[PageFigure]:
    """Return the figures of all available curves over the whole length of the logs."""
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


def _position(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    colours = log_colours(evidence)
    with drawing("position"):
        figure, (axes,) = new_figure()
        for item in nominal_last(evidence):
            draw(axes, item, colours[item.source], item.stream.time, item.plotted("position"))
        draw_references(axes, evidence)
        axes.set(xlabel="time [s]", ylabel=f"position [{unit}]")
        return PageFigure(
            "Position",
            render_compact(figure, "position over time"),
            "Measured position; the reference is dashed.",
        )


def draw_load(axes: Axes, item: StreamEvidence, colour: str, time: Vector, part: slice) -> None:
    """Draw the mechanical position behind the backlash: a curve, or the area between its bounds."""
    assert item.load is not None
    low, high = (load[part] for load in item.load)
    if not item.load_is_bounded:
        draw(axes, item, colour, time[part], low)
        return
    kept = decimated_indices(low, high)
    axes.fill_between(
        time[part][kept],
        low[kept],
        high[kept],
        color=colour,
        alpha=0.35 if item.nominal else 0.15,
        linewidth=0.6,
    )


def _load(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    colours = log_colours(evidence)
    with drawing("load"):
        figure, (axes,) = new_figure()
        for item in nominal_last(evidence):
            draw_load(axes, item, colours[item.source], item.stream.time, slice(None))
        draw_references(axes, evidence)
        axes.set(xlabel="time [s]", ylabel=f"load [{unit}]")
        bounded = any(item.load_is_bounded for item in evidence)
        told = (
            (
                "Where only the motor's position was measured: between the bounds that it "
                "and the backlash leave."
            )
            if bounded
            else ""
        )
        return PageFigure(
            "Mechanical position",
            render_compact(figure, "load over time"),
            f"Behind the backlash. {told}".rstrip(),
        )


def _sensor(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    colours = log_colours(evidence)
    with drawing("sensor"):
        figure, (axes,) = new_figure()
        for item in nominal_last(evidence):
            error = item.sensor_error
            assert error is not None
            draw(axes, item, colours[item.source], item.stream.time, error)
        axes.set(xlabel="time [s]", ylabel=f"error [{unit}]")
        caption = (
            "What the position sensor shows less the true position. Everything else is "
            "judged by what it shows."
        )
        return PageFigure("Sensor error", render_compact(figure, "sensor error over time"), caption)


def _error(evidence: list[StreamEvidence], unit: str) -> PageFigure:
    colours = log_colours(evidence)
    with drawing("error"):
        figure, (axes,) = new_figure()
        for item in nominal_last(evidence):
            draw(
                axes,
                item,
                colours[item.source],
                item.stream.time,
                item.plotted("reference") - item.plotted("position"),
            )
        axes.set(xlabel="time [s]", ylabel=f"error [{unit}]")
        return PageFigure(
            "Tracking error",
            render_compact(figure, "error over time"),
            "Reference less position, of the logs without a step.",
        )


def _drive(spec: Spec, evidence: list[StreamEvidence]) -> PageFigure:
    colours = log_colours(evidence)
    with drawing("drive"):
        figure, (axes,) = new_figure()
        for item in nominal_last(evidence):
            assert item.drive is not None
            draw(axes, item, colours[item.source], item.stream.time, item.drive)
        axes.set(xlabel="time [s]", ylabel=f"{spec.drive} [{si_unit(spec.drive, spec.axis)}]")
        source = (
            f"Measured {spec.drive}."
            if all(item.measured is not None for item in evidence)
            else f"Commanded {spec.drive}."
        )
        return PageFigure(
            spec.drive.capitalize(), render_compact(figure, f"{spec.drive} over time"), source
        )


def _velocity(moving: list[tuple[StreamEvidence, tuple[Vector, str]]], unit: str) -> PageFigure:
    colours = log_colours([item for item, _ in moving])
    with drawing("velocity"):
        figure, (axes,) = new_figure()
        for item, (velocity, _) in sorted(moving, key=lambda entry: entry[0].nominal):
            draw(axes, item, colours[item.source], item.stream.time, velocity)
        axes.set(xlabel="time [s]", ylabel=f"velocity [{unit}/s]")
        return PageFigure(
            "Velocity", render_compact(figure, "velocity over time"), _velocity_source(moving)
        )


def _used(used: list[tuple[StreamEvidence, Vector, Vector]], unit: str) -> PageFigure:
    colours = log_colours([item for item, _, _ in used])
    with drawing("speed used"):
        figure, (axes,) = new_figure()
        for item, estimated, velocity in sorted(used, key=lambda entry: entry[0].nominal):
            draw(axes, item, colours[item.source], item.stream.time, estimated - velocity)
        axes.set(xlabel="time [s]", ylabel=f"error [{unit}/s]")
        caption = (
            "What the controller took for the speed, less the true one that the simulation knows."
        )
        return PageFigure(
            "Error of the speed used",
            render_compact(figure, "error of the speed that the controller used"),
            caption,
        )


def _velocity_source(moving: list[tuple[StreamEvidence, tuple[Vector, str]]]) -> str:
    sources = list(dict.fromkeys(source for _, (_, source) in moving))
    return "; ".join(sources).capitalize() + "."


def _phase_plane(moving: list[tuple[StreamEvidence, tuple[Vector, str]]], unit: str) -> PageFigure:
    colours = log_colours([item for item, _ in moving])
    with drawing("phase plane"):
        figure, (axes,) = new_figure()
        for item, (velocity, _) in sorted(moving, key=lambda entry: entry[0].nominal):
            draw(
                axes,
                item,
                colours[item.source],
                item.plotted("position"),
                velocity,
                over_time=False,
            )
        axes.set(xlabel=f"position [{unit}]", ylabel=f"velocity [{unit}/s]")
        caption = (
            f"{_velocity_source(moving)} An orbit that closes while the reference is held "
            "is a limit cycle."
        )
        return PageFigure("Phase plane", render_compact(figure, "velocity over position"), caption)
