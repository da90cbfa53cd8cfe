"""Figures of a comparison: figures 3.11 to 3.25 of the thesis, and the same for other laws."""

from __future__ import annotations

import numpy as np

from frictool.compare import drift_criterion, input_protocol
from frictool.compare.comparison import POINTS_PER_LEG, Comparison, LawResult
from frictool.compare.curve_figures import draw_rows, over_time
from frictool.compare.thesis_tables import TESTS
from frictool.compare.trajectory import LawTrajectory
from frictool.documents.quantity import si_unit
from frictool.engine.drive import effort
from frictool.presentation.sections import PageFigure

THESIS: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("3.11", "stick_slip", ("lugre",)),
    ("3.12", "stick_slip", ("elasto_plastic",)),
    ("3.13", "stick_slip", ("hybrid_a", "lugre")),
    ("3.14", "stick_slip", ("hybrid_b", "lugre")),
    ("3.15", "limit_cycle", ("hybrid_a", "lugre")),
    ("3.16", "limit_cycle", ("elasto_plastic",)),
    ("3.18", "presliding", ("lugre",)),
    ("3.19", "presliding", ("elasto_plastic",)),
    ("3.20", "presliding", ("hybrid_b",)),
    ("3.21", "presliding", ("hybrid_c",)),
    ("3.23", "drift", ("lugre", "elasto_plastic")),
    ("3.24", "drift", ("hybrid_a", "hybrid_b", "hybrid_c")),
    ("3.25", "drift_zoom", ("hybrid_a", "hybrid_b", "hybrid_c")),
)
NAMES = {
    "stick_slip": "Stick-slip",
    "limit_cycle": "Limit cycle",
    "presliding": "Presliding, friction over position",
    "drift": "Drift test",
    "drift_zoom": "Drift test, last two seconds",
}

SIGNALS = {  # signals in a figure of a test, from top to bottom
    "stick_slip": "position, velocity and friction over time",
    "limit_cycle": "position, velocity and friction over time",
    "presliding": "one loop",
    "drift": "position and velocity over time",
    "drift_zoom": "position over time",
}


def pictures(comparison: Comparison) -> list[PageFigure]:
    """Return the thesis's figures of the compared laws, then figures of laws not in the thesis."""
    shown = [_inputs(comparison, "3.17"), _inputs(comparison, "3.22")]
    covered: set[tuple[str, str]] = set()
    for number, test, laws in THESIS:
        present = {law: comparison.laws[law] for law in laws if law in comparison.laws}
        if len(present) == len(laws) and _exists(test, present):
            shown.append(_picture(comparison, number, test, present))
            covered |= {(test, law) for law in laws}
    shown.sort(key=lambda picture: picture.title)
    others = [
        (test, {law: tested})
        for law, tested in comparison.laws.items()
        for test in TESTS
        if (test, law) not in covered
    ]
    shown += [_picture(comparison, "", test, laws) for test, laws in others if _exists(test, laws)]
    return shown


def _figure(number: str, title: str, svg: str) -> PageFigure:
    return PageFigure(number, svg, f"Thesis {number}. {title}" if number else title)


def _exists(test: str, laws: dict[str, LawResult]) -> bool:
    return test != "presliding" or all(tested.loop is not None for tested in laws.values())


def _units(comparison: Comparison) -> tuple[str, str]:
    return si_unit("position", comparison.setting.axis), si_unit("effort", comparison.setting.axis)


def _picture(
    comparison: Comparison, number: str, test: str, laws: dict[str, LawResult]
) -> PageFigure:
    units = _units(comparison)
    names = "; ".join(tested.title for tested in laws.values())
    title = f"{NAMES[test]}, {SIGNALS[test]}. Simulated: {names}"
    label = f"{test} {' '.join(laws)}"
    if test == "presliding":
        curves = [(law, *tested.loop) for law, tested in laws.items() if tested.loop is not None]
        return _figure(
            number,
            title,
            draw_rows(label, f"x [{units[0]}]", [(f"F [{units[1]}]", curves)], thin=False),
        )
    runs: dict[str, LawTrajectory] = {
        law: tested.runs["drift" if test == "drift_zoom" else test] for law, tested in laws.items()
    }
    if test == "drift_zoom":
        end = drift_criterion.END * comparison.setting.scales.time
        window = next(iter(runs.values())).between(end - 2.0 * comparison.setting.scales.time, end)
        return _figure(number, title, draw_rows(label, "t [s]", over_time(runs, units, window)[:1]))
    rows = over_time(runs, units)
    # the drift test's friction is left out: 200 waves would be a black bar
    return _figure(number, title, draw_rows(label, "t [s]", rows[:2] if test == "drift" else rows))


def _inputs(comparison: Comparison, number: str) -> PageFigure:
    scales = comparison.setting.scales
    units = _units(comparison)
    if number == "3.17":
        path, _ = input_protocol.presliding_path(comparison.setting.presliding, POINTS_PER_LEG)
        travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path)))])
        time = travelled / (input_protocol.CREEP_SPEED * scales.speed)
        return _figure(
            number,
            "Input position of the presliding test over time, the same for each law",
            draw_rows("presliding input", "t [s]", [(f"x [{units[0]}]", [("", time, path)])]),
        )
    time = np.linspace(0.0, 6.0 * scales.time, 3001)
    start = 0.0
    force = np.zeros_like(time)
    for end, drive in input_protocol.drift(scales):
        here = (time >= start) & (time <= end)
        force[here] = [effort(t, 0.0, 0.0, 0.0, drive.as_array()) for t in time[here]]
        start = end
    return _figure(
        number,
        "Input force of the drift test over its first six seconds, the same for each law",
        draw_rows("drift input", "t [s]", [(f"u [{units[1]}]", [("", time, force)])]),
    )
