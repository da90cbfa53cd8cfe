"""Changes of bench or test duration that make an unreachable precision reachable."""

from __future__ import annotations

import math
from collections.abc import Callable

from msgspec.structs import replace

from frictool.documents.bench import Bench
from frictool.documents.quantity import Span
from frictool.errors import NoSolutionError
from frictool.identify.excite.precise_strokes import PrecisionRequest, stroke_program
from frictool.identify.excite.stroke_candidates import stroke_candidates
from frictool.identify.excite.stroke_design import shortest

FACTORS = (2.0, 4.0, 16.0)


def remedies(bench: Bench, request: PrecisionRequest, needed: float | None) -> list[str]:
    """Return text on changes, each of which alone makes the requested precision reachable.

    The precision is computed from the information of the test; the test is not simulated. `needed`
    is the shortest duration on the unchanged bench, s; None if no duration suffices.
    """
    shown = [] if needed is None else [f"a test of {_seconds(needed)}"]
    for change in REMEDIES:
        for factor in FACTORS:
            changed, text = change(bench, factor)
            if changed is None:
                break
            duration = _duration(changed, request)
            if duration <= request.longest:
                shown.append(f"{text} ({_seconds(duration)})")
                break
    if not shown:
        return ["a factor of 16 in encoder resolution, travel or drive limit would not suffice"]
    return ["one of these changes may suffice (not simulated): " + "; ".join(shown)]


def _seconds(duration: float) -> str:
    return f"{duration:.3g} s" if duration < 1000.0 else f"{duration:.0f} s"


def _duration(bench: Bench, request: PrecisionRequest) -> float:
    """Return the duration [s] of the shortest test on `bench` that is precise enough, or inf."""
    try:
        program = stroke_program(
            bench, request, stroke_candidates(bench, request.noise, request.effects)
        )
    except NoSolutionError:
        return math.inf
    times = shortest(program)
    return math.inf if times is None else float(times @ program.duration)


def _resolution(bench: Bench, factor: float) -> tuple[Bench | None, str]:
    encoder = bench.encoder
    if encoder.counts_per_revolution is not None:
        counts = factor * encoder.counts_per_revolution
        finer = replace(encoder, counts_per_revolution=counts)
        return replace(bench, encoder=finer), f"an encoder of {counts:.0f} counts a revolution"
    assert encoder.step is not None
    step = replace(encoder.step, value=encoder.step.value / factor)
    finer = replace(encoder, step=step)
    return replace(bench, encoder=finer), f"an encoder step of {step.value:.3g} {step.unit}"


def _travel(bench: Bench, factor: float) -> tuple[Bench | None, str]:
    travel = bench.mechanics.travel
    if travel is None:
        return None, ""
    width = factor * (travel.high - travel.low)
    longer = Span(travel.low, travel.low + width, travel.unit)
    mechanics = replace(bench.mechanics, travel=longer)
    return replace(bench, mechanics=mechanics), f"a travel of {width:.3g} {travel.unit}"


def _drive(bench: Bench, factor: float) -> tuple[Bench | None, str]:
    limit = bench.actuator.limit
    stronger = replace(limit, value=factor * limit.value)
    actuator = replace(bench.actuator, limit=stronger)
    text = f"a drive limit of {stronger.value:.3g} {limit.unit}"
    return replace(bench, actuator=actuator), text


REMEDIES: tuple[Callable[[Bench, float], tuple[Bench | None, str]], ...] = (
    _resolution,
    _travel,
    _drive,
)
