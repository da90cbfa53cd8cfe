"""Proof of a step test for cells of the parameter box, and the share of the box that is proved.

The axis depends on inertia J, viscous friction sigma, Coulomb friction F and drive constant K
through the ratios K/J, F/J and sigma/J (axis_forms.py); a fourth ratio, the load divided by the
inertia, has the same interval in all cells. A cell is a box of the first three ratios. The search
halves the cells that are not proved. A cell is written as its path from the box of all ratios, with
one letter for each halving: c (K/J), f (F/J) or v (sigma/J) for the lower half, C, F or V for the
upper half. K/J and F/J are halved at their geometric mean, sigma/J at its arithmetic mean.

A hold is an interval of time with a constant reference. A cell is proved if every hold of the
scenario is proved from every position at which the previous hold may end. In a proved hold, the
position stays within the overshoot, and near its final value from the required response time on.
The position ends within the static error and inside the rest band of the controller, where the
drive then stays 0. box_tube.py computes the enclosure of the motion, called a tube.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.spatial import KDTree

from frictool.adapters.axis_model import axis_of
from frictool.adapters.controller_composition import controller_program
from frictool.adapters.parameter_intervals import ranges
from frictool.control.compiled_program import (
    compile_program,
    control_step,
    copy_program,
    start_at,
)
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.metrics.reference_holds import constant_runs
from frictool.metrics.response_time import ZONE
from frictool.prove import axis_forms as ax
from frictool.prove.box_tube import (
    COAST,
    RESIDUE,
    AxisFixed,
    CellRatios,
    StepBounds,
    StepPlan,
    StepStart,
    TubeLoop,
    UnprovedCell,
    step_bounds,
)
from frictool.simulate.reference import parts_of
from frictool.typing import Vector
from frictool.workers.job_sharing import share

BOX_KEYS = ("response_time_95_s", "overshoot_percent", "static_error", "rest")
LETTERS = "cfv"
TAIL = 0.1001  # share of a hold, at the end of the hold, in which the axis must rest
FIRST_SIZE = (0.013, 0.042, 8.8)  # size of the first cells: K/J and F/J relative, sigma/J in 1/s
SMALLEST_PART = 2.0  # encoder counts: intervals of starts are not divided further
WIDEST_PART = 1.5  # longest interval of starts of one tube [rad | m]
# smallest number of samples before a pause; the prefilter may leave the settled range earlier
FIRST_PAUSE = 20
SLACK = 1e-7  # margin of the compared positions [rad | m] and times [s]
ROUND_SIZE = 500  # cells of the search between two estimates of the expected gain
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)
Ends = tuple[float, float]
Box = dict[str, Ends]


@dataclass(frozen=True)
class HoldGoal:
    """Reference and requirements of a hold, that is, of an interval with a constant reference.

    - plan: reference and times of the hold
    - values: values of the controller program's nodes before the hold
    - origin, target: reference before and during the hold
    - overshoot, static, response: limits of the overshoot, the static error and the distance from
      the final value after the response time [rad | m], infinite if not required
    - still: latest time at which the axis must come to rest, measured from the beginning of the
      hold [s]
    """

    plan: StepPlan
    values: Vector
    origin: float
    target: float
    overshoot: float
    static: float
    response: float
    still: float


@dataclass(frozen=True)
class BoxTest:
    """Step test for all plants of a parameter box.

    - loop: sampled loop
    - goals: requirements of each hold
    - start: set of initial states of the first hold
    - box: interval of each parameter
    - load: constant load [N m | N]
    - travel: positions of the end stops [rad | m]
    """

    loop: TubeLoop
    goals: tuple[HoldGoal, ...]
    start: StepStart
    box: Box
    load: float
    travel: Ends


def box_test(model: Model, controller: Controller, scenario: Scenario, spec: Spec) -> BoxTest | str:
    """Return the step test of the parameter box, or the reason why the test cannot be proved."""
    law = controller.position_law
    if (
        controller.structure != "speed_cascade"
        or law is None
        or law.action != "cut"
        or law.kind != "square_root"
        or controller.prefilter is None
        or controller.linear.input != "eta"
        or controller.linear.form == "sos"
        or controller.feedforward is not None
        or controller.friction_compensation is not None
    ):
        return (
            "the proof over the box supports only a speed cascade that has a prefilter and a "
            "square-root position law with `action: cut`"
        )
    axis = axis_of(model)
    if min(axis.coulomb, axis.backlash, axis.lag) <= 0.0 or scenario.start is None:
        return (
            "the proof over the box needs a scenario with a start, and an axis whose Coulomb "
            "friction, backlash and drive lag are above 0"
        )
    if controller.delay_samples > 1 or controller.drive_limit > axis.drive_limit:
        return (
            "the proof over the box needs a delay of at most one sample, and a controller whose "
            "drive limit is at most the limit of the axis"
        )
    program = controller_program(controller)
    fixed = AxisFixed(
        controller.sample_period_s,
        axis.lag,
        axis.backlash_coulomb / axis.coulomb,
        axis.breakaway / axis.coulomb,
        axis.backlash_breakaway / axis.backlash_coulomb,
        axis.backlash,
    )
    loop = TubeLoop(
        program,
        compile_program(program),
        fixed,
        axis.encoder_step,
        controller.delay_samples,
        controller.drive_limit,
        law.band,
    )
    reference = np.concatenate(parts_of(scenario, controller.sample_period_s))
    goals = _goals(loop, reference, scenario.start.value, spec)
    if isinstance(goals, str):
        return goals
    step = axis.encoder_step
    count = math.floor(scenario.start.value / step)
    half = 0.5 * axis.backlash
    start = StepStart((count * step, (count + 1) * step), goals[0].values, ax.GAP, (half, half))
    travel = model.bench.mechanics.travel
    stops = (-math.inf, math.inf) if travel is None else (travel.low, travel.high)
    return BoxTest(loop, goals, start, dict(ranges(model)), axis.offset, stops)


def _goals(
    loop: TubeLoop, reference: Vector, start: float, spec: Spec
) -> tuple[HoldGoal, ...] | str:
    runs = constant_runs(reference)
    if not runs or runs[0][0] != 0 or any(a[1] != b[0] for a, b in itertools.pairwise(runs)):
        return "the proof over the box supports only a piecewise constant reference"
    machine = copy_program(loop.compiled)
    count = math.floor(start / loop.step)
    start_at(machine, count * loop.step)
    origin = count * loop.step
    goals = []
    for first, last, target in runs:
        values = machine.real.copy()
        tracked = np.empty(last - first)
        settled = np.empty(last - first, dtype=bool)
        resting = machine.real[loop.names["settled_speed"]]
        for k in range(last - first):
            control_step(machine, target, target, 0.0)
            tracked[k] = machine.real[loop.names["filtered"]]
            settled[k] = abs(machine.real[loop.names["filtered_speed"]]) < resting
        moving = np.flatnonzero(~settled)
        length = (last - first) * loop.axis.period
        if moving.size == 0 or moving[-1] + 1 + COAST[-1] >= last - first:
            return "the prefilter does not settle while the reference is constant"
        decay = loop.limit * math.exp(-TAIL * length / loop.axis.lag)
        if decay > RESIDUE or last - first < 100:
            return "an interval of constant reference is too short for the drive to become 0"
        rest = int(moving[-1]) + 1
        limit = spec.response_time_95_s
        response = rest
        if limit is not None:
            response = math.floor(limit / loop.axis.period * (1.0 - 1e-12))
            response = min(response, rest)
        leaves = [k for k in range(FIRST_PAUSE, rest) if settled[k - 1] and not settled[k]]
        pause = leaves[-1] if leaves and leaves[-1] <= response else 0
        amplitude = abs(target - origin)
        static = spec.static_error
        goals.append(
            HoldGoal(
                StepPlan(
                    np.full(rest + COAST[-1], target),
                    response,
                    pause,
                    rest,
                    (float(tracked[rest:].min()), float(tracked[rest:].max())),
                ),
                values,
                origin,
                target,
                math.inf
                if spec.overshoot_percent is None
                else 0.01 * spec.overshoot_percent * amplitude,
                math.inf if static is None else static.value,
                math.inf if limit is None else ZONE * amplitude,
                _latest_rest(spec, length),
            )
        )
        origin = target
    return tuple(goals)


def _latest_rest(spec: Spec, length: float) -> float:
    """Return the latest time [s] at which the axis must come to rest in a hold of `length` [s].

    The time follows from the requirements of the static error and of rest.
    """
    latest = (1.0 - TAIL) * length
    if spec.rest is None or length < spec.rest.after_s:
        return latest
    return min(latest, float(spec.rest.after_s))


def prove_cell(test: BoxTest, ratios: CellRatios) -> None:
    """Prove all holds of the step test for a cell; raise UnprovedCell if a hold is not proved."""
    start = test.start
    for index, goal in enumerate(test.goals):
        parts = [start]
        ends: list[StepBounds] = []
        while parts:
            part = parts.pop()
            try:
                found = _hold(test, ratios, part, goal)
            except UnprovedCell:
                smaller = _divided(part, test.loop.step)
                if not smaller:
                    raise
                parts += smaller
            else:
                ends += found
        if index + 1 < len(test.goals):
            start = _next_start(test, test.goals[index + 1], goal, ends)


def _hold(test: BoxTest, ratios: CellRatios, start: StepStart, goal: HoldGoal) -> list[StepBounds]:
    if start.position[1] - start.position[0] > WIDEST_PART:
        raise UnprovedCell(f"the initial positions span more than {WIDEST_PART} rad or m")
    found = step_bounds(test.loop, ratios, start, goal.plan)
    for one in found:
        _check(test, goal, one)
    return found


def _divided(start: StepStart, step: float) -> list[StepStart]:
    """Return the halves of a set of starts, divided by position or by contact position."""
    low, high = start.position
    widths = (high - low, start.far[1] - start.far[0])
    if max(widths) <= SMALLEST_PART * step * (1.0 + 1e-9):
        return []
    if widths[0] >= widths[1]:
        middle = 0.5 * (low + high)
        parts = [replace(start, position=part) for part in ((low, middle), (middle, high))]
    else:
        middle = 0.5 * (start.far[0] + start.far[1])
        parts = [
            replace(start, far=part) for part in ((start.far[0], middle), (middle, start.far[1]))
        ]
    return [bounded for part in parts if (bounded := _bounded(part)) is not None]


def _bounded(start: StepStart) -> StepStart | None:
    """Return the starts whose contact is on the correct side of the axis; None if there is none."""
    low, high = start.far
    if start.contact == ax.IN_FRONT:
        low = max(low, start.position[0])
    elif start.contact == ax.BEHIND:
        high = min(high, start.position[1])
    return replace(start, far=(low, high)) if low <= high else None


def _next_start(
    test: BoxTest, following: HoldGoal, goal: HoldGoal, ends: list[StepBounds]
) -> StepStart:
    """Return the start of the hold `following`, at the final positions and contact of `goal`."""
    low = min(one.final[0] for one in ends)
    high = max(one.final[1] for one in ends)
    forward = goal.target > goal.origin
    known = (ax.FORWARD, ax.IN_FRONT) if forward else (ax.BACKWARD, ax.BEHIND)
    reach = (0.0, test.loop.axis.backlash)
    if not all(one.contact in known for one in ends):
        return StepStart((low, high), following.values, ax.ANY, reach)
    fars = [one.far for one in ends if one.contact == known[1]]
    far = (low, max([*fars, high])) if forward else (min([*fars, low]), high)
    return StepStart((low, high), following.values, known[1], reach, far)


def _check(test: BoxTest, goal: HoldGoal, bounds: StepBounds) -> None:
    """Raise UnprovedCell if the bounds of a hold do not prove its requirements.

    An encoder reading is at most the position, and is larger than the position minus one encoder
    step.
    """
    step, plan = test.loop.step, goal.plan
    low, high = bounds.passed[0] - step - SLACK, bounds.passed[1] + SLACK
    over = high - goal.target if goal.target > goal.origin else goal.target - low
    first, last = _count(bounds.final[0], step), bounds.final[1] + SLACK
    late = _count(bounds.late[0], step), bounds.late[1] + SLACK
    band = test.loop.band - SLACK
    stops = test.travel
    for name, is_met in (
        ("end stop", stops[0] < bounds.reached[0] and bounds.reached[1] < stops[1]),
        ("rest", bounds.still + SLACK <= goal.still),
        ("overshoot", over <= goal.overshoot),
        ("static error", max(last - goal.target, goal.target - first) <= goal.static),
        ("band", plan.tracked[1] - band <= late[0] and late[1] <= plan.tracked[0] + band),
        ("response time", bounds.error + step + SLACK <= goal.response),
    ):
        if not is_met:
            raise UnprovedCell(name)


def _count(position: float, step: float) -> float:
    """Return a lower bound of the encoder reading at a position."""
    return math.floor((position - SLACK) / step) * step - SLACK


def first_cells(test: BoxTest) -> list[str]:
    """Return the paths of the cells with which the search begins.

    The cells are sorted from the middle of the range of F/J outwards.
    """
    friction = root(test)[1]
    middle = math.sqrt(friction[0] * friction[1])
    queue, cells = [""], []
    while queue:
        path = queue.pop()
        if max(sizes(test, path)) > 1.0:
            queue += halves(test, path)
        elif share_of(test, path) > 0.0:
            low, high = intervals_of(test, path)[1]
            cells.append((abs(math.log(math.sqrt(low * high) / middle)), path))
    return [path for _, path in sorted(cells)]


def is_proved(test: BoxTest, path: str) -> bool:
    """Return True if the enclosure of box_tube.py proves the cell at `path`."""
    try:
        prove_cell(test, ratios_of(test, path))
    except UnprovedCell:
        return False
    return True


def is_partition(test: BoxTest, cells: Sequence[str]) -> bool:
    """Return True if the search can create a cell at each path, and no cell contains another."""
    for path in cells:
        for k in range(len(path)):
            if path[: k + 1] not in halves(test, path[:k]):
                return False
    ordered = sorted(cells)
    return not any(b.startswith(a) for a, b in itertools.pairwise(ordered))


def search(
    test: BoxTest,
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
    cores: int | None = None,
) -> tuple[str, ...]:
    """Return the paths of the cells that are proved within `seconds`.

    The search begins with `first_cells` and continues with the halves of cells that are not proved;
    the halves with the largest expected gain come first. progress(f) is called with the completed
    fraction f (0 to 1).

    - cores: number of processes that share the cells, by default one for each core
    """
    begin = time.monotonic()
    cells = first_cells(test)
    waiting: dict[str, Vector] = {}  # cell -> position, size and share of the volume
    proved: list[str] = []
    while cells and time.monotonic() - begin < seconds:
        for index, is_met in share(partial(is_proved, test), cells, cores=cores, batch=4):
            if is_met:
                proved.append(cells[index])
            else:
                parts = [half for half in halves(test, cells[index]) if share_of(test, half) > 0.0]
                waiting.update((half, _position_and_size(test, half)) for half in parts)
            spent = time.monotonic() - begin
            progress(min(1.0, spent / seconds))
            if spent >= seconds:
                break
        cells = _largest_gains(test, waiting, proved)
        for path in cells:
            del waiting[path]
    progress(1.0)
    return tuple(sorted(proved))


def _largest_gains(test: BoxTest, waiting: dict[str, Vector], proved: list[str]) -> list[str]:
    """Return the ROUND_SIZE cells with the largest expected gain.

    A cell next to a proved cell is more likely to be proved. The expected gain is the volume of the
    cell times exp(-d); d is the distance to the nearest proved cell, divided by the size of the
    cell.
    """
    if not waiting or not proved:
        return list(waiting)[:ROUND_SIZE]
    columns = np.array(list(waiting.values()))
    near = KDTree([_position_and_size(test, path)[:3] for path in proved])
    gain = columns[:, 4] * np.exp(-near.query(columns[:, :3])[0] / columns[:, 3])
    paths = list(waiting)
    return [paths[index] for index in np.argsort(-gain, kind="stable")[:ROUND_SIZE]]


def _position_and_size(test: BoxTest, path: str) -> Vector:
    """Return an array (5,) that describes the cell at `path`.

    The first three numbers are the middle of the cell, the fourth is its largest side, all in units
    of FIRST_SIZE. The last number is the cell's share of the box.
    """
    ratio, friction, viscous = intervals_of(test, path)
    middle = (0.5 * math.log(ratio[0] * ratio[1]), 0.5 * math.log(friction[0] * friction[1]))
    place = np.array([*middle, 0.5 * (viscous[0] + viscous[1])]) / FIRST_SIZE
    return np.array([*place, max(sizes(test, path)), share_of(test, path)])


def prove_cells(
    test: BoxTest,
    cells: Sequence[str],
    progress: Callable[[float], None] = lambda _: None,
    cores: int | None = None,
) -> tuple[str, ...]:
    """Prove the listed cells again, and return the paths of the cells that are proved.

    The result is empty if the cells overlap or are not cells of the search. progress(f) is called
    with the completed fraction f (0 to 1).
    """
    if not is_partition(test, cells):
        return ()
    proved = []
    for done, (index, is_met) in enumerate(
        share(partial(is_proved, test), cells, cores=cores, batch=4), start=1
    ):
        progress(done / len(cells))
        if is_met:
            proved.append(cells[index])
    return tuple(sorted(proved))


def total_share(test: BoxTest, cells: Iterable[str]) -> float:
    """Return the share of the box's volume (0 to 1) that the disjoint `cells` cover."""
    return math.fsum(share_of(test, path) for path in cells)


