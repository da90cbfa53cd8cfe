"""One sample of a controller's program on affine forms (affine_forms.py).

Each operation has an enclosure. Linear operations and products are functions of affine_forms.py;
|x|, square root, minimum and maximum are lines with an error; a comparison is 0, 1 or undecided. If
the condition of a selection is undecided, the result is the mean of both values plus an error of
half their largest difference. There are two exceptions:

- eta keeps its value if the last command was limited and the change of eta has the sign of this
  command. The enclosure is eta plus the change, with an error that bounds the omitted change
  (`_largest_held`).
- At the condition of the controller's rest band, the tube branches (box_tube.py).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.control import operation_codes as op
from frictool.control.compiled_program import GUARD_ROWS, Rows
from frictool.prove.affine_forms import (
    ROUND,
    Forms,
    assign,
    combine,
    copy_row,
    generators,
    highest,
    is_number,
    lowest,
    multiply,
    radius,
    release,
    root_bounds,
)
from frictool.runtime.kernels import part_kernel
from frictool.typing import IntVector

DECIDED = -1
NEGLIGIBLE = 1e-6  # share of a radius below which an error does not become a generator


class ControllerRows(NamedTuple):
    """Program of a controller, and the rows that the enclosure treats separately.

    `code`, `terms`, `writes` and `ports` are defined in CompiledProgram. The other fields are rows
    of the table of forms.

    - band: condition that the axis is inside the rest band
    - eta, change: integral eta at this sample, and its change
    - drive: command before the limit
    - drive_before: command of the last sample before the limit
    - next_state: first row of the next values of the states
    - scratch: row for intermediate results
    """

    code: Rows
    terms: Rows
    writes: Rows
    ports: IntVector
    band: int
    eta: int
    change: int
    drive: int
    drive_before: int
    next_state: int
    scratch: int


@part_kernel
def run_program(f: Forms, c: ControllerRows, limit: float, choice: int) -> int:
    """Run one sample of a controller on affine forms.

    - limit: drive limit
    - choice: value to use if the condition of the rest band is undecided; -1 stops the sample
      instead

    Returns DECIDED, or the row of the undecided condition.
    """
    for k in range(c.ports[GUARD_ROWS], c.code.shape[0]):
        operation = c.code[k, 0]
        d, a, b, e = c.code[k, 1], c.code[k, 2], c.code[k, 3], c.code[k, 4]
        if operation == op.DOT:
            _dot(f, c, d, a, b)
        elif operation == op.ADD:
            combine(f, d, 1.0, a, 1.0, b, 0.0, 0.0)
        elif operation == op.SUB:
            combine(f, d, 1.0, a, -1.0, b, 0.0, 0.0)
            if is_number(f, a):
                f.low[d] = _below(f.center[a] - f.high[b])
                f.high[d] = _above(f.center[a] - f.low[b])
        elif operation == op.MUL:
            multiply(f, d, a, b)
        elif operation == op.NEG:
            combine(f, d, -1.0, a, 0.0, a, 0.0, 0.0)
            f.low[d], f.high[d] = -f.high[a], -f.low[a]
        elif operation == op.ABS:
            _absolute(f, d, a)
        elif operation == op.SQRT:
            _root(f, d, a)
        elif operation == op.LT or operation == op.LE:
            _compare(f, d, a, b, operation == op.LT, c.scratch)
        elif operation == op.AND:
            _truth(
                f,
                d,
                min(f.center[a] - f.error[a], f.center[b] - f.error[b]),
                min(f.center[a] + f.error[a], f.center[b] + f.error[b]),
            )
        elif operation == op.OR:
            _truth(
                f,
                d,
                max(f.center[a] - f.error[a], f.center[b] - f.error[b]),
                max(f.center[a] + f.error[a], f.center[b] + f.error[b]),
            )
        elif operation == op.NOT:
            _truth(f, d, 1.0 - f.center[a] - f.error[a], 1.0 - f.center[a] + f.error[a])
        elif operation == op.SELECT:
            _select(f, c, d, a, b, e, limit)
        elif operation == op.MIN:
            _extreme(f, d, a, b, -1.0, c.scratch)
        elif operation == op.MAX:
            _extreme(f, d, a, b, 1.0, c.scratch)
        if d == c.band and f.error[d] > 0.0:
            if choice < 0:
                return int(d)
            assign(f, d, float(choice))
        elif (
            operation == op.SELECT
            or operation == op.MIN
            or operation == op.MAX
            or operation == op.DOT
        ):
            release(f, d, NEGLIGIBLE)
    return DECIDED


@part_kernel
def update_states(f: Forms, c: ControllerRows) -> None:
    """Set the states of the program to their next values."""
    copy_row(f, c.drive_before, c.drive)
    for k in range(c.writes.shape[0]):
        copy_row(f, c.next_state + k, c.writes[k, 1])
    for k in range(c.writes.shape[0]):
        copy_row(f, c.writes[k, 0], c.next_state + k)
        f.low[c.writes[k, 0]] = -np.inf
        f.high[c.writes[k, 0]] = np.inf


@part_kernel
def _below(value: float) -> float:
    return value - ROUND * abs(value) if math.isfinite(value) else value


@part_kernel
def _above(value: float) -> float:
    return value + ROUND * abs(value) if math.isfinite(value) else value


@part_kernel
def _dot(f: Forms, c: ControllerRows, d: int, first: int, last: int) -> None:
    total = f.center[c.terms[first, 0]] * f.center[c.terms[first, 1]]
    extent = 0
    exact = True
    for t in range(first, last):
        x = c.terms[t, 1]
        extent = max(extent, f.extent[x])
        exact = exact and is_number(f, x)
        if t > first:
            total += f.center[c.terms[t, 0]] * f.center[x]
    for j in range(extent):
        f.gen[d, j] = 0.0
    size = 0.0
    width = 0.0
    for t in range(first, last):
        k, x = f.center[c.terms[t, 0]], c.terms[t, 1]
        size += abs(k) * (abs(f.center[x]) + radius(f, x))
        width += abs(k) * f.error[x]
        for j in range(f.extent[x]):
            f.gen[d, j] += k * f.gen[x, j]
    f.center[d] = total
    f.extent[d] = extent
    f.error[d] = 0.0 if exact else width * (1.0 + ROUND) + (last - first) * ROUND * size
    f.spread[d] = generators(f, d) + f.error[d]
    f.low[d] = -np.inf
    f.high[d] = np.inf


@part_kernel
def _absolute(f: Forms, d: int, a: int) -> None:
    low, high = lowest(f, a), highest(f, a)
    if is_number(f, a):
        assign(f, d, abs(f.center[a]))
    elif low >= 0.0:
        copy_row(f, d, a)
    elif high <= 0.0:
        below, above = -f.high[a], -f.low[a]
        combine(f, d, -1.0, a, 0.0, a, 0.0, 0.0)
        f.low[d], f.high[d] = below, above
    else:
        slope = (high + low) / (high - low)
        top = -low - slope * low  # slope x <= |x| <= slope x + top
        combine(f, d, slope, a, 0.0, a, 0.5 * top, 0.5 * top + ROUND * (high - low))
        f.low[d], f.high[d] = 0.0, max(-low, high)


@part_kernel
def _root(f: Forms, d: int, a: int) -> None:
    if is_number(f, a):
        assign(f, d, math.sqrt(max(f.center[a], 0.0)))
        return
    low, high = max(lowest(f, a), 0.0), max(highest(f, a), 1e-300)
    slope, below, above = root_bounds(low, high)
    error = 0.5 * (above - below) + ROUND * (above + math.sqrt(high))
    combine(f, d, slope, a, 0.0, a, 0.5 * (below + above), error)
    f.low[d] = math.sqrt(low) * (1.0 - ROUND)
    f.high[d] = math.sqrt(high) * (1.0 + ROUND)


@part_kernel
def _truth(f: Forms, d: int, low: float, high: float) -> None:
    assign(f, d, 0.5 * (low + high))
    f.error[d] = 0.5 * (high - low)
    f.spread[d] = f.error[d]


@part_kernel
def _compare(f: Forms, d: int, a: int, b: int, strict: bool, scratch: int) -> None:
    combine(f, scratch, 1.0, a, -1.0, b, 0.0, 0.0)
    low = max(lowest(f, scratch), _below(lowest(f, a) - highest(f, b)))
    high = min(highest(f, scratch), _above(highest(f, a) - lowest(f, b)))
    true = high < 0.0 if strict else high <= 0.0
    false = low >= 0.0 if strict else low > 0.0
    _truth(f, d, 1.0 if true else 0.0, 0.0 if false else 1.0)


@part_kernel
def _select(f: Forms, c: ControllerRows, d: int, a: int, b: int, e: int, limit: float) -> None:
    if f.error[a] == 0.0 and f.extent[a] == 0:
        copy_row(f, d, b if f.center[a] != 0.0 else e)
    elif d == c.eta:  # row e is the sum of eta before and its change, row b is eta before
        up = max(0.0, _largest_held(f, c, 1.0, limit))
        down = max(0.0, _largest_held(f, c, -1.0, limit))
        combine(f, d, 1.0, e, 0.0, e, 0.5 * (down - up), 0.5 * (down + up))
    else:
        combine(f, c.scratch, 1.0, b, -1.0, e, 0.0, 0.0)
        half = 0.5 * max(-lowest(f, c.scratch), highest(f, c.scratch))
        combine(f, d, 0.5, b, 0.5, e, 0.0, half)


@part_kernel
def _largest_held(f: Forms, c: ControllerRows, sign: float, limit: float) -> float:
    """Return a bound of sign * (change of eta) for the case sign * (last drive) > limit.

    In this case, sign * change <= sign * change + factor (sign * drive - limit) for every factor >=
    0. For each tried factor, the maximum of the right side is a bound; the smallest of these bounds
    is returned.
    """
    best = np.inf
    for t in range(15):
        factor = 0.0 if t == 0 else 0.5 * 2.0**-t
        combine(f, c.scratch, sign, c.change, sign * factor, c.drive_before, -factor * limit, 0.0)
        best = min(best, highest(f, c.scratch))
    return best


@part_kernel
def _extreme(f: Forms, d: int, a: int, b: int, sign: float, scratch: int) -> None:
    combine(f, scratch, sign, a, -sign, b, 0.0, 0.0)
    low, high = lowest(f, scratch), highest(f, scratch)
    if high <= 0.0:
        copy_row(f, d, b)
    elif low >= 0.0:
        copy_row(f, d, a)
    else:  # b + sign max(0, x), with 0 <= max(0, x) - slope x <= 2 half
        slope = high / (high - low)
        half = -0.5 * slope * low
        error = half + ROUND * (abs(high) + abs(low))
        combine(f, d, slope, a, 1.0 - slope, b, sign * half, error)
