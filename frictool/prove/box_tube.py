"""Tube of a step: enclosure of the motion of all plants of a cell of parameters, sample by sample.

The tube consists of affine forms (affine_forms.py) of position, speed, drive and controller states.
The encoder's reading is the position minus half a count, plus an independent error of half a count
at each sample. Before the first motion, the reading is known. If it is uncertain whether the axis
is inside the rest band of the controller, the tube branches: the axis is inside the band in one
branch, and outside in the other.

At the peak of its overshoot, the prefilter counts as settled for some samples. If the controller is
then in its rest band, the controller's states are numbers, not sets. At such a sample the
generators of position, speed and drive are joined (`_join`).

After the last motion of the prefilter in the hold, the drive is 0, and friction stops the axis. The
final position follows from a polygon around the pairs of position and speed. Let d be the least
deceleration by friction and load: an axis with the speed v moves on by at most v^2/(2 d).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frictool.control.compiled_program import OUTPUT, USED, CompiledProgram
from frictool.control.program import Program
from frictool.prove import axis_forms as ax
from frictool.prove.affine_forms import (
    GROWTH,
    Forms,
    assign,
    combine,
    copy_forms,
    copy_row,
    empty_forms,
    highest,
    lowest,
    measure,
    radius,
    reduce_forms,
    release,
)
from frictool.prove.axis_forms import AxisCell
from frictool.prove.controller_forms import DECIDED, ControllerRows, run_program, update_states
from frictool.runtime.kernels import kernel, summing_kernel
from frictool.typing import IntVector, Matrix, Vector

MOST = 700  # largest number of generators
KEEP = 350  # generators after a reduction
SPARE = 60  # generators that a sample may add
MOST_BRANCHES = 40
COAST = (3, 5, 7, 12)  # samples after the prefilter's last motion at which `coast` is tried
SECTORS = 24  # directions of the joined generators
DIRECTIONS = 32
SPEED_SCALE = 0.01  # 1/speed: the polygon's edges are regular for position and scaled speed
WIDEST = 5.0  # half width of the position [rad | m] beyond which a tube is given up
RESIDUE = 1e-9  # bound of |drive| at the beginning of a hold [A | V]
DONE, FULL, UNBOUNDED = -1, -2, -3
NODES, WEIGHTS = np.polynomial.legendre.leggauss(14)
Y_LOW, Y_HIGH, BOTTOM, TOP = range(4)  # position at a sample, and until the next sample
RECORD = 4
LOW, HIGH, ERROR = range(3)


@kernel
def run_samples(
    f: Forms,
    c: ControllerRows,
    cell: AxisCell,
    m: Vector,
    reference: Vector,
    span: IntVector,
    step: float,
    delay: int,
    limit: float,
    rows: IntVector,
    record: Matrix,
    past: Forms,
    score: Vector,
) -> int:
    """Extend the enclosure (tube) over the samples span[0] to span[1] - 1; update span[0].

    - span[2]: assumption if it is uncertain whether the axis is inside the rest band: 1 inside, 0
      outside, -1 no assumption, so that the run ends
    - span[3]: first sample whose position is stored in `past`; from then on no generator is removed
    - m: numbers that describe the motion (axis_forms.py)
    - reference (n,): reference at each sample [rad | m]
    - step: encoder step [rad | m]
    - delay: delay of the command [samples]
    - limit: drive limit [A | V]
    - rows: rows that keep values between samples
    - record (n, 4): bounds of the position at each sample, and from each sample to the next

    Returns DONE, FULL (no generator is free), UNBOUNDED (the position is too uncertain), or the row
    of an uncertain band condition.
    """
    o = c.scratch + 1
    while span[0] < span[1]:
        k = span[0]
        if f.size[0] > f.gen.shape[1] - SPARE:
            if k >= span[3]:
                return FULL
            reduce_forms(f, rows, ax.FIXED, KEEP, score)
            for t in range(rows.shape[0]):
                release(f, rows[t], ax.NEGLIGIBLE)
        assign(f, c.ports[USED], reference[k])
        assign(f, c.ports[0], reference[k])
        position = c.ports[USED + 1]
        if m[ax.AT_REST] == 1.0:
            copy_row(f, position, o + ax.READ)
        else:
            low = math.floor(lowest(f, o + ax.Y) / step - 1e-9) * step
            high = math.floor(highest(f, o + ax.Y) / step + 1e-9) * step
            m[ax.COUNT_LOW] = max(low, m[ax.COUNT_LOW])
            m[ax.COUNT_HIGH] = min(high, m[ax.COUNT_HIGH])
            combine(f, position, 1.0, o + ax.Y, 0.0, o + ax.Y, -0.5 * step, 0.5 * step)
            release(f, position, 0.0)
            f.low[position] = m[ax.COUNT_LOW]
            f.high[position] = m[ax.COUNT_HIGH]
        copy_row(f, c.ports[1], position)
        band = run_program(f, c, limit, span[2])
        if band != DECIDED:
            return band
        record[k, Y_LOW] = lowest(f, o + ax.Y)
        record[k, Y_HIGH] = highest(f, o + ax.Y)
        if k >= span[3]:
            row = k - span[3]
            past.center[row] = f.center[o + ax.Y]
            past.error[row] = f.error[o + ax.Y]
            past.extent[row] = f.extent[o + ax.Y]
            for j in range(f.extent[o + ax.Y]):
                past.gen[row, j] = f.gen[o + ax.Y, j]
        if delay == 0:
            copy_row(f, o + ax.ACTING, c.ports[OUTPUT])
        else:
            copy_row(f, o + ax.ACTING, o + ax.PENDING)
            copy_row(f, o + ax.PENDING, c.ports[OUTPUT])
        update_states(f, c)
        for t in range(rows.shape[0]):
            release(f, rows[t], ax.NEGLIGIBLE)
        ax.advance(f, o, cell, m)
        record[k, BOTTOM] = lowest(f, o + ax.Y) - cell.period * max(0.0, m[ax.SPEED_HIGH])
        record[k, TOP] = highest(f, o + ax.Y) - cell.period * min(0.0, m[ax.SPEED_LOW])
        if m[ax.AT_REST] == 0.0:
            if m[ax.SPEED_LOW] < 0.0:
                m[ax.COUNT_LOW] = -np.inf
            if m[ax.SPEED_HIGH] > 0.0:
                m[ax.COUNT_HIGH] = np.inf
        span[0] = k + 1
        if not radius(f, o + ax.Y) < WIDEST:
            return UNBOUNDED
    return DONE


@summing_kernel
def _magnitude(a: float, x: Vector, b: float, y: Vector) -> float:
    """Return the sum of |a x + b y| over the components of x and y, (n,) each."""
    total = 0.0
    for j in range(x.shape[0]):
        total += abs(a * x[j] + b * y[j])
    return total


@kernel
def coast(f: Forms, o: int, stop: Vector, past: Forms, count: int, bounds: Vector) -> None:
    """Bound the final position of an axis without drive, and the distance to earlier positions.

    - stop (3,): additional speed due to the decaying drive [rad/s | m/s], and least deceleration in
      forward and in backward motion [rad/s^2 | m/s^2]
    - past: forms of the position at `count` earlier samples
    - bounds: array for the results [rad | m], the final position's bounds at the indices LOW and
      HIGH, and the largest distance at the index ERROR
    """
    bounds[LOW] = np.inf
    bounds[HIGH] = -np.inf
    bounds[ERROR] = 0.0
    size = f.size[0]
    support = np.empty(DIRECTIONS)
    y = np.empty(size)
    v = np.zeros(size)
    for g in range(f.extent[o + ax.V]):
        v[g] = f.gen[o + ax.V, g]
    for k in range(-1, count):
        for g in range(size):
            y[g] = f.gen[o + ax.Y, g] if g < f.extent[o + ax.Y] else 0.0
            if k >= 0 and g < past.extent[k]:
                y[g] -= past.gen[k, g]
        for j in range(DIRECTIONS // 2):  # each direction together with its opposite
            cos = math.cos(2.0 * math.pi * j / DIRECTIONS)
            sin = math.sin(2.0 * math.pi * j / DIRECTIONS) * SPEED_SCALE
            total = abs(cos) * f.error[o + ax.Y] + abs(sin) * f.error[o + ax.V]
            center = cos * f.center[o + ax.Y] + sin * f.center[o + ax.V]
            if k >= 0:
                center -= cos * past.center[k]
                total += abs(cos) * past.error[k]
            half = (total + _magnitude(cos, y, sin, v)) * GROWTH + 1e-9
            support[j] = center + half
            support[j + DIRECTIONS // 2] = half - center
        for j in range(DIRECTIONS):
            a = 2.0 * math.pi * j / DIRECTIONS
            b = 2.0 * math.pi * (j + 1) / DIRECTIONS
            h, i = support[j], support[(j + 1) % DIRECTIONS]
            det = math.sin(b - a)
            place = (h * math.sin(b) - i * math.sin(a)) / det
            speed = (i * math.cos(a) - h * math.cos(b)) / (det * SPEED_SCALE)
            forward = max(0.0, speed) + stop[0]
            backward = max(0.0, -speed) + stop[0]
            up = place + 0.5 * forward * forward / stop[1] + 1e-8
            down = place - 0.5 * backward * backward / stop[2] - 1e-8
            if k < 0:
                bounds[HIGH] = max(bounds[HIGH], up)
                bounds[LOW] = min(bounds[LOW], down)
            else:
                bounds[ERROR] = max(bounds[ERROR], up, -down)


@dataclass(frozen=True)
class CellRatios:
    """Parameter ratios of a cell, as intervals (low, high).

    - ratio: drive constant over inertia [rad/s^2 or m/s^2 per A or V]
    - friction: Coulomb friction over inertia [rad/s^2 | m/s^2]
    - viscous: viscous friction over inertia [1/s]
    - offset: constant load over inertia [rad/s^2 | m/s^2]
    """

    ratio: tuple[float, float]
    friction: tuple[float, float]
    viscous: tuple[float, float]
    offset: tuple[float, float]


@dataclass(frozen=True)
class AxisFixed:
    """Properties of the axis that all plants of the box share; AxisCell explains the names."""

    period: float
    lag: float
    gap_share: float
    breakaway: float
    gap_breakaway: float
    backlash: float

    def cell(self, ratios: CellRatios) -> AxisCell:
        """Return the constants of the axis for the cell with the parameter `ratios`."""
        first = self.lag * (1.0 - math.exp(-self.period / self.lag))
        second = self.lag * (self.period - first)
        return AxisCell(
            self.period,
            self.lag,
            *ratios.ratio,
            *ratios.friction,
            ratios.viscous[1],
            *ratios.offset,
            self.gap_share,
            self.breakaway,
            self.gap_breakaway,
            self.backlash,
            first,
            second - 0.5 * self.period * first,
        )


@dataclass(frozen=True)
class TubeLoop:
    """Sampled loop with the properties of the axis that all plants of the box share.

    - step: encoder step [rad | m]
    - delay: delay of the command [samples]
    - limit: drive limit [A | V]
    - band: half-width of the controller's rest band [rad | m]
    """

    program: Program
    compiled: CompiledProgram
    axis: AxisFixed
    step: float
    delay: int
    limit: float
    band: float

    @cached_property
    def names(self) -> dict[str, int]:
        """Return a dictionary from the name of a program node to its row in the table of forms."""
        return {name: index for index, name in self.program.names.items()}

    @cached_property
    def rows(self) -> ControllerRows:
        """Return the controller's program and the rows that the enclosure treats separately."""
        compiled, names = self.compiled, self.names
        states = compiled.writes.shape[0]
        first = compiled.real.size - states
        nodes = self.program.nodes
        return ControllerRows(
            compiled.code,
            compiled.terms,
            compiled.writes,
            compiled.ports,
            nodes[names["mode_now"]].args[0].index,
            names["eta"],
            names["change"],
            names["linear_drive"],
            first,
            first + 1,
            first + 1 + states,
        )

    @cached_property
    def first(self) -> int:
        """Return the row of the axis's first quantity in the table of forms."""
        return self.rows.scratch + 1

    @cached_property
    def position_before(self) -> int:
        """Return the row of the encoder reading at the last sample."""
        return self.program.states["position_before"].index

    @cached_property
    def states(self) -> tuple[int, ...]:
        """Return the rows of the controller's states, except the last encoder reading."""
        rows = (int(row) for row in self.compiled.writes[:, 0])
        return tuple(row for row in rows if row != self.position_before)

    @cached_property
    def kept(self) -> IntVector:
        """Return the rows of controller and axis that keep values from one sample to the next."""
        axis = (ax.Y, ax.V, ax.DRIVE, ax.ACTING, ax.PENDING, ax.READ)
        own = (self.position_before, self.rows.drive_before)
        return np.array([*self.states, *own, *(self.first + row for row in axis)])