def root(test: BoxTest) -> tuple[Ends, Ends, Ends]:
    """Return the intervals of K/J, F/J and sigma/J for the whole parameter box."""
    low, high = test.box["inertia"]
    constant, coulomb, viscous = (test.box[name] for name in ("constant", "coulomb", "viscous"))
    return (
        (constant[0] / high, constant[1] / low),
        (coulomb[0] / high, coulomb[1] / low),
        (viscous[0] / high, viscous[1] / low),
    )


def intervals_of(test: BoxTest, path: str) -> tuple[Ends, Ends, Ends]:
    """Return the intervals of K/J, F/J and sigma/J of the cell at `path`."""
    sides = list(root(test))
    for letter in path:
        index = LETTERS.index(letter.lower())
        low, high = sides[index]
        middle = 0.5 * (low + high) if index == 2 else math.sqrt(low * high)
        sides[index] = (middle, high) if letter.isupper() else (low, middle)
    return sides[0], sides[1], sides[2]


def ratios_of(test: BoxTest, path: str) -> CellRatios:
    """Return the parameter ratios of the cell at `path`, widened by the rounding errors."""
    low, high = test.box["inertia"]
    loads = sorted((test.load / low, test.load / high))
    wide = [(a * (1.0 - 1e-12), b * (1.0 + 1e-12)) for a, b in intervals_of(test, path)]
    margin = 1e-12 * max(map(abs, loads))
    ratio, friction, viscous = wide
    return CellRatios(ratio, friction, viscous, (loads[0] - margin, loads[1] + margin))


