"""Enlarged figures of each step: position with 5 % zone and limits, and drive."""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.metrics.final_value import final_value
from frictool.metrics.response_time import zone_half_width
from frictool.presentation.colours import INK, MUTED
from frictool.presentation.plot import DASHED, DOTTED, PlotPanel
from frictool.presentation.sections import FigureView, PageFigure
from frictool.report.curve_figures import draw, draw_load, log_colours
from frictool.report.evidence import StreamEvidence
from frictool.report.figure_style import LIMIT, ZONE, new_plot
from frictool.report.hold_metrics import HoldMetrics
from frictool.report.requirement import ValueLocation, number
from frictool.report.worst_hold import limit_of

Judged = tuple[tuple[StreamEvidence, tuple[HoldMetrics, ...]], ...]
MOST_STEPS = 12
NEAR_ORIGIN = 0.05  # largest difference of two origins of the same step, relative to its amplitude
BAND_SHOWN = 3.0  # half height of the enlarged range, relative to the allowed static error
BEYOND_SETTLING = 1.6  # shown duration relative to the slowest response


def step_views(spec: Spec, judged: Judged) -> list[PageFigure]:
    """Return a figure for each of the first twelve steps, with every stream that has this step."""
    return [
        _view(spec, plays, f"step-{index}")
        for index, plays in enumerate(same_steps(judged)[:MOST_STEPS], 1)
    ]


def step_key(judged: Judged, where: ValueLocation) -> str | None:
    """Return the key of the figure that shows the step at a location; None without a figure."""
    wanted = (where.log, where.stream, where.step)
    for index, plays in enumerate(same_steps(judged)[:MOST_STEPS], 1):
        shown = [(item.source, item.stream.topic, measured.number) for item, measured in plays]
        if wanted in shown:
            return f"step-{index}"
    return None


def same_steps(judged: Judged) -> list[list[tuple[StreamEvidence, HoldMetrics]]]:
    """Return the steps of all streams, grouped by initial and final reference.

    If a stream contains the same step several times, the first group has the first occurrence in
    each stream, the second group the second occurrence, and so on.
    """
    groups: list[list[tuple[StreamEvidence, HoldMetrics]]] = []
    for evidence, holds in judged:
        waiting = list(groups)  # groups that do not contain this stream yet
        for measured in holds:
            if measured.hold.origin is None:
                continue
            matching = next((group for group in waiting if _same(group[0][1], measured)), None)
            if matching is None:
                groups.append([(evidence, measured)])
            else:
                matching.append((evidence, measured))
                waiting.remove(matching)
    return groups


def _same(one: HoldMetrics, other: HoldMetrics) -> bool:
    assert one.hold.origin is not None
    assert other.hold.origin is not None
    amplitude = abs(one.hold.target - one.hold.origin)
    return (
        abs(one.hold.target - other.hold.target) <= 1e-6 * amplitude
        and abs(one.hold.origin - other.hold.origin) <= NEAR_ORIGIN * amplitude
    )


def window(spec: Spec, plays: list[tuple[StreamEvidence, HoldMetrics]]) -> float:
    """Return the duration [s] that the figure of a step shows.

    The duration includes the slowest response and the allowed response time, but ends with the
    phase of constant reference. If the axis never settles, the whole phase is shown.
    """
    longest_hold = max(float(e.stream.time[m.hold.stop - 1]) - m.start_s for e, m in plays)
    responses = [m.values.get("response_time_95", math.inf) for _, m in plays]
    longest = max([*responses, spec.response_time_95_s or 0.0])
    return min(longest_hold, BEYOND_SETTLING * longest) if longest > 0.0 else longest_hold


def _view(spec: Spec, plays: list[tuple[StreamEvidence, HoldMetrics]], key: str) -> PageFigure:
    plays = sorted(plays, key=lambda play: play[0].nominal)
    drawn_plays = sorted(plays, key=lambda play: play[0].drawing_order)
    colours = log_colours([evidence for evidence, _ in plays])
    length = window(spec, plays)
    unit = si_unit("position", spec.axis)
    top = plays[-1]
    panels = _panels(spec, plays)
    plot = new_plot(
        *panels.values(), height=1.2 + 1.5 * len(panels), x_label="time since the step [s]"
    )
    plot.x_range = (-0.03 * length, length)
    drawn = dict(zip(panels, plot.panels, strict=True))
    for evidence, measured in drawn_plays:
        _curves(drawn, evidence, measured, colours[evidence.source], length)
    _limits(drawn["position"], spec, *top)
    if "load" in drawn:
        drawn["load"].horizontal(top[1].hold.target, INK, width=1.0, dash=DASHED, order=4.0)
    svg = plot.svg(f"step {top[1].number} enlarged")
    return PageFigure(
        _title(plays, unit), svg, _caption(spec, plays), key, _views(spec, top, length)
    )