@dataclass(frozen=True)
class StepStart:
    """Set of starts of a step, with the axis at rest.

    - position: interval of the axis position [rad | m]
    - values: values of the controller program's nodes
    - contact: contact with the load, one of the constants ANY to BEHIND of axis_forms.py
    - reach: least and largest distance to the contact in the direction of motion [rad | m]; in
      both directions if the contact is GAP
    - far: interval of the position of the contact [rad | m], if `contact` is IN_FRONT or BEHIND
    """

    position: tuple[float, float]
    values: Vector
    contact: int
    reach: tuple[float, float]
    far: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class StepPlan:
    """Reference of a step, and important samples, counted from the beginning of the step.

    - reference: one value per sample (n,) [rad | m]
    - response: first sample at which the position has to stay near its final value
    - pause: last sample, at most `response`, at which a settled prefilter starts to move again; 0
      if there is no such sample
    - settled: first sample after the last motion of the prefilter
    - tracked: least and largest filtered reference at the samples k >= settled [rad | m]
    """

    reference: Vector
    response: int
    pause: int
    settled: int
    tracked: tuple[float, float]


@dataclass(frozen=True)
class StepBounds:
    """Bounds of a step for all plants of a cell; positions as (low, high) in rad | m.

    - final: final position
    - passed: position at the samples of the step
    - reached: position at all times
    - late: position at the samples from `settled` on
    - error: largest distance of the position from its final value, from `response` on
    - still: time from the beginning of the step to rest [s]
    - contact, far: contact with the load at the end of the step, as in StepStart
    - positions (n, 2): least and largest position at each sample

    `settled` and `response` are fields of StepPlan.
    """

    final: tuple[float, float]
    passed: tuple[float, float]
    reached: tuple[float, float]
    late: tuple[float, float]
    error: float
    still: float
    contact: int
    far: float
    positions: Matrix


