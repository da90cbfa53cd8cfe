"""Text view of a comparison: three tables and, on request, the differences from the thesis."""

from __future__ import annotations

import numpy as np

from frictool.compare.comparison import REFERENCE, Comparison, LawResult
from frictool.compare.thesis_tables import PROPERTIES, TESTS
from frictool.documents.quantity import si_unit
from frictool.presentation.sections import TextTable

ROWS = {
    "dynamic": "static/dynamic",
    "stiction": "stiction",
    "rising_static_friction": "rising static friction",
    "frictional_memory": "frictional memory",
    "presliding": "presliding",
    "stribeck_effect": "Stribeck effect",
    "viscous": "viscous friction",
    "nonlocal_memory": "non-local memory",
    "non_drift": "non-drift",
    "parameters": "parameters",
    "stick_slip": "stick-slip",
    "limit_cycle": "limit cycle",
    "drift": "non-drift",
}
MEASURES = (  # explanations of the columns of the first table
    "sticks: phases at rest in the stick-slip test; period: mean time from one stick to the next; "
    "jump: mean distance",
    "stuck: share of the time below the Stribeck velocity",
    "cycle: amplitude and period of the limit cycle in a position loop with integral action",
    "closure: gap of the inner presliding loop relative to the breakaway",
    "area: area of the last loop relative to breakaway times presliding length",
    "rigid: no presliding",
    "drift: displacement under a force below the Coulomb friction, in presliding lengths",
)
VERDICTS = (
    "+: the law passes the test; -: it fails; ±: it has presliding without closed loops or "
    "without hysteresis",
)
KINDS = (
    "S, D: static law, law with a state; +: the law has the property; -: it does not; ±: in part",
)


def number(value: float | None, digits: int = 4) -> str:
    """Return a number as text, or a dash for None."""
    return "–" if value is None else f"{value:.{digits}g}"


def tables(comparison: Comparison) -> list[TextTable]:
    """Return the table of measures, and tables 3.2 and 2.1 of the thesis; one row per law."""
    unit = si_unit("position", comparison.setting.axis)
    measures = (
        "law",
        "sticks",
        "period s",
        f"jump {unit}",
        "stuck",
        f"cycle {unit}",
        "period s",
        "closure",
        "area",
        "drift z_max",
    )
    tests = (*TESTS, "parameters")
    laws = comparison.laws.items()
    return [
        TextTable(
            "Results of the simulated tests",
            measures,
            tuple((name, *_row(tested)) for name, tested in laws),
            notes=MEASURES,
        ),
        TextTable(
            "The four tests",
            ("law", *(ROWS[row] for row in tests)),
            tuple((name, *(tested.verdicts[row] for row in tests)) for name, tested in laws),
            notes=VERDICTS,
        ),
        TextTable(
            "Properties of the laws",
            ("law", *(ROWS[row] for row in PROPERTIES)),
            tuple((name, *(tested.properties[row] for row in PROPERTIES)) for name, tested in laws),
            notes=KINDS,
        ),
    ]


def _row(result: LawResult) -> tuple[str, ...]:
    pulled, cycle, contact = result.stick_slip, result.limit_cycle, result.presliding
    lasts = cycle.period_s is not None
    return (
        str(pulled.sticks),
        number(pulled.period_s, 5),
        number(pulled.jump),
        number(pulled.stuck_share, 3),
        number(cycle.amplitude, 3) if lasts else "dies out",
        number(cycle.period_s),
        "rigid" if not contact.compliance else f"{contact.closure:.3f}",
        "rigid" if not contact.compliance else f"{contact.area:.3f}",
        f"{result.drift.z_max_units:.2g}",
    )


def scaling(comparison: Comparison) -> str:
    """Return a sentence on the units, the travel and the top speed of the tests."""
    scales = comparison.setting.scales
    axis = comparison.setting.axis
    reference = comparison.laws.get(REFERENCE)
    length, force = si_unit("position", axis), si_unit("effort", axis)
    units = (
        f"{number(scales.force)} {force}, {number(scales.time)} s, {number(scales.length)} {length}"
    )
    said = (
        f"units of force, time and length in the tests: {units}; (F_s - F_c)/F_c is "
        f"{number(scales.breakaway - 1.0)}"
    )
    if reference is None:
        return said
    runs = reference.runs.values()
    travel = max(float(np.ptp(run.position)) for run in runs)
    speed = max(float(np.abs(run.velocity).max()) for run in runs)
    return (
        f"{said}; the {REFERENCE} law travels {number(travel, 3)} {length} at up to "
        f"{number(speed, 3)} {length}/s"
    )


def lines(comparison: Comparison, explain: bool = False) -> list[str]:
    """Return the lines of the text; `explain` adds the cells that differ from the thesis."""
    out = [scaling(comparison), ""]
    for table in tables(comparison):
        out += [*table.lines(), ""]
    for item in comparison.differences if explain else ():
        out.append(
            f"table {item.table}, {item.law}, {ROWS[item.row]}: computed "
            f"{item.computed}, printed {item.printed}: {item.reason}"
        )
    return out
