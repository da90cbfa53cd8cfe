"""Page and picture of an identified model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from frictool.documents.quantity import Quantity, si_unit
from frictool.identify.absolute_intervals import ParameterIntervals, parameter_intervals
from frictool.identify.fit_result import PARAMETERS
from frictool.identify.from_logs import IdentifiedModel
from frictool.identify.methods import METHODS, IdentificationRequest
from frictool.identify.model_page.evidence import held_out_positions, sliding_records, slip_samples
from frictool.identify.model_page.friction_panels import friction_panels
from frictool.identify.model_page.panel import FigurePanel, picture
from frictool.identify.model_page.residual_panels import (
    interval_panel,
    prediction_panel,
    residual_panels,
)
from frictool.identify.text_view import explanation_place, force_line, law_lines
from frictool.presentation.page import render_page
from frictool.presentation.sections import TextTable

WIDE = 0.1  # relative half width above which the page advises how to narrow an interval


def model_panels(outcome: IdentifiedModel, request: IdentificationRequest) -> list[FigurePanel]:
    """Return all panels for which the logs of an identification contain data."""
    model = outcome.model
    records = sliding_records(outcome)
    samples = slip_samples(model, records)
    panels = friction_panels(model, samples, outcome.result.ramp)
    if samples is not None:
        has_position = all(record.velocity is None for record in records)
        panels += residual_panels(samples, model.axis, has_position)
    held_out = held_out_positions(outcome, request)
    if held_out is not None:
        panels.append(prediction_panel(held_out, model.axis))
    return [*panels, interval_panel(parameter_intervals(model))]


def model_picture(outcome: IdentifiedModel, panels: Sequence[FigurePanel]) -> str:
    """Return the panels as one `<svg>` element."""
    return picture(panels, f"{outcome.model.name}: identified model")


def model_page(outcome: IdentifiedModel, panels: Sequence[FigurePanel]) -> str:
    """Return the HTML page of a model with `panels`."""
    model, result = outcome.model, outcome.result
    rows = parameter_intervals(model)
    identified = sum(row.identified for row in rows)
    why = None if result.fit is None else result.fit.why
    return render_page(
        Path(__file__).parent,
        model.provenance,
        name=model.name,
        banner=f"{identified} of {len(rows)} parameters identified; "
        + force_line(None if result.fit is None else result.fit.force_error),
        tone="met" if identified == len(rows) else "open",
        warnings=result.warnings,
        parameters=_parameter_table(rows, result.confidence),
        constant=_range(model.bench.actuator.constant),
        laws=[*result.notes, *law_lines(model)],
        explanations=_explanation_table(outcome),
        figures=[panel.figure() for panel in panels],
        method=f"{result.method}: {METHODS[result.method].what}",
        why=why or "",
        tried=_tried_table(outcome),
        next_steps=_next_steps(outcome, rows),
        logs=[(Path(name).name, kind) for name, kind in result.kinds.items()],
    )


def _range(quantity: Quantity) -> str:
    low, high = quantity.interval
    return f"{quantity.value:.5g} {quantity.unit} [{low:.5g}, {high:.5g}]"


def _parameter_table(rows: list[ParameterIntervals], confidence: float) -> TextTable:
    return TextTable(
        "Parameters",
        (
            "Parameter",
            "Source",
            "Value",
            "Unit",
            f"Interval at {100.0 * confidence:g} %",
            "Absolute interval",
            "Range of the bench",
        ),
        tuple(
            (
                row.name.replace("_", " "),
                row.estimate.source,
                f"{row.estimate.value:.5g}",
                row.estimate.unit,
                ("assumed: {:.5g} to {:.5g}" if row.assumed else "[{:.5g}, {:.5g}]").format(
                    *row.estimate.interval
                ),
                "–" if row.assumed else f"[{row.absolute.low:.5g}, {row.absolute.high:.5g}]",
                "–" if row.bench is None else "[{:.5g}, {:.5g}]".format(*row.bench.interval),
            )
            for row in rows
        ),
        names=2,
    )


def _explanation_table(outcome: IdentifiedModel) -> TextTable:
    fit = outcome.result.fit
    explanations = () if fit is None else fit.explanations
    return TextTable(
        "Other efforts",
        (
            "Possible cause",
            "Treatment",
            "Effort, rms",
            "Error on strokes left out of the fit, relative to the error without this cause",
            "Causes that predict equally well",
            "To decide",
        ),
        tuple(
            (
                one.what,
                explanation_place(one),
                f"{one.effort:.3g} {outcome.model.parameters.offset.unit}",
                f"{one.held_out:.2g}",
                ", ".join(one.rivals) or "–",
                one.settle,
            )
            for one in explanations
        ),
        names=6,
    )


def _tried_table(outcome: IdentifiedModel) -> TextTable:
    fit = outcome.result.fit
    unit = si_unit("position", outcome.model.axis)
    return TextTable(
        "What was tried",
        ("Model", "Result", f"Position error, rms [{unit}]", "Force error [%]"),
        tuple(
            (
                one.name,
                "chosen" if one.chosen else "",
                "leaves the measured range" if one.leaves_range else f"{one.position_error:.4g}",
                f"{100.0 * one.force_error:.3g}",
            )
            for one in (() if fit is None else fit.tried)
        ),
        names=2,
    )


def _next_steps(outcome: IdentifiedModel, rows: list[ParameterIntervals]) -> list[tuple[str, str]]:
    refused = outcome.result.refused
    names = [name for name in dict.fromkeys((*PARAMETERS, *refused)) if name in refused]
    steps = [(name.replace("_", " "), f"not identified: {refused[name]}") for name in names]
    steps += [
        (
            row.name.replace("_", " "),
            f"known to ±{100.0 * row.relative_half_width:.3g} %; logs that are four times as long "
            "halve the random error",
        )
        for row in rows
        if row.identified and row.name != "offset" and row.relative_half_width > WIDE
    ]
    return steps