class UnprovedCell(Exception):
    """Error: the enclosure does not prove a cell; the message is the reason."""


@dataclass
class _Tube:
    forms: Forms
    motion: Vector
    record: Matrix
    past: Forms
    sample: int = 0

    def copy(self) -> _Tube:
        return _Tube(
            copy_forms(self.forms),
            self.motion.copy(),
            self.record.copy(),
            copy_forms(self.past, whole=True),
            self.sample,
        )


def step_bounds(
    loop: TubeLoop, ratios: CellRatios, start: StepStart, plan: StepPlan
) -> list[StepBounds]:
    """Return the bounds of a step for each branch of the tube.

    Raises UnprovedCell if the enclosure becomes too wide, or does not show that the axis stops.
    """
    cell = loop.axis.cell(ratios)
    stack = [_started(loop, ratios, start, plan)]
    arrived: list[_Tube] = []
    first = plan.pause or plan.settled
    branches = 0
    while stack:
        tube = stack.pop()
        if _follow(loop, cell, tube, plan, first) == DONE:
            arrived.append(tube)
            continue
        branches += 1
        if branches > MOST_BRANCHES:
            raise UnprovedCell("too many branches of the tube at the rest band")
        stack += (_branch(loop, cell, tube.copy(), plan, inside) for inside in (0, 1))
    return [_finish(loop, cell, ratios, tube, plan) for tube in arrived]


