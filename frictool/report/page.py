"""Report as a single HTML file that needs no other files."""

from __future__ import annotations

import json
from pathlib import Path

from frictool.documents.controller import Controller
from frictool.documents.metric_table import HOLD_METRICS, requirement_title
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import si_unit
from frictool.presentation.page import render_page
from frictool.presentation.sections import FigureView
from frictool.report.controller_blocks import block_descriptions
from frictool.report.curve_figures import log_colours, overview_figures
from frictool.report.evidence import log_labels
from frictool.report.margin_figure import margin_figure
from frictool.report.requirement import Verdict, number, unit_shown
from frictool.report.step_figures import MOST_STEPS, same_steps, step_key, step_views
from frictool.report.stream_selection import select_streams
from frictool.report.tables import hold_tables, side_by_side, stream_table
from frictool.report.transfer_figures import transfer_views
from frictool.report.worst_hold import JudgedStreams
from frictool.verify.loop_wording import plant_units
from frictool.verify.vertex_transfers import VertexTransfers

BEFORE_S = 0.2  # time shown before the start of the hold to which a requirement links
AFTER_S = 2.0  # time shown after the start of this hold


def page(
    verdict: Verdict, provenance: Provenance, transfers: VertexTransfers | str | None = None
) -> str:
    """Return the report as HTML text; the same inputs give the same bytes.

    `transfers`: transfer functions of the controller's vertices, or the reason why they are
    unknown.
    """
    spec, logs, controller = verdict.request.spec, verdict.request.logs, verdict.request.controller
    streams = select_streams(verdict)
    evidence = [item for item, _ in streams]
    bars = margin_figure(spec, controller) if controller is not None else None
    views = (
        transfer_views(controller, transfers)
        if controller is not None and isinstance(transfers, VertexTransfers)
        else []
    )
    measured_names = {
        name
        for _, holds in verdict.evidence
        for measured in holds
        for name in (*measured.values, *measured.bounds)
    }
    return render_page(
        Path(__file__).parent,
        provenance,
        verdict=verdict,
        shown=streams,
        number=number,
        unit_shown=unit_shown,
        requirement_title=requirement_title,
        unit=si_unit("position", spec.axis),
        drive_unit=si_unit(spec.drive, spec.axis),
        legend=[
            (name, colour, _variants(streams, name), _variants(verdict.evidence, name))
            for name, colour in log_colours(evidence).items()
        ],
        worst=next((item for item in evidence if item.worst), None),
        places=_places(verdict, streams),
        pictures=overview_figures(spec, evidence),
        steps=step_views(spec, streams),
        undrawn=max(0, len(same_steps(streams)) - MOST_STEPS),
        tables=hold_tables(spec, streams),
        streams=stream_table(spec, streams),
        comparison=side_by_side(spec, verdict),
        definitions=[metric for name, metric in HOLD_METRICS.items() if name in measured_names],
        controller=controller,
        plant_units=[] if controller is None else _plant_units(controller),
        blocks=[] if controller is None else block_descriptions(controller),
        transfers=[*([] if bars is None else [bars]), *views],
        without_transfers=transfers if isinstance(transfers, str) else "",
        logs=list(zip(log_labels(logs), logs, strict=True)),
    )


def _places(verdict: Verdict, streams: JudgedStreams) -> dict[str, tuple[str, str]]:
    places = {}
    for one in verdict.requirements:
        where = one.where
        if where is None or where.log is None:
            continue
        key = None if where.step is None else step_key(streams, where)
        span = None
        if key is None:
            key = "position"
            start = where.time_s
            span = None if start is None else (start - BEFORE_S, start + AFTER_S)
        view = FigureView(one.title, span)
        places[one.name] = (key, json.dumps(view.as_json()))
    return places


def _variants(streams: JudgedStreams, name: str) -> int:
    return sum(item.source == name and not item.nominal for item, _ in streams)


def _plant_units(controller: Controller) -> list[tuple[str, str]]:
    return [
        ("Coulomb" if name == "coulomb" else name, unit)
        for name, unit in plant_units(controller.bench).items()
    ]