def halves(test: BoxTest, path: str) -> Iterator[str]:
    """Yield the paths of both halves of a cell, divided along the largest of its `sizes`."""
    relative = sizes(test, path)
    letter = LETTERS[relative.index(max(relative))]
    yield path + letter
    yield path + letter.upper()


def sizes(test: BoxTest, path: str) -> tuple[float, float, float]:
    """Return the sizes of a cell in K/J, F/J and sigma/J, relative to FIRST_SIZE."""
    ratio, friction, viscous = intervals_of(test, path)
    return (
        math.log(ratio[1] / ratio[0]) / FIRST_SIZE[0],
        math.log(friction[1] / friction[0]) / FIRST_SIZE[1],
        (viscous[1] - viscous[0]) / FIRST_SIZE[2],
    )


def share_of(test: BoxTest, path: str) -> float:
    """Return the share of the volume of the box (J, sigma, F, K) that the cell at `path` covers.

    For a fixed J, the cell is a box in (sigma, F, K), whose sides are piecewise linear in J. The
    integral over J is exact with Gauss's rule between the values of J at which the slope of a side
    changes.
    """
    ratio, friction, viscous = intervals_of(test, path)
    low, high = test.box["inertia"]
    sides = [
        (test.box["constant"], ratio),
        (test.box["coulomb"], friction),
        (test.box["viscous"], viscous),
    ]
    kinks = {low, high}
    for ends, cell in sides:
        kinks |= {end / value for end in ends for value in cell if value > 0.0}
    points = sorted(point for point in kinks if low <= point <= high)
    total = 0.0
    for left, right in itertools.pairwise(points):
        j = 0.5 * (left + right) + 0.5 * (right - left) * GAUSS_NODES
        product = np.ones_like(j)
        for ends, cell in sides:
            covered = np.minimum(ends[1], cell[1] * j) - np.maximum(ends[0], cell[0] * j)
            product *= np.maximum(covered, 0.0) / (ends[1] - ends[0])
        total += 0.5 * (right - left) * float(GAUSS_WEIGHTS @ product)
    return total / (high - low)
