"""Affine forms: sets of values as a centre plus generators, with errors rounded outwards.

A form is the set of all

    center + sum over j of gen[j] e_j + error e,     |e_j| <= 1, |e| <= 1

The e_j are common to all forms, so that forms keep their linear dependence on parameters, initial
position and past encoder errors (Stolfi and de Figueiredo 1997). A generator is the coefficient
gen[j]; e belongs to one form only. A form may have additional bounds `low` and `high`. Each
operation adds ROUND times the sum of the magnitudes of its terms to the error. This exceeds the
rounding errors of the operation in double arithmetic: each rounding error is at most 2^-53 times
the magnitude of a term.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.runtime.kernels import bare_kernel, part_kernel, summing_kernel
from frictool.typing import IntVector, Matrix, Vector

ROUND = 1e-14
GROWTH = 1.0 + 1e-12  # factor on a radius: more than the rounding errors of a sum of 4000 terms


class Forms(NamedTuple):
    """Table of affine forms (module docstring), one per row.

    - center (n,), gen (n, generators), error (n,): as in the module docstring
    - extent (n,): number of columns of `gen` that belong to a row; the other columns count as 0
    - spread (n,): sum of the magnitudes of a row's generators, plus the row's error; each operation
      updates it
    - low, high (n,): additional bounds of the values
    - size (1,): number of generators in use
    """

    center: Vector
    gen: Matrix
    error: Vector
    extent: IntVector
    spread: Vector
    low: Vector
    high: Vector
    size: IntVector


def empty_forms(rows: int, generators: int) -> Forms:
    """Return `rows` affine forms of the value 0, with memory for a number of generators."""
    return Forms(
        np.zeros(rows),
        np.zeros((rows, generators)),
        np.zeros(rows),
        np.zeros(rows, dtype=np.int64),
        np.zeros(rows),
        np.full(rows, -np.inf),
        np.full(rows, np.inf),
        np.zeros(1, dtype=np.int64),
    )


def copy_forms(f: Forms, whole: bool = False) -> Forms:
    """Return a copy of a table of affine forms.

    The first `f.size` generators, which are in use, are copied. If `whole` is True, the unused
    generators are copied, too.
    """
    used = f.gen.shape[1] if whole else f.size[0]
    gen = np.empty_like(f.gen)
    gen[:, :used] = f.gen[:, :used]
    return Forms(
        f.center.copy(),
        gen,
        f.error.copy(),
        f.extent.copy(),
        f.spread.copy(),
        f.low.copy(),
        f.high.copy(),
        f.size.copy(),
    )


def measure(f: Forms, rows: IntVector) -> None:
    """Compute the field `spread` of `rows` again, after their generators or errors were changed.

    The operations of this module update the spread. All other code must call this function after
    such a change.
    """
    used = np.arange(f.size[0]) < f.extent[rows, None]
    f.spread[rows] = np.abs(np.where(used, f.gen[rows, : f.size[0]], 0.0)).sum(axis=1)
    f.spread[rows] += f.error[rows]


@bare_kernel
def radius(f: Forms, a: int) -> float:
    """Return an upper bound of |value - center| for the affine form in row a."""
    return float(f.spread[a] * GROWTH)


@summing_kernel
def generators(f: Forms, a: int) -> float:
    """Return the sum of the magnitudes of the generators in row a."""
    total = 0.0
    for j in range(f.extent[a]):
        total += abs(f.gen[a, j])
    return total


@bare_kernel
def lowest(f: Forms, a: int) -> float:
    """Return a lower bound of the values of the affine form in row a."""
    r = radius(f, a)
    center = float(f.center[a])
    low: float = center if r == 0.0 else center - r - ROUND * (abs(center) + r)
    return max(low, float(f.low[a]))


@bare_kernel
def highest(f: Forms, a: int) -> float:
    """Return an upper bound of the values of the affine form in row a."""
    r = radius(f, a)
    center = float(f.center[a])
    high = center if r == 0.0 else float(center + r + ROUND * (abs(center) + r))
    return min(high, float(f.high[a]))


@bare_kernel
def is_number(f: Forms, a: int) -> bool:
    """Return True if the affine form in row a contains a single number."""
    return bool(f.extent[a] == 0 and f.error[a] == 0.0)


@bare_kernel
def assign(f: Forms, d: int, value: float) -> None:
    """Set the affine form in row d to the number `value`."""
    f.center[d] = value
    f.error[d] = 0.0
    f.extent[d] = 0
    f.spread[d] = 0.0
    f.low[d] = -np.inf
    f.high[d] = np.inf


@part_kernel
def copy_row(f: Forms, d: int, a: int) -> None:
    """Copy the affine form in row a to row d."""
    f.center[d] = f.center[a]
    f.error[d] = f.error[a]
    f.extent[d] = f.extent[a]
    f.spread[d] = f.spread[a]
    f.low[d] = f.low[a]
    f.high[d] = f.high[a]
    for j in range(f.extent[a]):
        f.gen[d, j] = f.gen[a, j]


@summing_kernel
def _sum_rows(f: Forms, d: int, ka: float, a: int, kb: float, b: int) -> float:
    """Set the generators of row d to ka a + kb b, and its spread to the sum of their magnitudes.

    Returns the sum of the magnitudes of all terms ka a and kb b.
    """
    ea = f.extent[a] if ka != 0.0 else 0
    eb = f.extent[b] if kb != 0.0 else 0
    both = min(ea, eb)
    terms, spread = 0.0, 0.0
    for j in range(both):
        x, y = ka * f.gen[a, j], kb * f.gen[b, j]
        result = x + y
        f.gen[d, j] = result
        terms += abs(x) + abs(y)
        spread += abs(result)
    k, c, extent = (ka, a, ea) if ea > eb else (kb, b, eb)
    tail = 0.0
    for j in range(both, extent):
        x = k * f.gen[c, j]
        f.gen[d, j] = x
        tail += abs(x)
    f.spread[d] = spread + tail
    return terms + tail


@part_kernel
def combine(
    f: Forms, d: int, ka: float, a: int, kb: float, b: int, offset: float, error: float
) -> None:
    """Set row d to ka a + kb b + offset, for the forms in rows a and b; d may be a or b.

    error: half-width of an interval [-error, error] that is added to the result.
    """
    extent = max(f.extent[a] if ka != 0.0 else 0, f.extent[b] if kb != 0.0 else 0)
    size = abs(ka * f.center[a]) + abs(kb * f.center[b]) + abs(offset)
    exact = extent == 0 and f.error[a] == 0.0 and f.error[b] == 0.0 and error == 0.0
    f.center[d] = ka * f.center[a] + kb * f.center[b] + offset
    width = abs(ka) * f.error[a] + abs(kb) * f.error[b] + error
    size += _sum_rows(f, d, ka, a, kb, b)
    f.extent[d] = extent
    # numbers are computed as the controller computes them
    f.error[d] = 0.0 if exact else width * GROWTH + ROUND * size
    f.spread[d] += f.error[d]
    f.low[d] = -np.inf
    f.high[d] = np.inf


@part_kernel
def multiply(f: Forms, d: int, a: int, b: int) -> None:
    """Set row d to the product of the forms in rows a and b; d may be a or b."""
    ra, rb = radius(f, a), radius(f, b)
    ca, cb = f.center[a], f.center[b]
    extent = max(f.extent[a] if cb != 0.0 else 0, f.extent[b] if ca != 0.0 else 0)
    width = abs(cb) * f.error[a] + abs(ca) * f.error[b] + ra * rb
    size = abs(ca * cb)
    size += _sum_rows(f, d, cb, a, ca, b)
    f.center[d] = ca * cb
    f.extent[d] = extent
    f.error[d] = 0.0 if ra == 0.0 and rb == 0.0 else width * GROWTH + ROUND * size
    f.spread[d] += f.error[d]
    f.low[d] = -np.inf
    f.high[d] = np.inf


@bare_kernel
def release(f: Forms, a: int, share: float) -> None:
    """Replace the error of row a by a new generator, on which later forms depend linearly.

    Nothing changes if the error is at most `share` of the row's radius, or if no generator is free.
    """
    column = f.size[0]
    if f.error[a] <= share * radius(f, a) or column >= f.gen.shape[1]:
        return
    for j in range(f.extent[a], column):
        f.gen[a, j] = 0.0
    f.gen[a, column] = f.error[a]
    f.error[a] = 0.0
    f.extent[a] = column + 1
    f.size[0] = column + 1


@part_kernel
def add_generator(f: Forms, a: int, half: float) -> None:
    """Add an independent error of +-half to row a, as a new generator."""
    f.error[a] += half
    f.spread[a] += half
    release(f, a, 0.0)


@part_kernel
def reduce_forms(f: Forms, rows: IntVector, fixed: int, keep: int, score: Vector) -> None:
    """Keep the `keep` largest generators of `rows`; add all others to the errors of these rows.

    The first `fixed` generators are always kept. `score` (generators,) is scratch memory.
    """
    size = f.size[0]
    if size <= keep:
        return
    for j in range(size):
        score[j] = 0.0
    for t in range(rows.shape[0]):
        a = rows[t]
        r = radius(f, a)
        if r > 0.0:
            for j in range(f.extent[a]):
                score[j] = max(score[j], abs(f.gen[a, j]) / r)
    low, high = 0.0, 1.0
    for _ in range(30):  # bisection for the threshold
        middle = 0.5 * (low + high)
        count = fixed
        for j in range(fixed, size):
            count += score[j] > middle
        if count > keep:
            low = middle
        else:
            high = middle
    target = fixed
    for j in range(fixed, size):
        kept = score[j] > high
        for t in range(rows.shape[0]):
            a = rows[t]
            if j >= f.extent[a]:
                continue
            if kept:
                f.gen[a, target] = f.gen[a, j]
            else:
                f.error[a] += abs(f.gen[a, j]) * GROWTH
        if kept:
            score[target] = j
            target += 1
    for t in range(rows.shape[0]):
        a = rows[t]
        if f.extent[a] > fixed:
            extent = fixed
            for c in range(fixed, target):
                if score[c] < f.extent[a]:
                    extent = c + 1
            f.extent[a] = extent
            f.spread[a] *= GROWTH  # the magnitudes of removed generators are rounded upwards
    f.size[0] = target


@part_kernel
def clip_row(f: Forms, a: int, low: float, high: float) -> None:
    """Replace the form in row a by the interval [low, high], with one new generator."""
    assign(f, a, 0.5 * (low + high))
    add_generator(f, a, 0.5 * (high - low) * GROWTH + ROUND * max(abs(low), abs(high)))


@part_kernel
def root_bounds(low: float, high: float) -> tuple[float, float, float]:
    """Return the slope and intercepts of two lines that enclose the square root on [low, high].

    The result (slope, below, above) satisfies slope x + below <= sqrt(x) <= slope x + above.
    """
    slope = 1.0 / (math.sqrt(low) + math.sqrt(high))
    below = math.sqrt(low) - slope * low
    above = 0.25 / slope  # tangent with this slope
    return slope, below, above