def _started(loop: TubeLoop, ratios: CellRatios, start: StepStart, plan: StepPlan) -> _Tube:
    o = loop.first
    f = empty_forms(o + ax.ROWS, MOST)
    f.center[: loop.rows.drive_before] = start.values[: loop.rows.drive_before]
    f.size[0] = ax.FIXED
    f.error[o + ax.DRIVE] = RESIDUE
    for row, (low, high), column in (
        (ax.RATIO, ratios.ratio, ax.RATIO_COLUMN),
        (ax.FRICTION, ratios.friction, ax.FRICTION_COLUMN),
        (ax.VISCOUS, ratios.viscous, ax.VISCOUS_COLUMN),
        (ax.OFFSET, ratios.offset, ax.OFFSET_COLUMN),
        (ax.Y, start.position, ax.POSITION_COLUMN),
    ):
        f.center[o + row] = 0.5 * (low + high)
        f.gen[o + row, column] = 0.5 * (high - low) * GROWTH
        f.extent[o + row] = column + 1
    step = loop.step
    count = math.floor(start.position[0] / step + 1e-9)
    for row in (o + ax.READ, loop.position_before):
        if start.position[1] <= (count + 1 + 1e-9) * step:
            f.center[row] = count * step
            continue
        f.center[row] = f.center[o + ax.Y] - 0.5 * step
        f.gen[row, ax.POSITION_COLUMN] = f.gen[o + ax.Y, ax.POSITION_COLUMN]
        f.gen[row, ax.READING_COLUMN] = 0.5 * step * GROWTH
        f.extent[row] = ax.FIXED
    measure(f, np.arange(f.center.size))
    m = np.zeros(ax.MOTION)
    m[ax.AT_REST] = 1.0
    m[ax.CONTACT] = start.contact
    m[ax.COUNT_LOW], m[ax.COUNT_HIGH] = -np.inf, np.inf
    m[ax.FROM_LOW], m[ax.FROM_HIGH] = start.position
    m[ax.REACH_LOW], m[ax.REACH_HIGH] = start.reach
    if start.contact == ax.IN_FRONT:  # the opposite contact is one backlash behind `contact`
        m[ax.FAR] = start.far[1]
        m[ax.REACH_HIGH] = start.position[0] - start.far[0] + loop.axis.backlash
    elif start.contact == ax.BEHIND:
        m[ax.FAR] = start.far[0]
        m[ax.REACH_HIGH] = start.far[1] - start.position[1] + loop.axis.backlash
    ax.prepare(f, o, loop.axis.cell(ratios), NODES, WEIGHTS)
    samples = plan.settled + COAST[-1]
    record = np.full((samples, RECORD), np.nan)
    return _Tube(f, m, record, empty_forms(samples - plan.response, MOST))