def _views(
    spec: Spec, top: tuple[StreamEvidence, HoldMetrics], length: float
) -> tuple[FigureView, ...]:
    if spec.static_error is None or not limit_of(spec, "static_error") > 0.0:
        return ()
    target = top[1].hold.target
    half = BAND_SHOWN * limit_of(spec, "static_error")
    return (FigureView("static-error band", (0.0, length), (target - half, target + half)),)


def _panels(spec: Spec, plays: list[tuple[StreamEvidence, HoldMetrics]]) -> dict[str, str]:
    unit = si_unit("position", spec.axis)
    panels = {"position": f"position [{unit}]"}
    if any(evidence.has_backlash for evidence, _ in plays):
        panels["load"] = f"load [{unit}]"
    panels["velocity"] = f"velocity [{unit}/s]"
    if any(evidence.drive is not None for evidence, _ in plays):
        panels["drive"] = f"{spec.drive} [{si_unit(spec.drive, spec.axis)}]"
    return panels


def _curves(
    panels: dict[str, PlotPanel],
    evidence: StreamEvidence,
    measured: HoldMetrics,
    colour: str,
    length: float,
) -> None:
    time = evidence.stream.time - measured.start_s
    part = slice(*np.searchsorted(time, (-0.03 * length, 1.02 * length)).tolist())
    draw(
        panels["position"], evidence, colour, time[part], evidence.stream.signals["position"][part]
    )
    if "load" in panels and evidence.load is not None:
        draw_load(panels["load"], evidence, colour, time, part)
    if evidence.velocity is not None:
        draw(panels["velocity"], evidence, colour, time[part], evidence.velocity[0][part])
    if evidence.drive is not None:
        draw(panels["drive"], evidence, colour, time[part], evidence.drive[part])


def _limits(panel: PlotPanel, spec: Spec, evidence: StreamEvidence, measured: HoldMetrics) -> None:
    hold = measured.hold
    assert hold.origin is not None
    final = final_value(hold.of(evidence.stream.signals["position"]))
    half = zone_half_width(hold.origin, hold.target, evidence.resolution)
    panel.across(final - half, final + half, ZONE, order=0.5)
    panel.horizontal(hold.target, INK, width=1.0, dash=DASHED, order=4.0)
    if spec.static_error is not None:
        error = limit_of(spec, "static_error")
        for level in (hold.target - error, hold.target + error):
            panel.horizontal(level, MUTED, width=0.6, order=3.8)
    if spec.overshoot_percent is not None:
        allowed = hold.target + spec.overshoot_percent / 100.0 * (hold.target - hold.origin)
        panel.horizontal(allowed, LIMIT, width=1.0, dash=DOTTED, order=4.0)
    if spec.response_time_95_s is not None:
        panel.vertical(spec.response_time_95_s, MUTED, width=1.0, dash=DOTTED, order=1.0)


def _title(plays: list[tuple[StreamEvidence, HoldMetrics]], unit: str) -> str:
    top = plays[-1][1]
    starts = {round(measured.start_s, 6) for _, measured in plays}
    at = f", at {top.start_s:.4g} s" if len(starts) == 1 else ", aligned at the step"
    return f"Step {top.number}: {number(top.hold.origin)} to {number(top.hold.target)} {unit}{at}"


def _caption(spec: Spec, plays: list[tuple[StreamEvidence, HoldMetrics]]) -> str:
    responses = [m.values["response_time_95"] for _, m in plays if "response_time_95" in m.values]
    worst = max(responses, default=math.nan)
    caption = (
        ""
        if math.isnan(worst)
        else "Not every stream settles. "
        if math.isinf(worst)
        else f"Slowest response {worst * 1e3:.4g} ms. "
    )
    marks = ["green: 5 % zone around the final value", "dashed: reference"]
    if spec.overshoot_percent is not None:
        marks.append("red dots: overshoot allowed")
    if spec.static_error is not None:
        marks.append("thin lines: static error allowed")
    if spec.response_time_95_s is not None:
        marks.append("grey dots: response time allowed")
    if any(evidence.has_backlash and evidence.load_is_bounded for evidence, _ in plays):
        marks.append("load: area between bounds computed from the position and the backlash")
    return f"{caption}{'; '.join(marks).capitalize()}."
