"""Each step enlarged: position with the zone of 5 % around the final value and the limits of the specification, and the drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.metrics.final_value import final_value
from frictool.metrics.response_time import zone_half_width
from frictool.report.curves import Picture, draw, drive_of, log_colours
from frictool.report.evidence import Evidence
from frictool.report.figures import INK, LIMIT, MUTED, ZONE, drawing, new_figure
from frictool.report.measure import Measured
from frictool.report.requirement import number
from frictool.svg import render

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Judged = tuple[tuple[Evidence, tuple[Measured, ...]], ...]
MOST_STEPS = 12
BEYOND_SETTLING = 1.6  # times the slowest response


def step_views(spec: Spec, judged: Judged) -> list[Picture]:
    """One picture for each step, with every stream that plays the same step; the first twelve."""
    groups: dict[tuple[int, float, float], list[tuple[Evidence, Measured]]] = {}
    for evidence, holds in judged:
        for measured in holds:
            if measured.hold.origin is not None:
                key = (measured.number, round(measured.start_s, 6), measured.hold.target)
                groups.setdefault(key, []).append((evidence, measured))
    shown = sorted(groups.items())[:MOST_STEPS]
    return [_view(spec, plays) for _, plays in shown]


def window(spec: Spec, plays: list[tuple[Evidence, Measured]]) -> float:
    """How much of the step is shown [s]: past the slowest response and the response time allowed, all of it where one never settles."""
    held = max(float(e.stream.time[m.hold.stop - 1]) - m.start_s for e, m in plays)
    responses = [m.values.get("response_time_95", math.inf) for _, m in plays]
    longest = max([*responses, spec.response_time_95_s or 0.0])
    return min(held, BEYOND_SETTLING * longest) if longest > 0.0 else held


def _view(spec: Spec, plays: list[tuple[Evidence, Measured]]) -> Picture:
    """Position above, drive below where one is known; time counts from the step."""
    plays = sorted(plays, key=lambda play: play[0].nominal)
    colours = log_colours([evidence for evidence, _ in plays])
    length = window(spec, plays)
    driven = any(drive_of(evidence) is not None for evidence, _ in plays)
    unit, top = si_unit("position", spec.axis), plays[-1]
    with drawing(f"step {top[1].number}"):
        figure, axes = new_figure(2 if driven else 1, 4.2 if driven else 2.7)
        for evidence, measured in plays:
            _curves(axes, evidence, measured, colours[evidence.source], length)
        _limits(axes[0], spec, *top)
        axes[0].set(ylabel=f"position [{unit}]")
        axes[-1].set(xlabel="time since the step [s]", xlim=(-0.03 * length, length))
        if driven:
            axes[1].set(ylabel=f"{spec.drive} [{si_unit(spec.drive, spec.axis)}]")
        svg = render(figure, f"step {top[1].number} enlarged")
    return Picture(_title(top[1], unit), svg, _caption(spec, plays))


def _curves(axes: list[Axes], evidence: Evidence, measured: Measured, colour: str, length: float) -> None:
    time = evidence.stream.time - measured.start_s
    part = slice(*np.searchsorted(time, (-0.03 * length, 1.02 * length)).tolist())
    draw(axes[0], evidence, colour, time[part], evidence.stream.signals["position"][part])
    drive = drive_of(evidence)
    if drive is not None:
        draw(axes[1], evidence, colour, time[part], drive[part])


def _limits(axes: Axes, spec: Spec, evidence: Evidence, measured: Measured) -> None:
    """The reference, the zone of the topmost stream, the overshoot and the response time allowed."""
    hold = measured.hold
    assert hold.origin is not None
    final = final_value(hold.of(evidence.stream.signals["position"]))
    half = zone_half_width(hold.origin, hold.target, evidence.resolution)
    axes.axhspan(final - half, final + half, color=ZONE, linewidth=0.0, zorder=0.5)
    axes.axhline(hold.target, color=INK, linewidth=1.0, linestyle=(0, (4, 2)), zorder=4.0)
    if spec.overshoot_percent is not None:
        allowed = hold.target + spec.overshoot_percent / 100.0 * (hold.target - hold.origin)
        axes.axhline(allowed, color=LIMIT, linewidth=1.0, linestyle=(0, (1, 1.5)), zorder=4.0)
    if spec.response_time_95_s is not None:
        axes.axvline(spec.response_time_95_s, color=MUTED, linewidth=1.0, linestyle=(0, (1, 1.5)), zorder=1.0)


def _title(measured: Measured, unit: str) -> str:
    return f"Step {measured.number}: {number(measured.hold.origin)} to {number(measured.hold.target)} {unit}, at {measured.start_s:.4g} s"


def _caption(spec: Spec, plays: list[tuple[Evidence, Measured]]) -> str:
    responses = [m.values["response_time_95"] for _, m in plays if "response_time_95" in m.values]
    worst = max(responses, default=math.nan)
    told = "" if math.isnan(worst) else "Not every stream settles. " if math.isinf(worst) else f"Slowest response {worst * 1e3:.4g} ms. "
    marks = ["green: 5 % zone around the final value", "dashed: reference"]
    if spec.overshoot_percent is not None:
        marks.append("red dots: overshoot allowed")
    if spec.response_time_95_s is not None:
        marks.append("grey dots: response time allowed")
    return f"{told}{'; '.join(marks).capitalize()}."
