"""Text view of a log survey."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from frictool.identify.info.log_information import Information
from frictool.logs.losses import loss_lines
from frictool.logs.provenance import PROVENANCE
from frictool.logs.quality.log_kinds import KINDS
from frictool.logs.quality.survey import SignalSurvey, StreamSurvey
from frictool.logs.quality.time_base import FEWEST_LEVELS
from frictool.logs.text.text_layout import PLAIN
from frictool.presentation.line_breaking import bounded


def table(information: Information) -> str:
    """Return the whole survey as text."""
    made, surveys, facts = information.assembly, information.surveys, information.facts
    lines = [f"{Path(made.flows[0].source).name}: {facts['duration_s']:.6g} s", *_channels(facts)]
    lines += [line for seen in surveys for line in _signals(seen)]
    lines += _motion(facts, surveys)
    lines += [f"odd: {text}" for text in facts["odd"]]
    lines += [f"dated by: {topic} by {clock}" for topic, clock in facts["dated_by"].items()]
    lines += [
        f"clock offset: the clock of {topic} was ahead by {offset}"
        for topic, offset in facts["clock_offset"].items()
    ]
    for one in facts["clocks"]:
        drift = (
            "too short to estimate a drift"
            if one["drift"] is None
            else f"drift {1e6 * one['drift']:.4g} us per second"
        )
        lines.append(
            f"clock: {one['source']} shows {one['signal']} {one['offset_s']:.4g} s after "
            f"{one['against']}, {drift}"
        )
    lines += [f"lost: {text}" for text in loss_lines(made.earlier_losses)]
    lines += _method_lines(facts["methods"])
    lines += [
        f"layout: {name}: {layout}" for name, layout in facts["layout"].items() if layout != PLAIN
    ]
    lines += [f"{key}: {text}" for key, text in made.notes.get(PROVENANCE, {}).items()]
    return bounded(lines)


def _method_lines(methods: dict[str, str | None]) -> list[str]:
    by_reason: dict[str | None, list[str]] = {}
    for name, why in methods.items():
        by_reason.setdefault(why, []).append(name)
    lines = [
        f"does not suit {', '.join(names)}: {why}"
        for why, names in by_reason.items()
        if why is not None
    ]
    return [f"suits {', '.join(by_reason[None])}", *lines] if None in by_reason else lines


def _channels(facts: dict[str, Any]) -> list[str]:
    lines = [
        f"{'channel':<24} {'unit':<8} {'samples':>9} {'rate [Hz]':>10} {'jitter [s]':>10} "
        f"{'gaps':>5} {'step':>9}  range"
    ]
    for row in facts["channels"]:
        channel = f"{row['source']}.{row['name']}"
        step = "none" if row["step"] is None else f"{row['step']:.4g}"
        numbers = (
            f"{row['samples']:>9} {row['rate_hz']:>10.6g} {row['jitter_s']:>10.2g} "
            f"{row['gaps']:>5} {step:>9}"
        )
        lines.append(
            f"{channel:<24} {row['unit']:<8} {numbers}  {row['low']:.6g} to {row['high']:.6g}"
        )
    return lines


def _signals(stream: StreamSurvey) -> list[str]:
    lines = []
    for one in stream.signals.values():
        name = f"{stream.topic}.{one.name}"
        rate = stream.base.rate_hz
        if one.hold is not None:
            lines.append(
                f"held: {name} keeps its value for {one.hold} samples ({one.hold / rate:.4g} s) "
                "or more"
            )
        for top in one.flat:
            at = f"{name} is flat at {top.at:.6g} {one.unit}"
            lines.append(
                f"saturated: {at} in {top.samples} samples, for up to {top.longest / rate:.4g} s"
            )
        if one.at_limit:
            lines.append(f"saturated: {name} is at the bench's limit in {one.at_limit} samples")
    return lines


def _motion(facts: dict[str, Any], surveys: Sequence[StreamSurvey]) -> list[str]:
    seen = next((one for one in surveys if "position" in one.signals), None)
    if seen is None:
        return []
    position = seen.signals["position"]
    velocity = facts["velocity"]
    lines = [f"encoder step: {_step(position)}"]
    if velocity is not None:
        over = (
            f"from differences over {velocity['samples']} sample{'s' * (velocity['samples'] > 1)}"
        )
        lines.append(
            f"velocity: {velocity['low']:.4g} to {velocity['high']:.4g} {position.unit}/s, {over}"
        )
    test = facts["test"]
    meaning = f": {KINDS[test['kind']]}" if test["kind"] in KINDS else ""
    lines.append(
        f"test: {test['kind'] or 'too short to recognise'} "
        f"({'stated in the log' if test['given'] else 'detected'}){meaning}"
    )
    return lines


def _step(position: SignalSurvey) -> str:
    if position.step is not None:
        return f"{position.step:.6g} {position.unit}"
    if position.levels == 1:
        return "unknown: the position does not change"
    if position.levels < FEWEST_LEVELS:
        return (
            f"unknown: the position has only {position.levels} different values; at least "
            f"{FEWEST_LEVELS} are needed"
        )
    return "none: the positions are not multiples of a step"