def _follow(
    loop: TubeLoop, cell: AxisCell, tube: _Tube, plan: StepPlan, last: int, choice: int = -1
) -> int:
    span = np.array([tube.sample, last, choice, plan.response])
    status = run_samples(
        tube.forms,
        loop.rows,
        cell,
        tube.motion,
        plan.reference,
        span,
        loop.step,
        loop.delay,
        loop.limit,
        loop.kept,
        tube.record,
        tube.past,
        np.empty(MOST),
    )
    tube.sample = int(span[0])
    if status in (FULL, UNBOUNDED):
        raise UnprovedCell(f"the enclosure becomes too wide at sample {tube.sample}")
    return int(status)


def _branch(loop: TubeLoop, cell: AxisCell, tube: _Tube, plan: StepPlan, inside: int) -> _Tube:
    m = tube.motion
    tracked = tube.forms.center[loop.program.nodes[loop.names["error"]].args[0].index]
    if inside and m[ax.SPEED_LOW] >= 0.0:
        m[ax.COUNT_LOW] = max(m[ax.COUNT_LOW], tracked - loop.band)
    if inside and m[ax.SPEED_HIGH] <= 0.0:
        m[ax.COUNT_HIGH] = min(m[ax.COUNT_HIGH], tracked + loop.band)
    _follow(loop, cell, tube, plan, tube.sample + 1, inside)
    return tube


def _finish(
    loop: TubeLoop, cell: AxisCell, ratios: CellRatios, tube: _Tube, plan: StepPlan
) -> StepBounds:
    o = loop.first
    if plan.pause:
        if tube.motion[ax.AT_REST] == 0.0:
            _join(loop, tube.forms)
        if _follow(loop, cell, tube, plan, plan.settled) != DONE:
            raise UnprovedCell(
                f"unclear whether the axis is in the rest band at sample {tube.sample}"
            )
    bounds = np.array([-np.inf, np.inf, np.inf])
    still = np.inf
    for samples in COAST:
        # inside the band: the caller checks this with the bounds `late`
        if _follow(loop, cell, tube, plan, plan.settled + samples, 1) != DONE:
            raise UnprovedCell(
                f"unclear whether the axis is in the rest band at sample {tube.sample}"
            )
        stop = _stopping(loop, ratios, tube.forms)
        if stop is None:
            continue
        found = np.empty(3)
        coast(tube.forms, o, stop, tube.past, tube.sample - plan.response, found)
        bounds[LOW] = max(bounds[LOW], found[LOW])
        bounds[HIGH] = min(bounds[HIGH], _pushed(ratios, loop.axis, tube.motion, found[HIGH], 1))
        bounds[LOW] = max(bounds[LOW], _pushed(ratios, loop.axis, tube.motion, found[LOW], -1))
        bounds[ERROR] = min(bounds[ERROR], found[ERROR])
        speed = max(-lowest(tube.forms, o + ax.V), highest(tube.forms, o + ax.V)) + stop[0]
        still = min(still, tube.sample * cell.period + speed / min(stop[1], stop[2]))
    record = tube.record
    if not (np.isfinite([*bounds, still]).all() and np.isfinite(record).all()):
        raise UnprovedCell("the released drive may still move the axis")
    low, high = float(bounds[LOW]), float(bounds[HIGH])
    late = record[plan.settled :]
    return StepBounds(
        (low, high),
        (min(low, float(record[:, Y_LOW].min())), max(high, float(record[:, Y_HIGH].max()))),
        (min(low, float(record[:, BOTTOM].min())), max(high, float(record[:, TOP].max()))),
        (min(low, float(late[:, Y_LOW].min())), max(high, float(late[:, Y_HIGH].max()))),
        float(bounds[ERROR]),
        float(still),
        int(tube.motion[ax.CONTACT]),
        float(tube.motion[ax.FAR]),
        record[:, [Y_LOW, Y_HIGH]],
    )


