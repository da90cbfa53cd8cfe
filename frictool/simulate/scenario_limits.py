"""Checks of a scenario: number of samples, travel, and times of all events."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from frictool.documents.conditions import Disturbance, Signal
from frictool.documents.quantity import Span
from frictool.documents.scenario import Scenario
from frictool.simulate.document_agreement import refuse
from frictool.typing import Vector

MAX_SAMPLES = 20_000_000  # most samples of all variants: about 2 GB in memory, 0.6 GB as a log
SAME_INSTANT = 1e-9  # tolerance of an instant, relative to the duration


def check_steps(
    scenario: Scenario, period: float, runs: int, name: str, width: float = 1.0
) -> None:
    """Raise DocumentError if the steps of a scenario cannot be sampled.

    The errors are a step shorter than a sample, a sine above half the sampling frequency, and too
    many samples.

    - period: sample period [s]
    - runs, width: as in `check_length`
    - name: name of the scenario
    """
    for index, step in enumerate(scenario.steps):
        key = f"steps[{index}]"
        if step.seconds < 0.5 * period:
            refuse(
                name,
                f"{key}.duration_s",
                f"found {step.seconds:g}; allowed: at least one sample ({period:g} s)",
            )
        if step.sine is not None:
            check_frequency(step.sine.frequency_hz, period, f"{key}.sine.frequency_hz", name)
    check_length(scenario.seconds / period, runs, "steps", name, width)


def check_length(samples: float, runs: int, key: str, name: str, width: float = 1.0) -> None:
    """Raise DocumentError if the samples of all simulated plants do not fit into memory.

    - samples: number of samples of a plant
    - runs: number of plants
    - key: key of the document `name` that determines `samples`
    - width: memory per logged sample, relative to a single axis
    """
    if samples * runs * width > MAX_SAMPLES:
        problem = f"requests {samples * runs:.3g} samples in {runs} run{'s' * (runs > 1)}"
        refuse(
            name,
            key,
            f"{problem}; allowed: at most {MAX_SAMPLES / width:.0e} in total; simulate fewer "
            "variants or a shorter scenario",
        )


def check_frequency(frequency: float, period: float, key: str, name: str) -> None:
    """Raise DocumentError if a sine has less than two samples per period."""
    if frequency >= 0.5 / period:
        refuse(
            name,
            key,
            f"found {frequency:g}; allowed: below half the sampling frequency, {0.5 / period:g} Hz",
        )


def check_path(paths: Mapping[str, Vector], travel: Span | None, name: str) -> None:
    """Raise DocumentError if the reference leaves the travel of the axis.

    `paths`: samples of the reference [rad | m], by the key of the scenario that defines them.
    """
    if travel is None:
        return
    for key, values in paths.items():
        low, high = float(values.min()), float(values.max())
        if not travel.low <= low <= high <= travel.high:
            ends = f"{high:g}" if low == high else f"a path from {low:g} to {high:g}"
            allowed = f"the travel of the bench, {travel.low:g} to {travel.high:g} {travel.unit}"
            refuse(name, key, f"found {ends} {travel.unit}; allowed: {allowed}")


def check_instants(scenario: Scenario, seconds: float, period: float, name: str) -> None:
    """Raise DocumentError if an event of the scenario is impossible with its duration or sampling.

    The errors are an event after the end of the scenario, a sensor fault shorter than a sample, and
    a sine above half the sampling frequency.

    - seconds: duration of the scenario [s]
    - period: sample period [s]
    """
    limit = seconds * (1.0 + SAME_INSTANT)
    for key, begin, end in _spans(scenario):
        if begin[1] >= seconds:
            refuse(
                name,
                f"{key}.{begin[0]}",
                f"found {begin[1]:g}, after the end; allowed: below {seconds:g}, the duration of "
                "the scenario",
            )
        if end is not None and end[1] > limit:
            refuse(
                name,
                f"{key}.{end[0]}",
                f"ends at {end[1]:g} s, after the end; allowed: at most {seconds:g} s, the "
                "duration of the scenario",
            )
    for index, fault in enumerate(scenario.sensor_faults):
        if fault.until_s is not None and fault.until_s - fault.at_s < period * (1.0 - SAME_INSTANT):
            key = f"sensor_faults[{index}].until_s"
            lasts = fault.until_s - fault.at_s
            refuse(name, key, f"lasts for {lasts:g} s; allowed: at least one sample ({period:g} s)")
    courses: dict[str, Disturbance | Signal] = {
        f"disturbances[{index}]": disturbance
        for index, disturbance in enumerate(scenario.disturbances)
    }
    courses |= {
        f"sources.{source}[{index}]": one
        for source, signals in scenario.sources.items()
        for index, one in enumerate(signals)
    }
    for key, course in courses.items():
        if course.frequency_hz is not None:
            check_frequency(course.frequency_hz, period, f"{key}.frequency_hz", name)


Instant = tuple[str, float]  # key, s


def _spans(scenario: Scenario) -> Iterator[tuple[str, Instant, Instant | None]]:
    for index, disturbance in enumerate(scenario.disturbances):
        lasts = disturbance.duration_s
        end = None if lasts is None else ("duration_s", disturbance.at_s + lasts)
        yield f"disturbances[{index}]", ("at_s", disturbance.at_s), end
    for name, signals in scenario.sources.items():
        for index, signal in enumerate(signals):
            end = (
                None
                if signal.duration_s is None
                else ("duration_s", signal.at_s + signal.duration_s)
            )
            yield f"sources.{name}[{index}]", ("at_s", signal.at_s), end
    for index, fault in enumerate(scenario.sensor_faults):
        end = None if fault.until_s is None else ("until_s", fault.until_s)
        yield f"sensor_faults[{index}]", ("at_s", fault.at_s), end
    for index, command in enumerate(scenario.commands):
        yield f"commands[{index}]", ("at_s", command.at_s), None
    for name in ("friction", "viscous", "constant") if scenario.drifts is not None else ():
        points = getattr(scenario.drifts, name)
        if points:
            yield f"drifts.{name}[0]", ("at_s", points[0].at_s), None
