"""Figures of a campaign: pass rates, metrics with limits, and shares of failing trials by factor.

If there are many trials, a figure shows bins instead of single trials.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import FuncFormatter, MaxNLocator

from frictool.campaign.statistics.clopper_pearson import interval
from frictool.campaign.statistics.distribution import COVERED, Distribution
from frictool.campaign.statistics.findings import Findings
from frictool.campaign.statistics.sensitivity import FailureComparison
from frictool.campaign.views.failure_plane import plane
from frictool.campaign.views.figure_style import (
    BAD,
    BAND,
    GOOD,
    OPEN,
    axis_label,
    drawing,
    new_figure,
)
from frictool.campaign.views.messages import (
    chance_text,
    percent,
    percent_text,
    quantity,
    unit_shown,
)
from frictool.documents.metric_table import requirement_title
from frictool.presentation.colours import INK, MUTED
from frictool.presentation.sections import PageFigure
from frictool.presentation.svg import render_compact

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 240  # number of points of a distribution curve
FACTORS = 6  # largest number of factors with a figure of failures over their range
ROW = 0.3  # height of the row of one pass rate [inch]


def rates(findings: Findings) -> PageFigure:
    """Return the figure of the pass rates of the campaign and of each requirement."""
    rate = findings.rate
    rows = [("all requirements", rate.passed, rate.undecided)]
    rows += [
        (requirement_title(one.metric.name), one.met, one.undecided)
        for one in findings.distributions
    ]
    height = 0.75 + ROW * len(rows)
    with drawing("rates"):
        figure, (axes,) = new_figure(height=height, left=1.55)
        lows = [1.0]
        for index, (_, good, open_) in enumerate(rows):
            low = good / rate.count
            high = (good + open_) / rate.count
            if not rate.whole:
                low = interval(good, rate.count, rate.confidence, rate.method)[0]
                high = interval(good + open_, rate.count, rate.confidence, rate.method)[1]
            share = good / rate.count
            colour = GOOD if good == rate.count else OPEN if good + open_ == rate.count else BAD
            axes.plot(
                [low, high],
                [index, index],
                color=colour,
                linewidth=5.0,
                alpha=0.3,
                solid_capstyle="butt",
            )
            if open_ < rate.count:
                axes.plot([share], [index], "o", color=colour, markersize=5.0)
                lows.append(low)
        if findings.required is not None:
            axes.axvline(findings.required, color=MUTED, linewidth=1.2, linestyle=(0, (4, 2)))
            lows.append(findings.required)
        margin = 1.08 * (1.0 - min(lows)) or 0.01
        axes.set(
            xlim=(max(-0.02, 1.0 - margin), 1.0 + 0.03 * margin),
            ylim=(len(rows) - 0.4, -0.6),
            xlabel="share of the trials",
        )
        axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))
        axes.set_yticks(range(len(rows)), [name for name, _, _ in rows])
        axes.xaxis.set_major_formatter(_in_percent())
        axes.grid(visible=False, axis="y")
        svg = render_compact(figure, "share of the trials that pass, as a whole and by requirement")
    bars = "" if rate.whole else f" Bars: {percent_text(rate.confidence)} intervals."
    dashed = (
        "" if findings.required is None else f" Dashed: required {percent_text(findings.required)}."
    )
    return PageFigure(
        "Pass rates",
        svg,
        f"Dots: the share of {rate.count} {rate.noun} that pass.{bars}{dashed} Undecided trials "
        f"count neither as passed nor as failed.",
    )


def metric(findings: Findings, one: Distribution) -> PageFigure | None:
    """Return the figure of a metric's distribution; None if the metric is constant."""
    if not one.varies:
        return None
    name = requirement_title(one.metric.name)
    unit = unit_shown(one.metric.unit)
    with drawing(f"metric {one.metric.name}"):
        figure, (top, bottom) = new_figure(rows=2, height=3.5)
        _bars(top, one)
        _curve(bottom, findings, one)
        low, high = one.histogram.edges[0], one.histogram.edges[-1]
        drawn = low - 1.5 * (high - low) <= one.metric.limit <= high + 1.5 * (high - low)
        for axes in (top, bottom):
            if drawn:
                axes.axvline(one.metric.limit, color=BAD, linewidth=1.2, linestyle=(0, (4, 2)))
            if one.bound is not None:
                axes.axvline(one.bound, color=INK, linewidth=1.0, linestyle=(0, (1, 1.5)))
        shown = [
            low,
            high,
            *([one.metric.limit] if drawn else []),
            *([one.bound] if one.bound is not None else []),
        ]
        margin = 0.03 * (max(shown) - min(shown))
        top.set_xlim(min(shown) - margin, max(shown) + margin)
        top.set_ylabel("trials")
        bottom.set(
            ylabel="share below", ylim=(-0.02, 1.02), xlabel=f"{name} [{unit}]" if unit else name
        )
        bottom.yaxis.set_major_formatter(_in_percent())
        svg = render_compact(figure, f"distribution of {name} over the trials")
    return PageFigure(name, svg, _metric_caption(findings, one, drawn))


def causes(findings: Findings) -> list[PageFigure]:
    """Return figures of the share of failing trials over each of the most significant factors.

    The result is empty if no trial fails or none passes.
    """
    questions = findings.sensitivity.questions
    if not questions or questions[0].name != "":
        return []
    return [_over_range(findings, questions[0], i) for i in questions[0].named[:FACTORS]]


