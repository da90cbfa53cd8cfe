"""The report as one HTML file: verdict, why, pictures, controller, provenance. No script, no request to anywhere."""

from __future__ import annotations

from importlib.resources import files

import jinja2
from markupsafe import Markup

from frictool.documents.controller import Controller
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.logs.log import Log
from frictool.report.curves import Picture, log_colours, overview
from frictool.report.evidence import labels
from frictool.report.margins import margins
from frictool.report.measure import Measured
from frictool.report.requirement import Verdict, number, unit_shown
from frictool.report.step_views import MOST_STEPS, step_views

HOLD_COLUMNS = {
    "response_time_95": "response 95 % [s]",
    "overshoot": "overshoot [%]",
    "static_error": "static error",
    "oscillations": "oscillations",
    "energy": "energy",
    "rest_motion": "motion at rest",
    "rest_drive": "drive at rest",
}


def page(verdict: Verdict, spec: Spec, logs: list[Log], controller: Controller | None, provenance: Provenance) -> str:
    """The HTML text; the same inputs give the same bytes. Every text from a file is escaped by the template."""
    template = files("frictool.report").joinpath("page.html.jinja").read_text(encoding="utf-8")
    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    evidence = [item for item, _ in verdict.evidence]
    pictures, steps = overview(spec, evidence), step_views(spec, verdict.evidence)
    bars = margins(spec, controller) if controller is not None else None
    shown = {name for _, holds in verdict.evidence for measured in holds for name in measured.values}
    return environment.from_string(template).render(
        verdict=verdict,
        number=number,
        unit_shown=unit_shown,
        unit=si_unit("position", spec.axis),
        drive_unit=si_unit(spec.drive, spec.axis),
        legend=[(name, colour, _variants(verdict, name)) for name, colour in log_colours(evidence).items()],
        pictures=[_embedded(picture) for picture in pictures],
        steps=[_embedded(picture) for picture in steps],
        most_steps=MOST_STEPS,
        columns={name: title for name, title in HOLD_COLUMNS.items() if name in shown},
        cell=_cell,
        controller=controller,
        bars=None if bars is None else _embedded(bars),
        provenance=provenance,
        logs=list(zip(labels(logs), logs, strict=True)),
    )


def _embedded(picture: Picture) -> dict[str, str]:
    """The picture for the template: the SVG is ours and goes in as it is, the texts are escaped like any other."""
    return {"title": picture.title, "svg": Markup(picture.svg), "caption": picture.caption}


def _variants(verdict: Verdict, name: str) -> int:
    return sum(item.source == name and not item.nominal for item, _ in verdict.evidence)


def _cell(measured: Measured, name: str) -> str:
    """A metric of a hold in the table: its value, `never` where infinite, a dash where it has none."""
    value = measured.values.get(name)
    return "–" if value is None else "never" if value == float("inf") else number(value)
