"""Facts in bench.yaml other than plant parameters: timing, limits, encoder and springs.

A controller is verified for these facts. The facts are a mapping from the names in FACTS to numbers
in SI units. In this form, the facts of a bench, a model, a mechanism and a log can be compared.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import NamedTuple

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, si_unit

RECORD = "played_rig"  # metadata record that maps each fact to its number as JSON
ROUNDING = 1e-9  # relative tolerance of facts and of interval ends


class Fact(NamedTuple):
    """Property of a rig that bench.yaml states: its name in messages, and its unit.

    `unit` is a unit, or a quantity such as `position` or `drive`, whose SI unit depends on the
    kind of axis or drive.
    """

    label: str
    unit: str


FACTS = {
    "sample_period_s": Fact("sample period", "s"),
    "delay_samples": Fact("computational delay", "samples"),
    "loop_time_constant_s": Fact("time constant of the drive", "s"),
    "drive_limit": Fact("drive limit", "drive"),
    "encoder_step": Fact("encoder step", "position"),
    "resistance_ohm": Fact("winding resistance", "ohm"),
    "supply_v": Fact("winding voltage", "V"),
    "stiffness": Fact("stiffness of a spring on the axis", "stiffness"),
}


def facts_of(bench: Bench, model: Model | None = None) -> dict[str, float]:
    """Return the facts of a bench by name, with the stiffness of the model's spring.

    The stiffness is 0 without a model or without a spring. If the bench states no winding, the
    resistance is 0 ohm and the voltage infinite.
    """
    actuator = bench.actuator
    load = None if model is None or model.laws is None else model.laws.load
    winding = actuator.winding
    spring = None if load is None else load.stiffness
    return {
        "sample_period_s": bench.sample_period_s,
        "delay_samples": float(bench.delay_samples),
        "loop_time_constant_s": actuator.loop_time_constant_s,
        "drive_limit": actuator.limit.value,
        "encoder_step": bench.encoder.resolution,
        "resistance_ohm": 0.0 if winding is None else winding.resistance_ohm,
        "supply_v": math.inf if winding is None else winding.voltage_v,
        "stiffness": 0.0 if spring is None else spring.value,
    }


def different_facts(verified: Bench, facts: Mapping[str, float]) -> tuple[str, ...]:
    """Return a phrase for each fact that differs from the bench of the verification.

    An example of a phrase is `drive limit 5 A, verified 10 A`. Facts that are missing in `facts`
    are not compared. The stiffness of a spring is compared by `different_stiffness`.
    """
    known = facts_of(verified)
    others = {
        name: facts[name]
        for name, value in known.items()
        if name != "stiffness" and not math.isclose(facts.get(name, value), value, rel_tol=ROUNDING)
    }
    return tuple(
        _phrase(name, value, _shown(known[name], _unit(name, verified)), verified)
        for name, value in others.items()
    )


def different_stiffness(
    verified: Bench, spring: Estimate | None, ends: tuple[float, float]
) -> tuple[str, ...]:
    """Return a phrase if a stiffness was not covered by the verification, else an empty tuple.

    - spring: stiffness with which the loops were verified; None if they had no spring
    - ends: interval of the stiffness [N m/rad | N/m]; (0, 0) without a spring

    A controller is verified without a spring and at both ends of the interval of `spring`. The
    verification therefore covers every stiffness between 0 and either end.
    """
    low, high = (0.0, 0.0) if spring is None else spring.interval
    low, high = min(0.0, low), max(0.0, high)
    tolerance = ROUNDING * max(abs(low), abs(high))
    if low - tolerance <= ends[0] <= ends[1] <= high + tolerance:
        return ()
    unit = _unit("stiffness", verified)
    covered = _shown(high, unit) if low == high else f"{low:.6g} to {_shown(high, unit)}"
    worst = max(ends, key=lambda end: max(end - high, low - end))
    return (_phrase("stiffness", worst, covered, verified),)


def missing_facts(facts: Mapping[str, float]) -> tuple[str, ...]:
    """Return the labels of the facts that are missing in `facts`, for example in a log's facts."""
    return tuple(fact.label for name, fact in FACTS.items() if name not in facts)


def facts_to_text(facts: Mapping[str, float]) -> dict[str, str]:
    """Return each fact as JSON text, for a log's metadata."""
    return {name: json.dumps(value) for name, value in facts.items()}


def facts_of_text(record: Mapping[str, str]) -> dict[str, float]:
    """Return the facts in a log's metadata; entries that are not numbers are left out."""
    facts = {}
    for name, text in record.items():
        try:
            value = float(json.loads(text))
        except (ValueError, TypeError):
            continue
        if not math.isnan(value):
            facts[name] = value
    return facts


def _phrase(name: str, present: float, verified: str, bench: Bench) -> str:
    return f"{FACTS[name].label} {_shown(present, _unit(name, bench))}, verified {verified}"


def _unit(name: str, bench: Bench) -> str:
    unit = FACTS[name].unit
    if unit in ("position", "stiffness"):
        return si_unit(unit, bench.axis)
    return bench.actuator.limit.unit if unit == "drive" else unit


def _shown(value: float, unit: str) -> str:
    return f"{value:.6g} {unit}" if math.isfinite(value) else "none"
