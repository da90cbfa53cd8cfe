"""All runs of one plant from the initial positions (starts) within an encoder count.

The controller reads the position as a count. If the counts from two starts agree at all samples,
the commands are identical; the controller's program therefore runs with numbers instead of sets.
The axis moves by the same distance from both starts (axis_enclosure.py). The range of starts is
divided wherever a count differs. With the start phi, the displacement X(k) at sample k, and the
encoder step, the count changes to n at phi = n step - X(k). Since X is an interval, the parts of
the range overlap by the width of X and by OVERLAP, so that they cover every start.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from frictool.control.compiled_program import (
    CompiledProgram,
    control_step,
    copy_program,
    start_at,
)
from frictool.prove.axis_enclosure import (
    AT_REST,
    Ambiguous,
    AxisSet,
    PlantBox,
    advanced,
    thresholds,
)
from frictool.prove.interval import RoundedInterval, point
from frictool.prove.still_axis import still_samples
from frictool.typing import Vector

OVERLAP = 1e-10  # encoder counts by which neighbouring parts overlap
FOLLOWED = 40  # samples at the end of a rest over which the drive is computed
MOST_RUNS = 10_000  # largest number of runs; the remaining starts stay undecided
DRIVE_SLACK = 1e-9  # relative distance of the drive from the breakaway while the axis rests


@dataclass(frozen=True)
class LoopOfPlant:
    """Sampled loop of one plant, with the controller in one number format.

    - running: compiled program of the controller, not yet started
    - reference: one value per sample (n,) [rad | m]
    - delay: delay of the command [samples]
    - encoder_step: encoder step [rad | m]
    - start: initial position [rad | m]; the proof is valid for every initial position with the same
      encoder count
    - travel: positions of the end stops [rad | m]; a run that may reach an end stop is not proved
    """

    plant: PlantBox
    running: CompiledProgram
    reference: Vector
    delay: int
    encoder_step: float
    start: float
    travel: tuple[float, float]


@dataclass(frozen=True)
class PhaseRun:
    """Runs from the starts [low, high] [rad | m], with equal readings and commands at every sample.

    - position: readings of the encoder (n,) [rad | m]
    - command: commands of the controller (n,) [A | V]
    - rests: True if the axis is at rest at the end
    - reason: empty if the runs are proved; otherwise the reason why nothing is proved for these
      starts. `position` and `command` then end before the undecided sample
    """

    low: float
    high: float
    position: Vector
    command: Vector
    rests: bool
    reason: str = ""


@dataclass
class _Branch:
    """Runs from the starts [low, high] up to `sample`, with the same readings."""

    low: float
    high: float
    state: AxisSet
    machine: CompiledProgram
    sample: int
    position: Vector
    command: Vector
    known: bool  # True if the command of `sample` is computed
    at: RoundedInterval | None  # displacement at which `reading` was taken at rest
    reading: float
    read: bool = True  # True if the count at `sample` is decided


def phase_runs(loop: LoopOfPlant) -> Iterator[PhaseRun]:
    """Yield the runs from all starts with the encoder count of `loop.start`, lowest start first."""
    step = loop.encoder_step
    count = math.floor(loop.start / step)
    low, high = count * step, (count + 1) * step
    machine = copy_program(loop.running)
    start_at(machine, count * step)
    n = loop.reference.size
    stack = [
        _Branch(
            low, high, AT_REST, machine, 0, np.empty(n), np.empty(n), False, AT_REST.moved,
            count * step,
        )
    ]  # fmt: skip
    made = 0
    while stack:
        branch = stack.pop()
        if made >= MOST_RUNS:
            yield _ended(branch, f"more than {MOST_RUNS} runs")
            continue
        outcome = _followed(loop, branch, stack)
        if outcome is not None:
            made += 1
            yield outcome


def _followed(loop: LoopOfPlant, branch: _Branch, stack: list[_Branch]) -> PhaseRun | None:
    """Continue the runs of a branch to the last sample and return them.

    If the range of starts is divided, its parts are put on the stack and the result is None.
    """
    n = loop.reference.size
    while branch.sample < n:
        k = branch.sample
        if not branch.known:
            resting = branch.state.direction == 0 and branch.state.moved == branch.at
            if not resting and not branch.read:
                parts = _divided(loop, branch)
                if len(parts) > 1:
                    stack += reversed(parts)
                    return None
                branch.reading = parts[0].reading
            branch.at = branch.state.moved if branch.state.direction == 0 else None
            branch.read = False
            branch.position[k] = branch.reading
            branch.command[k] = control_step(branch.machine, loop.reference[k], branch.reading, 0.0)
        branch.known = False
        try:
            if _stays(loop, branch):
                _stand(loop, branch)
            else:
                acting = branch.command[k - loop.delay] if k >= loop.delay else 0.0
                branch.state, *others = advanced(
                    branch.state, float(acting), loop.plant, loop.plant.period
                )
                branch.sample += 1
                for state in others:
                    stack.append(_copy(branch, state=state))
                    _check_travel(loop, stack[-1])
            _check_travel(loop, branch)
        except Ambiguous as reason:
            return _ended(branch, str(reason))
    return _ended(branch, "")


def _copy(branch: _Branch, **changes: Any) -> _Branch:
    return replace(
        branch,
        machine=copy_program(branch.machine),
        position=branch.position.copy(),
        command=branch.command.copy(),
        **changes,
    )


def _ended(branch: _Branch, reason: str) -> PhaseRun:
    return PhaseRun(
        branch.low,
        branch.high,
        branch.position,
        branch.command,
        branch.state.direction == 0 and not reason,
        reason and f"at sample {branch.sample}: {reason}",
    )


def _divided(loop: LoopOfPlant, branch: _Branch) -> list[_Branch]:
    step, moved = loop.encoder_step, branch.state.moved
    overlap = OVERLAP * step
    first = math.floor((branch.low + moved.low - overlap) / step)
    last = math.floor((branch.high + moved.high + overlap) / step)
    parts = []
    for count in range(first, last + 1):
        low = max(branch.low, count * step - moved.high - overlap)
        high = min(branch.high, (count + 1) * step - moved.low + overlap)
        if low <= high:
            parts.append((low, high, count * step))
    if len(parts) == 1:
        branch.reading = parts[0][2]
        return [branch]
    return [
        _copy(branch, low=low, high=high, reading=reading, read=True, at=None)
        for low, high, reading in parts
    ]


def _still_drives(state: AxisSet, p: PlantBox) -> tuple[float, float]:
    """Return the lowest and highest drive [A | V] at which an axis at rest stays at rest."""
    forward, backward = thresholds(state, p)
    upper, lower = forward.low + p.offset.low, p.offset.high - backward.low
    high = upper / (p.constant.high if upper > 0.0 else p.constant.low)
    low = lower / (p.constant.high if lower < 0.0 else p.constant.low)
    slack = DRIVE_SLACK * max(abs(low), abs(high))
    return low + slack, high - slack


def _stays(loop: LoopOfPlant, branch: _Branch) -> bool:
    """Return True if the axis rests and stays at rest under its drive and delayed commands."""
    if branch.state.direction != 0:
        return False
    low, high = _still_drives(branch.state, loop.plant)
    if not (low < branch.state.drive.low and branch.state.drive.high < high):
        return False
    first = max(0, branch.sample - loop.delay)
    waiting = branch.command[first : branch.sample + 1]
    return bool(np.all((low < waiting) & (waiting < high))) and low < 0.0 < high


def _stand(loop: LoopOfPlant, branch: _Branch) -> None:
    """Advance a branch with a resting axis until a command may move the axis, or to the end."""
    k = branch.sample
    reading = branch.reading
    if branch.at is None or branch.state.moved != branch.at:
        # the axis has stopped since the last reading: its count is read at the next sample
        branch.state = _after_rest(loop, branch, k, k + 1)
        branch.sample = k + 1
        return
    bounds = np.array(_still_drives(branch.state, loop.plant))
    end = still_samples(branch.machine, loop.reference, k + 1, reading, bounds, branch.command)
    branch.position[k + 1 : min(end + 1, loop.reference.size)] = reading
    branch.state = _after_rest(loop, branch, k, end)
    branch.sample = end
    branch.known = end < loop.reference.size


def _after_rest(loop: LoopOfPlant, branch: _Branch, first: int, last: int) -> AxisSet:
    """Return the set of states at sample `last` after a rest, in which only the drive changes.

    The drive stays in the smallest interval that contains its initial value and the commands. The
    drive is computed for the last FOLLOWED samples only; before them, this interval is used.
    """
    acting = [float(branch.command[k - loop.delay]) if k >= loop.delay else 0.0
              for k in range(first, last)]  # fmt: skip
    state = branch.state
    if len(acting) > FOLLOWED:
        early = acting[:-FOLLOWED]
        drive = state.drive.hull(RoundedInterval(min(early), max(early)))
        state = replace(state, drive=drive)
        acting = acting[-FOLLOWED:]
    for command in acting:
        (state,) = advanced(state, command, loop.plant, loop.plant.period)  # no stop ends a rest
    return state


def _check_travel(loop: LoopOfPlant, branch: _Branch) -> None:
    state, p = branch.state, loop.plant
    most = (p.constant * point(p.drive_limit)).high + p.offset.magnitude
    reach = (state.speed.magnitude + most / p.inertia.low * loop.plant.period) * loop.plant.period
    low, high = loop.travel
    if (
        branch.low + state.moved.low - reach <= low
        or branch.high + state.moved.high + reach >= high
    ):
        raise Ambiguous("the axis may reach an end stop")