def failing_plane(findings: Findings) -> PageFigure | None:
    """Return the figure of failures in the plane of `Sensitivity.pair`; None without a pair."""
    pair = findings.sensitivity.pair
    if pair is None:
        return None
    first, second = (findings.trials.space.factors[i] for i in (pair.first, pair.second))
    with drawing("plane"):
        figure, (axes,) = new_figure(height=3.9)
        caption = plane(axes, findings.trials, pair.first, pair.second)
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        axes.set(
            xlabel=axis_label(first.label, unit_shown(first.unit), pair.first),
            ylabel=axis_label(second.label, unit_shown(second.unit), pair.second),
        )
        svg = render_compact(figure, "trials that fail in the plane of two factors")
    explained = f"The two factors explain {pair.joint:.0%} of the variance of the outcome".replace(
        "%", " %"
    )
    beyond = (
        f"; their interaction alone explains {pair.beyond:.0%}".replace("%", " %")
        if pair.beyond > max(0.01, 3.0 * pair.error)
        else ""
    )
    return PageFigure(f"{first.label} and {second.label}", svg, f"{caption} {explained}{beyond}.")


def _bars(axes: Axes, one: Distribution) -> None:
    edges, counts = one.histogram.edges, one.histogram.counts
    middle = 0.5 * (edges[:-1] + edges[1:])
    good = middle <= one.metric.limit if one.metric.relation == "<=" else middle >= one.metric.limit
    for chosen, colour in ((good, GOOD), (~good, BAD)):
        if chosen.any():
            axes.bar(
                middle[chosen],
                counts[chosen],
                width=(edges[1:] - edges[:-1])[chosen],
                color=colour,
                linewidth=0.0,
            )
    axes.set_ylim(0.0, 1.06 * counts.max())


def _curve(axes: Axes, findings: Findings, one: Distribution) -> None:
    index = findings.trials.metrics.index(one.metric)
    values = findings.trials.metric_values[:, index]
    known = np.sort(values[~np.isnan(values)])
    finite = known[np.isfinite(known)]
    kept = np.unique(np.round(np.linspace(0.0, finite.size - 1.0, POINTS)).astype(int))
    values = finite[kept]
    shares = (kept + 1.0) / known.size
    if not findings.rate.whole:  # simultaneous band of Dvoretzky, Kiefer and Wolfowitz
        half = np.sqrt(
            np.log(2.0 / (1.0 - findings.rate.confidence))
            / (2.0 * max(1, known.size - (findings.rate.method == "latin")))
        )
        axes.fill_between(
            values,
            np.maximum(0.0, shares - half),
            np.minimum(1.0, shares + half),
            step="post",
            color=BAND,
            linewidth=0.0,
        )
    axes.step(values, shares, where="post", color=GOOD)


def _metric_caption(findings: Findings, one: Distribution, drawn: bool) -> str:
    unit = one.metric.unit
    relation = "≤" if one.metric.relation == "<=" else "≥"
    share = percent(one.broken / findings.rate.count)
    who = f"{share} of the trials break" if one.broken else "No trial breaks"
    said = [f"{who} the limit {relation} {quantity(one.metric.limit, unit)}"]
    said[0] += " (dashed)." if drawn else ", which lies outside the figure."
    if one.bound is not None:
        bound = (
            f"{relation} {quantity(one.bound, unit)} (dotted; "
            f"{percent_text(findings.rate.confidence)} confidence)"
        )
        said.append(f"{percent_text(COVERED)} of all plants are {bound}.")
    if one.histogram.outside:
        said.append(f"Trials with a finite value outside the figure: {one.histogram.outside}.")
    if one.beyond:
        said.append(f"Trials with an infinite value: {one.beyond}.")
    if one.missing:
        said.append(f"Trials without a value: {one.missing}.")
    return " ".join(said)


def _over_range(findings: Findings, question: FailureComparison, i: int) -> PageFigure:
    factor = findings.trials.space.factors[i]
    region = question.regions[i]
    with drawing(f"factor {i}"):
        figure, (axes,) = new_figure()
        if region.chance is not None:
            counts = np.rint(region.failing * region.sizes).astype(int)
            bars = [
                interval(int(bad), int(n), findings.rate.confidence)
                for bad, n in zip(counts, region.sizes, strict=True)
            ]
            axes.vlines(
                region.centres,
                [low for low, _ in bars],
                [high for _, high in bars],
                color=BAD,
                alpha=0.3,
                linewidth=5.0,
            )
        axes.plot(region.centres, region.failing, "o-", color=BAD, markersize=4.0)
        axes.set(
            xlabel=axis_label(factor.label, unit_shown(factor.unit), i), ylabel="share that fails"
        )
        margin = 0.03 * (factor.high - factor.low)
        axes.set_xlim(factor.low - margin, factor.high + margin)
        axes.set_ylim(bottom=0.0)
        axes.xaxis.set_major_locator(
            MaxNLocator(6, steps=[1, 2, 2.5, 5, 10], integer=factor.whole, min_n_ticks=1)
        )
        axes.yaxis.set_major_formatter(_in_percent())
        svg = render_compact(figure, "share of trials that fail over the range of a factor")
    low, high = quantity(factor.low, factor.unit), quantity(factor.high, factor.unit)
    chance = f" ({words})" if (words := chance_text(region.chance)) else ""
    return PageFigure(
        factor.label,
        svg,
        f"From {low} to {high}; failures lie at {_place_text(region.direction)}{chance}.",
    )


def _in_percent() -> FuncFormatter:
    return FuncFormatter(lambda share, _: f"{round(100.0 * share, 9):g} %")


def _place_text(direction: str) -> str:
    return {"high": "high values", "low": "low values"}.get(direction, direction)
