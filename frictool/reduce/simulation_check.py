"""Check of a reduction by simulation of the mechanism after each step.

The mechanism after each step is compared with the mechanism before the step, under the commands of
check_commands.py. The compared quantity is the position of the sensor's block, as long as the block
is within the travel. The allowed difference is the backlash at the sensor plus `tolerance` times
the distance that the axis travels forward and back. The relative error that a step predicts in
closed form must also be below `tolerance`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.presentation.tie_rule import largest
from frictool.reduce.advice import other_tolerance, passing_bandwidth
from frictool.reduce.check_commands import CheckRun, runs
from frictool.reduce.check_positions import mechanism_positions, model_positions
from frictool.reduce.coordinate_change import from_reference, sensor_frame, view
from frictool.reduce.reduction_chain import ReductionChain
from frictool.reduce.step_report import MeasuredError, StepReport
from frictool.typing import Vector

Progress = Callable[[str], None]

STOP_TOLERANCE = 1e-9  # rad | m, tolerance of a block that rests on an end stop
TOLERANCE = 0.05  # default of `tolerance`, relative to the travelled distance


@dataclass(frozen=True)
class SimulationCheck:
    """Result of the check of a reduction.

    reports: reports of all steps, with measured errors; the last step gives one inertia.
    play: backlash at the sensor [rad | m].
    unit: unit of positions at the sensor.
    refused: message on the first error that is too large; None if the check passed.
    """

    reports: tuple[StepReport, ...]
    tolerance: float
    play: float
    runs: int
    unit: str
    refused: str | None

    @property
    def verdict(self) -> str:
        """Return one line that states whether the reduction succeeded, with the largest error."""
        last = self.reports[-1].measured
        assert last is not None
        if self.refused is not None:
            return f"not reduced: {self.refused}"
        return (
            f"reduced: in {self.runs} runs the positions of model and mechanism differ by at "
            f"most {last.whole:.3g} {self.unit} over a distance of {last.travelled:.3g} "
            f"{self.unit}; allowed: {100.0 * self.tolerance:g} % of the distance plus the "
            f"backlash of {self.play:.3g} {self.unit}"
        )


def check_reduction(
    chain: ReductionChain,
    model: Model,
    final: StepReport,
    tolerance: float = TOLERANCE,
    progress: Progress = lambda _: None,
) -> SimulationCheck:
    """Simulate the mechanism before and after each step, and the model; compare the positions.

    final: report of the last step.

    Raises NoSolutionError if a simulation fails or if there is no test run.
    """
    there = sensor_frame(chain.whole, chain.source, chain.sensor)
    actuator = model.bench.actuator
    tests = runs(
        chain.one, actuator.constant.value, actuator.limit.value, model.bench.sample_period_s
    )
    if not tests:
        raise NoSolutionError(
            f"{chain.whole.name}: not checked: every test motion passes a position where the "
            "friction is almost 0; add the friction of a bearing"
        )
    size = abs(there.ratio)
    side = 1.0 if there.ratio > 0.0 else -1.0

    def at_root(position: float) -> float:
        return (position - side * there.offset) / size

    progress("simulating the whole mechanism")
    here = from_reference(chain.whole, chain.source)
    played = _displacements(
        tests,
        lambda run: (
            side
            * mechanism_positions(here, chain.source, chain.sensor, at_root(run.start), run.command)
        ),
    )
    whole = [
        moves[: _within(moves + run.start, chain.one.travel)]
        for moves, run in zip(played, tests, strict=True)
    ]

    def crossing(player: Callable[[CheckRun], Vector]) -> list[Vector]:
        """Return the displacements in each run, up to the first sample outside the travel."""
        return [
            moves[: _within(moves + run.start, chain.one.travel) + 1]
            for moves, run in zip(_displacements(tests, player), tests, strict=True)
        ]

    before = whole
    last = chain.whole
    reports = list[StepReport]()
    moved = False
    for step in chain.steps:
        progress(f"simulating after: {step.report.step}")
        moved = moved or step.report.step == "sensor"
        now = (
            before
            if step.mechanism == last
            else crossing(
                _player(
                    step.mechanism,
                    chain,
                    1.0 if moved else size,
                    (lambda x: x) if moved else at_root,
                )
            )
        )
        reports.append(replace(step.report, measured=_measured(tests, before, now, whole)))
        before = now
        last = step.mechanism
    progress("simulating the one-inertia model")
    now = crossing(lambda run: model_positions(model, run.start, run.command))
    reports.append(replace(final, measured=_measured(tests, before, now, whole)))
    play = chain.one.play.width
    unit = si_unit("position", model.bench.axis)
    return SimulationCheck(
        tuple(reports),
        tolerance,
        play,
        len(tests),
        unit,
        _refused(reports, tolerance, play, chain, unit),
    )


def _player(
    mechanism: Mechanism, chain: ReductionChain, size: float, position: Callable[[float], float]
) -> Callable[[CheckRun], Vector]:
    here = view(mechanism, mechanism.sources[chain.source].on)
    return lambda run: (
        size
        * mechanism_positions(here, chain.source, chain.sensor, position(run.start), run.command)
    )


def _displacements(
    tests: tuple[CheckRun, ...], player: Callable[[CheckRun], Vector]
) -> list[Vector]:
    moves = [player(run) for run in tests]
    return [positions - positions[0] for positions in moves]


def _within(positions: Vector, travel: tuple[float, float] | None) -> int:
    if travel is None:
        return len(positions)
    outside = np.flatnonzero(
        (positions < travel[0] - STOP_TOLERANCE) | (positions > travel[1] + STOP_TOLERANCE)
    )
    return int(outside[0]) if outside.size else len(positions)


def _measured(
    tests: tuple[CheckRun, ...], before: list[Vector], now: list[Vector], whole: list[Vector]
) -> MeasuredError:
    """Return the error of a step, from the run in which the step changes the position most.

    `whole` in the result is the largest difference from the whole mechanism in all runs.
    """
    distances = [_distance(a, b, one) for a, b, one in zip(before, now, whole, strict=True)]
    lengths = [float(np.sum(np.abs(np.diff(one)))) for one in whole]
    shares = [
        distance / length if length > 0.0 else 0.0
        for distance, length in zip(distances, lengths, strict=True)
    ]
    _, worst = largest(shares)
    beyond = max(_distance(one, b, one) for one, b in zip(whole, now, strict=True))
    return MeasuredError(distances[worst], lengths[worst], tests[worst].name, beyond)


def _distance(a: Vector, b: Vector, whole: Vector) -> float:
    """Return the largest difference of the positions a and b.

    Each of the three arrays ends where its motion leaves the travel. Only the samples that all
    three arrays contain are compared.
    """
    count = min(a.shape[0], b.shape[0], whole.shape[0])
    return float(np.max(np.abs(a[:count] - b[:count]), initial=0.0))


def _refused(
    reports: list[StepReport], tolerance: float, play: float, chain: ReductionChain, unit: str
) -> str | None:
    """Return a message with advice on the first error that is too large; None if there is none.

    If resonances are kept, the measured error of the one-inertia model is not checked.
    """
    judged = reports[:-1] if chain.kept else reports
    for one in reports:
        if one.predicted > tolerance and one.covered is None:
            error = f"an error of {100 * one.predicted:.3g} % of {one.of}"
            allowed = (
                f"{one.step}: neglecting {one.neglects} causes {error}; "
                f"allowed: at most {100 * tolerance:g} %"
            )
            return (
                f"{allowed}; try {_other(one.step, chain.whole, tolerance)}"
                f"{other_tolerance(judged, play)}"
            )
        measured = one.measured
        if measured is None or (chain.kept and one is reports[-1]):
            continue
        if measured.distance > tolerance * measured.travelled + play:
            return (
                f"{one.step}: in the run {measured.where}, the step changes the position by "
                f"{measured.distance:.3g} {unit} over a distance of "
                f"{measured.travelled:.3g} {unit}; "
                f"allowed: {100 * tolerance:g} % of the distance plus "
                f"the backlash of {play:.3g} {unit}{_inertia_bounds(one, chain)}; "
                f"try {other_tolerance(judged, play)}"
            )
    return None


def _inertia_bounds(report: StepReport, chain: ReductionChain) -> str:
    if report.covered is None:
        return ""
    least, most = (
        chain.one.inertia * end for end in (chain.one.reflected.least, chain.one.reflected.most)
    )
    return (
        f"; the reflected inertia is between {least:.4g} and {most:.4g}, depending on the load's "
        f"direction; {report.covered} contains both"
    )


def _other(step: str, whole: Mechanism, tolerance: float) -> str:
    passing = passing_bandwidth(whole, tolerance) if step == "compliance" else None
    return "" if passing is None else f"--bandwidth {passing:g}, or "