def _stopping(loop: TubeLoop, ratios: CellRatios, f: Forms) -> Vector | None:
    o = loop.first
    for row in (o + ax.ACTING, o + ax.PENDING):
        if f.extent[row] or f.error[row] or f.center[row]:
            return None
    friction = ratios.friction[0] * loop.axis.gap_share
    drive = ratios.ratio[1] * max(-lowest(f, o + ax.DRIVE), highest(f, o + ax.DRIVE))
    forward, backward = friction + ratios.offset[0], friction - ratios.offset[1]
    if drive >= min(forward, backward):
        return None
    return np.array([drive * loop.axis.lag, forward, backward]) * (1.0 + 1e-9, 1 - 1e-9, 1 - 1e-9)


def _pushed(ratios: CellRatios, axis: AxisFixed, m: Vector, end: float, sign: int) -> float:
    """Return a tighter bound of the final position if the axis must push the load to reach `end`.

    Beyond the contact, the axis moves with its load, against a higher friction than inside the
    backlash.
    """
    if m[ax.CONTACT] != (ax.IN_FRONT if sign > 0 else ax.BEHIND) or sign * (end - m[ax.FAR]) <= 0:
        return end
    share = max(
        (axis.gap_share * friction + sign * load) / (friction + sign * load)
        for friction in ratios.friction
        for load in ratios.offset
    )
    return float(m[ax.FAR] + (end - m[ax.FAR]) * share) + sign * 1e-9


def _join(loop: TubeLoop, f: Forms) -> None:
    """Join generators of similar direction in the plane of position and speed.

    The generators are joined only if the states of the controller are numbers. Each generator first
    gets the sign with which it points into the upper half plane. The generators of a sector of
    directions are then replaced by their sum d: each generator is share * d plus a remainder, and
    the remainders become errors.
    """
    if any(f.extent[row] or f.error[row] for row in loop.states):
        return
    o, size = loop.first, int(f.size[0])
    for row in (o + ax.READ, loop.rows.drive_before):
        assign(f, row, 0.0)  # no longer used: the axis moves, and the last drive was 0
    rows = [int(row) for row in loop.kept if f.extent[row] > ax.FIXED]
    for row in rows:
        f.gen[row, f.extent[row] : size] = 0.0
    old = f.gen[rows, ax.FIXED : size]
    y, v = old[rows.index(o + ax.Y)], SPEED_SCALE * old[rows.index(o + ax.V)]
    sign = np.where((v < 0.0) | ((v == 0.0) & (y < 0.0)), -1.0, 1.0)
    old, y, v = old * sign, y * sign, v * sign
    apart = np.hypot(y, v) < 1e-9
    sector = np.minimum((np.arctan2(v, y) * (SECTORS / np.pi)).astype(int), SECTORS - 1)[~apart]
    moved = old[:, ~apart]
    member = np.zeros((sector.size, SECTORS))
    member[np.arange(sector.size), sector] = 1.0
    sums = moved @ member
    dy, dv = (y[~apart] @ member)[sector], (v[~apart] @ member)[sector]
    share = (y[~apart] * dy + v[~apart] * dv) / (dy * dy + dv * dv)
    rest = np.abs(moved - sums[:, sector] * share).sum(axis=1)
    gen = np.hstack([old[:, apart], (sums * (np.abs(share) @ member))[:, member.any(axis=0)]])
    f.size[0] = ax.FIXED + gen.shape[1]
    f.gen[rows, ax.FIXED : f.size[0]] = gen
    f.extent[rows] = f.size[0]
    f.error[rows] += rest * GROWTH + 1e-12 * np.abs(gen).sum(axis=1)
    measure(f, np.array(rows))
    for row in rows:
        release(f, row, 0.0)
