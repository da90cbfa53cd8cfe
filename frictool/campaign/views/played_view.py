"""Views of a PlayedVerdict: lines for the terminal, and JSON data."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import click

from frictool.campaign.shorter_steps import ShorterStep, ShorterSteps
from frictool.campaign.trials.controller_judge import PlayedRequirement, PlayedVerdict
from frictool.documents.metric_table import REQUIREMENTS, requirement_title

COLOURS = {True: "green", False: "red", None: "yellow"}
STATES = {True: "PASS", False: "FAIL", None: "UNDECIDED"}
OUTCOMES = {True: "MET", False: "NOT MET", None: "UNDECIDED"}


def played_lines(
    verdict: PlayedVerdict,
    plants: Sequence[str],
    scenario: str,
    steps: str,
    colour: bool = False,
    decided: bool = True,
) -> list[str]:
    """Return lines: scenario, requirements with their worst plants, failed simulations, verdict.

    `plants`: names of the plants by index.
    `scenario`: description of the scenario.
    `steps`: text on the lengths of the scenario's steps, or "".
    `decided`: False if the axis may fail although the plants pass, because the plants lack effects.
    """
    many = f"{len(plants)} plant{'s' if len(plants) > 1 else ''}"
    met, broken, undecided = (
        sum(one.met is state for one in verdict.requirements) for state in (True, False, None)
    )
    parts = [f"{met} of {len(verdict.requirements)} requirements met"]
    parts += [f"{broken} broken"] if broken else []
    parts += [f"{undecided} undecided"] if undecided else []
    counted = "" if all_met(verdict) else f"; {meeting(verdict)} of {many} meet them all"
    where = f"on {many}, with {steps}" if steps else f"on {many}"
    passed = (decided or None) if all_met(verdict) else False
    headline = f"{STATES[passed]}: {', '.join(parts)}, {where}{counted}"
    return [
        f"played: {scenario}",
        *(_line(one, plants, colour) for one in verdict.requirements),
        *(f"{plants[index]}: {reason}" for index, reason in verdict.failed.items()),
        click.style(headline, fg=COLOURS[passed], bold=True) if colour else headline,
    ]


AT_REST = ("rest", "limit_cycle")  # requirements on an axis at rest


def rest_line(verdict: PlayedVerdict) -> str:
    """Return a line on limit cycles at rest, for a controller with friction compensation."""
    judged = [one for one in verdict.requirements if one.metric.key in AT_REST]
    if not judged:
        return (
            "friction compensation may cause a limit cycle, which no requirement judges; add rest "
            "or limit_cycle to the specification"
        )
    titles = " and ".join(requirement_title(one.metric.name) for one in judged)
    many = f"{len(verdict.plants)} plant{'s' if len(verdict.plants) > 1 else ''}"
    if all(one.met for one in judged):
        return f"friction compensation: no limit cycle on the {many} simulated ({titles}: met)"
    return f"friction compensation: {titles} not met on at least one of the {many} simulated"


def all_met(verdict: PlayedVerdict) -> bool:
    """Return True if every requirement is met on every plant."""
    return not verdict.failed and all(one.met for one in verdict.requirements)


def meeting(verdict: PlayedVerdict) -> int:
    """Return the number of plants that meet every requirement."""
    return int((verdict.met == 1).all(axis=1).sum())


def played_json(
    verdict: PlayedVerdict, plants: Sequence[str], scenario: str, decided: bool = True
) -> dict[str, Any]:
    """Return the verdict as JSON values; `decided` as in `played_lines`."""
    return {
        "scenario": scenario,
        "passed": decided and all_met(verdict),
        "plants": len(plants),
        "plants_that_meet_all": meeting(verdict),
        **_judged_json(verdict, plants),
    }


def _judged_json(verdict: PlayedVerdict, plants: Sequence[str]) -> dict[str, Any]:
    return {
        "requirements": [
            {
                "key": one.metric.key,
                "value": one.value,
                "limit": one.metric.limit,
                "relation": one.metric.relation,
                "unit": one.metric.unit,
                "reserve": one.reserve,
                "met": one.met,
                "plant": plants[one.plant] if one.plant >= 0 else None,
            }
            for one in verdict.requirements
        ],
        "not_simulated": {plants[index]: reason for index, reason in verdict.failed.items()},
    }


def shorter_text(shorter: ShorterSteps) -> str:
    """Return a sentence on the requirements in steps that are shorter than the test's steps."""
    if not shorter.failed:
        unjudged = [
            requirement_title(REQUIREMENTS[key].requirement_name) for key in shorter.not_judged
        ]
        return (
            f"{_lengths(shorter.steps, shorter.unit)}: requirements met on {len(shorter.plants)} "
            f"plant{'s' if len(shorter.plants) > 1 else ''}"
            + (f" ({' and '.join(unjudged)} not judged)" if unjudged else "")
        )
    failing = [step for step in shorter.steps if step.failed]
    return (
        f"{_lengths(failing, shorter.unit)}: requirements not met, {_worst(shorter)}; if the axis "
        "makes steps of these lengths, add them to the scenario of synth --scenario"
    )


def _lengths(steps: Sequence[ShorterStep], unit: str) -> str:
    lengths = dict.fromkeys(f"{step.length:.3g}" for step in steps)
    return f"shorter steps of {', '.join(lengths)} {unit}"


def _worst(shorter: ShorterSteps) -> str:
    if shorter.worst is None:
        step = next(step for step in shorter.steps if step.failed)
        return next(iter(step.verdict.failed.values()))
    step, one = shorter.worst
    title, unit = requirement_title(one.metric.name), one.metric.unit.replace("^2", "²")
    limit = f"{one.metric.relation} {one.metric.limit:.4g} {unit}".rstrip()
    value = f"{one.value:.4g} {unit}".rstrip() if math.isfinite(one.value) else "not reached"
    return f"{title} {value} at {step.length:.3g} {shorter.unit} (allowed {limit})"


def shorter_json(shorter: ShorterSteps) -> dict[str, Any]:
    """Return the verdicts on shorter steps as JSON values."""
    return {
        "message": shorter_text(shorter),
        "met": not shorter.failed,
        "plants": len(shorter.plants),
        "unit": shorter.unit,
        "not_judged": list(shorter.not_judged),
        "steps": [
            {
                "length": step.length,
                "start": step.start,
                **_judged_json(step.verdict, shorter.plants),
            }
            for step in shorter.steps
        ],
    }


def _line(one: PlayedRequirement, plants: Sequence[str], colour: bool) -> str:
    outcome = f"{OUTCOMES[one.met]:<12}"
    unit = one.metric.unit.replace("^2", "²")
    value = f"{one.value:.4g} {unit}".rstrip() if math.isfinite(one.value) else "-"
    limit = f"{one.metric.relation} {one.metric.limit:.4g} {unit}".rstrip()
    where = f"worst at {plants[one.plant]}" if one.plant >= 0 else "undecided on every plant"
    return (
        click.style(outcome, fg=COLOURS[one.met], bold=True) if colour else outcome
    ) + f"{requirement_title(one.metric.name):<16}  {value:<11}  {limit:<11}  {where}"
