"""Branch and bound over frequencies and plants: the kernel of verify/zero_exclusion.py.

Half the unit circle is z = (q + p)/(q - p), in two charts with t from 0 to 1: p = i t, q = 1 in
chart 0, and p = i, q = t in chart 1. With Q = q - p and Z = q + p,

    z - 1 = 2 p/Q      z = Z/Q      z - h_0 = H/Q      z - e = E/Q
    H = sigma h_1 Q + 2 p           E = (1 - e) q + (1 + e) p      (E = 1 without lag)
    C = N/A, N and A homogeneous in p and q

A plant is described by kappa = (actuator's constant) T^2/J, sigma = (viscous friction) T/J and
phi = (Coulomb friction) T^2/J, with the period T and the inertia J. exponential_enclosure.py
defines h_0, h_1, h_2, a, b and e. With all denominators multiplied out, d samples of delay and

    B = h_1 Q + 2 p h_2,    G = E B - 2 p (h_1 a Q + H b)      (G = B without lag)
    K = A E Z^d,            M = kappa N Q^(d + 1)

the characteristic polynomial is D = 2 p H K + M G. The closed-loop matrix (T in the docstrings
below; T in the table is the period) has these entries, divided by D and multiplied by the weights:

    from        X            e of a position   e of a speed                              eta
    reference   2 p H        K X               -                                         -M G
       (speed)  T H Q        -                 2 p (H K + M (E h_2 + sigma h_2 a Q - H b))  K X
    friction    phi B Q      K X               2 p Q phi/T (h_1 K + M (a h_2 - h_1 b))   K X
    noise       2 p H W4     -M G W4           -2 p M (h_1 E - 2 p a) W4/T               -M G W4

    u = N E Z^d X        i = (1 - e) N Q^(d + 1) X      (N Q^d X without lag)

If the loop feeds back a speed, the matrix has one entry only: e of a position from the reference,
the sensitivity. If the speed is measured, M G has one more term with the numerator N_v of the
measured speed:

    2 p kappa N_v Q^(d + 1) V,    V = (h_1 E - 2 p a)/T

If the position is free, the common factor 2 p is left out of all terms. No entry has a pole or a
cancellation at z = 1. Every quantity is a Taylor form (taylor_forms.py) in t, kappa and sigma over
a cell.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.runtime.kernels import kernel, part_kernel
from frictool.typing import ComplexVector, Vector
from frictool.verify.taylor_forms import (
    UP,
    Form,
    U,
    below_level,
    constant,
    corner_above,
    inverse,
    minus,
    modulus,
    plus,
    power,
    scaled,
    shifted,
    times,
)

PROVED, VIOLATED, UNDECIDED = 0, 1, 2
DEPTH = 512  # largest number of cells on the stack
# change of T over a cell's frequencies, relative to its largest change over a plant parameter,
# below which the frequencies need not be divided first
STEADY = 0.05


class KernelLoop(NamedTuple):
    """Data of a certificate's loop, with the symbols of the module docstring.

    `numerator` and `denominator` (2, m + 1) are N and A as polynomials of t in each chart.
    `measured` is N_v, empty if no sensor measures the speed. If `free`, the factor 2 p of N is left
    out. `holds` (4, n + 1) are the polynomials of h_1, h_2, a and b in sigma - `middle`, `errors`
    (4,) bounds of their errors. `lagged` is True for a drive with lag; `lost` is 1 - e, `kept` is 1
    + e. `speed` is True if the controlled quantity is the speed. `delay` is in samples, `period` in
    s. `error` and `noise` are the weights W2 and W4 as gain, zero and pole of gain (q + zero p)/(q
    + pole p). The weights `disturbance` (on the friction), `drive` (on i), `command` (on u) and
    `eta` are numbers; a row or column with the weight 0 is left out of the matrix.
    """

    numerator: ComplexVector
    measured: ComplexVector
    denominator: ComplexVector
    holds: ComplexVector
    errors: Vector
    middle: float
    lagged: bool
    lost: float
    kept: float
    delay: int
    speed: bool
    free: bool
    period: float
    error: tuple[float, float, float]
    noise: tuple[float, float, float]
    disturbance: float
    drive: float
    command: float
    eta: float


class KernelBox(NamedTuple):
    """Intervals of the plants' parameters, rounded outward; T is the period, J the inertia.

    - inverse: interval of T^2/J
    - drive: interval of the actuator's constant
    - viscous: interval of (viscous friction)/T
    - friction: largest Coulomb friction
    """

    inverse: tuple[float, float]
    drive: tuple[float, float]
    viscous: tuple[float, float]
    friction: float


class KernelWorkspace(NamedTuple):
    """Scratch arrays of the kernel for a closed-loop matrix T with z rows and w columns.

    - parts: Taylor coefficients of T (4, z, w)
    - gram: Gram matrix (w, w)
    - polynomial: coefficients of a polynomial, overwritten
    """

    parts: ComplexVector
    gram: ComplexVector
    polynomial: ComplexVector


class LoopTerms(NamedTuple):
    """Taylor forms of the formulas in the module docstring, in one cell of t, kappa and sigma.

    - two_p, big_q: 2 p, Q
    - hold: H
    - poles: 2 p H, or H if the position is free
    - lag: E
    - axis: B
    - kept: K
    - moved: M G, plus the term of N_v if the speed is measured
    - looped: M
    - entering: N E Z^d
    - driving: (1 - e) N Q^(d + 1), or N Q^d without lag
    - whole: D
    - over: 1/D
    - error, noise: weights W2, W4

    The other fields have the names of the module's formulas.
    """

    two_p: Form
    big_q: Form
    sigma: Form
    phi: Form
    h_1: Form
    h_2: Form
    a: Form
    b: Form
    hold: Form
    poles: Form
    lag: Form
    axis: Form
    kept: Form
    moved: Form
    looped: Form
    entering: Form
    driving: Form
    whole: Form
    over: Form
    error: Form
    noise: Form


@kernel
def workspace(loop: KernelLoop) -> KernelWorkspace:
    """Return the scratch arrays for the closed-loop matrix of `loop`."""
    rows = 1 + (loop.drive > 0.0) + (loop.command > 0.0) + (loop.eta > 0.0)
    columns = 1 + (loop.disturbance > 0.0) + (loop.noise[0] > 0.0)
    size = max(loop.denominator.shape[1], loop.holds.shape[1])
    parts = np.empty((4, rows, columns), np.complex128)
    gram = np.empty((columns, columns), np.complex128)
    polynomial = np.empty(size, np.complex128)
    for j in range(columns):
        for i in range(rows):
            for part in range(4):
                parts[part, i, j] = 0j
        for i in range(columns):
            gram[i, j] = 0j
    for k in range(size):
        polynomial[k] = 0j
    return KernelWorkspace(parts, gram, polynomial)


@kernel
def inverse_inertia(
    box: KernelBox, drive: tuple[float, float], viscous: tuple[float, float]
) -> tuple[float, float]:
    """Return (low, high) bounds of T^2/J for plants with kappa and sigma in given intervals.

    T is the sample period, J the inertia; the module docstring defines kappa and sigma.

    - drive: interval of kappa
    - viscous: interval of sigma

    If low > high, there is no such plant.
    """
    low = max(box.inverse[0], drive[0] / box.drive[1])
    high = min(box.inverse[1], drive[1] / box.drive[0])
    if box.viscous[0] > 0.0:
        high = min(high, viscous[1] / box.viscous[0])
    elif box.viscous[0] < 0.0:
        low = max(low, viscous[1] / box.viscous[0])
    elif viscous[1] < 0.0:
        high = -1.0
    if box.viscous[1] > 0.0:
        low = max(low, viscous[0] / box.viscous[1])
    elif box.viscous[1] < 0.0:
        high = min(high, viscous[0] / box.viscous[1])
    elif viscous[0] > 0.0:
        high = -1.0
    return low * (1.0 - 4.0 * U), high * (1.0 + 4.0 * U)


@kernel
def friction_above(box: KernelBox, kappa: Form, sigma: Form) -> Form:
    """Return an upper bound of phi for every plant with these kappa and sigma, as a Taylor form.

    phi is the Coulomb friction times T^2/J (module docstring). T^2/J has three upper bounds: the
    upper end of its interval, kappa divided by the lowest actuator constant, and sigma divided by
    the least (viscous friction)/T if that is positive. The bound that is smallest in the middle of
    the cell is used.
    """
    most = box.inverse[1]
    form = constant(box.friction * most * UP)
    if kappa[0].real / box.drive[0] < most:
        most = kappa[0].real / box.drive[0]
        form = scaled(kappa, box.friction / box.drive[0] * UP)
    if box.viscous[0] > 0.0 and sigma[0].real / box.viscous[0] < most:
        form = scaled(sigma, box.friction / box.viscous[0] * UP)
    return form


@part_kernel
def _filtered(weight: tuple[float, float, float], p: Form, q: Form) -> Form:
    """Return the weight `gain` (q + zero p)/(q + pole p) as a form, or the gain if the pole is 0.

    - weight: gain, zero and pole
    - p, q: forms of the module docstring
    """
    gain, zero, pole = weight
    if pole == 0.0:
        return constant(gain)
    return times(scaled(plus(q, scaled(p, zero)), gain), inverse(plus(q, scaled(p, pole))))


@part_kernel
def _held(loop: KernelLoop, index: int, at: tuple[float, float], space: KernelWorkspace) -> Form:
    """Return the form of h_1, h_2, a or b (`index` 0 to 3) for sigma - middle = at[0] +- at[1]."""
    centre, slope, radius = shifted(loop.holds[index], at[0], at[1], space.polynomial)
    return centre, 0j, 0j, slope, (radius + loop.errors[index]) * UP


@part_kernel
def _span(low: float, high: float) -> tuple[float, float]:
    middle = 0.5 * (low + high)
    return middle, max(middle - low, high - middle) * (1.0 + 2.0 * U)


@kernel
def loop_terms(
    loop: KernelLoop, box: KernelBox, chart: int, cell: Vector, space: KernelWorkspace
) -> LoopTerms:
    """Return the terms of the loop in a cell (6,): intervals of t, kappa and sigma - middle.

    The module docstring defines the symbols.
    """
    t, dt = _span(cell[0], cell[1])
    k, dk = _span(cell[2], cell[3])
    x, dx = _span(cell[4], cell[5])
    one = constant(1.0)
    p = (complex(0.0, t), complex(0.0, dt), 0j, 0j, 0.0)
    q = one
    if chart == 1:
        p = (1j, 0j, 0j, 0j, 0.0)
        q = (complex(t, 0.0), complex(dt, 0.0), 0j, 0j, 0.0)
    kappa = (complex(k, 0.0), 0j, complex(dk, 0.0), 0j, 0.0)
    sigma = plus(constant(loop.middle), (complex(x, 0.0), 0j, 0j, complex(dx, 0.0), 0.0))
    centre, slope, radius = shifted(loop.numerator[chart], t, dt, space.polynomial)
    numerator = (centre, slope, 0j, 0j, radius)
    centre, slope, radius = shifted(loop.denominator[chart], t, dt, space.polynomial)
    denominator = (centre, slope, 0j, 0j, radius)
    two_p = scaled(p, 2.0)
    big_q = minus(q, p)
    late = power(plus(q, p), loop.delay)
    h_1 = _held(loop, 0, (x, dx), space)
    h_2 = _held(loop, 1, (x, dx), space)
    hold = plus(times(times(sigma, h_1), big_q), two_p)
    axis = plus(times(h_1, big_q), times(two_p, h_2))
    lag, a, b, geared = one, constant(0.0), constant(0.0), axis
    driving = times(numerator, power(big_q, loop.delay))
    passing = times(driving, big_q)
    if loop.lagged:
        a = _held(loop, 2, (x, dx), space)
        b = _held(loop, 3, (x, dx), space)
        lag = plus(scaled(q, loop.lost), scaled(p, loop.kept))
        part = plus(times(times(h_1, a), big_q), times(hold, b))
        geared = minus(times(lag, axis), times(two_p, part))
        driving = scaled(passing, loop.lost)
    kept = times(denominator, times(lag, late))
    looped = times(kappa, passing)
    moved = times(looped, geared)
    poles = hold if loop.free else times(two_p, hold)
    if loop.measured.shape[1] > 0:
        centre, slope, radius = shifted(loop.measured[chart], t, dt, space.polynomial)
        seen = times((centre, slope, 0j, 0j, radius), power(big_q, loop.delay + 1))
        speed = scaled(minus(times(h_1, lag), times(two_p, a)), 1.0 / loop.period)
        if not loop.free:
            speed = times(two_p, speed)
        moved = plus(moved, times(times(kappa, seen), speed))
    whole = plus(times(kept, poles), moved)
    return LoopTerms(
        two_p,
        big_q,
        sigma,
        friction_above(box, kappa, sigma),
        h_1,
        h_2,
        a,
        b,
        hold,
        poles,
        lag,
        axis,
        kept,
        moved,
        looped,
        times(numerator, times(lag, late)),
        driving,
        whole,
        inverse(whole),
        _filtered(loop.error, p, q),
        _filtered(loop.noise, p, q),
    )


@part_kernel
def _from_reference(loop: KernelLoop, at: LoopTerms) -> tuple[Form, Form, Form]:
    if not loop.speed:
        common = times(at.poles, at.over)
        return common, times(at.kept, common), scaled(times(at.moved, at.over), -1.0)
    common = times(scaled(times(at.hold, at.big_q), loop.period), at.over)
    part = plus(times(at.lag, at.h_2), times(times(at.sigma, at.h_2), times(at.a, at.big_q)))
    part = times(at.looped, minus(part, times(at.hold, at.b)))
    error = times(times(at.two_p, plus(times(at.hold, at.kept), part)), at.over)
    return common, error, times(at.kept, common)


@part_kernel
def _from_friction(loop: KernelLoop, at: LoopTerms) -> tuple[Form, Form, Form]:
    friction = times(scaled(at.phi, loop.disturbance), at.over)
    common = times(friction, times(at.axis, at.big_q))
    eta = times(at.kept, common)
    if not loop.speed:
        return common, eta, eta
    part = minus(times(at.a, at.h_2), times(at.h_1, at.b))
    part = plus(times(at.h_1, at.kept), times(at.looped, part))
    error = times(times(at.two_p, at.big_q), times(friction, part))
    return common, scaled(error, 1.0 / loop.period), eta


@part_kernel
def _from_noise(loop: KernelLoop, at: LoopTerms) -> tuple[Form, Form, Form]:
    noise = times(at.noise, at.over)
    common = times(times(at.two_p, at.hold), noise)
    eta = scaled(times(at.moved, noise), -1.0)
    if not loop.speed:
        return common, eta, eta
    part = minus(times(at.h_1, at.lag), times(at.two_p, at.a))
    error = times(times(at.looped, times(at.two_p, part)), noise)
    return common, scaled(error, -1.0 / loop.period), eta


@part_kernel
def _write(space: KernelWorkspace, row: int, column: int, entry: Form) -> float:
    space.parts[0, row, column] = entry[0]
    space.parts[1, row, column] = entry[1]
    space.parts[2, row, column] = entry[2]
    space.parts[3, row, column] = entry[3]
    return float(entry[4] * entry[4])


@part_kernel
def _write_column(
    loop: KernelLoop,
    at: LoopTerms,
    column: int,
    signals: tuple[Form, Form, Form],
    space: KernelWorkspace,
) -> float:
    """Write a column of the closed-loop matrix T; return the sum of the squared remainders.

    signals: X/D, e/D and eta/D for the input of this column.
    """
    common, error, eta = signals
    remainder = _write(space, 0, column, times(at.error, error))
    row = 1
    if loop.drive > 0.0:
        remainder += _write(space, row, column, scaled(times(at.driving, common), loop.drive))
        row += 1
    if loop.command > 0.0:
        remainder += _write(space, row, column, scaled(times(at.entering, common), loop.command))
        row += 1
    if loop.eta > 0.0:
        remainder += _write(space, row, column, scaled(eta, loop.eta))
    return remainder


@kernel
def enclose_responses(loop: KernelLoop, at: LoopTerms, space: KernelWorkspace) -> float:
    """Write the Taylor coefficients of T in a cell to `space`; return the norm of the remainder.

    The closed-loop matrix T has the rows error, drive, command and eta, and the columns reference,
    friction and noise; signals without a weight are left out. The remainder is infinite if the
    enclosure of the characteristic polynomial contains zero.
    """
    if not at.over[4] < math.inf:
        return math.inf
    remainder = _write_column(loop, at, 0, _from_reference(loop, at), space)
    column = 1
    if loop.disturbance > 0.0:
        remainder += _write_column(loop, at, column, _from_friction(loop, at), space)
        column += 1
    if loop.noise[0] > 0.0:
        remainder += _write_column(loop, at, column, _from_noise(loop, at), space)
    return math.sqrt(remainder) * (1.0 + 64.0 * U)


@kernel
def viscous_rates(loop: KernelLoop, low: float, high: float) -> tuple[float, float]:
    """Return the interval of sigma, rounded outward, for sigma - middle in [low, high]."""
    least = loop.middle + low
    most = loop.middle + high
    return least - 2.0 * U * abs(least), most + 2.0 * U * abs(most)


@part_kernel
def _total(part: ComplexVector) -> float:
    total = 0.0
    for i in range(part.shape[0]):
        for j in range(part.shape[1]):
            total += abs(part[i, j])
    return total


@kernel
def explore(
    loop: KernelLoop,
    box: KernelBox,
    chart: int,
    start: Vector,
    level: float,
    most: int,
    at: Vector,
) -> tuple[int, int]:
    """Divide the cell `start` (6,) until a bound is proved; return outcome and number of cells.

    A cell contains both ends of the intervals of t, kappa and sigma - middle (module docstring).

    - PROVED: for every plant of `box` in the cell, the characteristic polynomial D is not zero and
      the norm of the closed-loop matrix T is below `level`
    - VIOLATED: the norm, computed in doubles, reaches `level` at `at` (3,): t, kappa and sigma
    - UNDECIDED: the proof needs more than `most` cells, or cells that are too small; `at` is the
      middle of a cell that is not proved
    """
    space = workspace(loop)
    stack = np.empty((DEPTH, 6))
    for i in range(6):
        stack[0, i] = start[i]
    cell = np.empty(6)
    widths = np.empty(3)
    waiting = 1
    cells = 0
    while waiting:
        waiting -= 1
        for i in range(6):
            cell[i] = stack[waiting, i]
        low, high = inverse_inertia(box, (cell[2], cell[3]), viscous_rates(loop, cell[4], cell[5]))
        if low > high:
            continue
        cells += 1
        terms = loop_terms(loop, box, chart, cell, space)
        remainder = enclose_responses(loop, terms, space)
        corner = 7
        widths[0] = modulus(terms.whole[1])
        widths[1] = modulus(terms.whole[2])
        widths[2] = modulus(terms.whole[3])
        if remainder < math.inf:
            corner = corner_above(space.parts, remainder, level, space.gram)
            if corner < 0:
                continue
            for i in range(3):
                widths[i] = _total(space.parts[1 + i])
        for i in range(3):
            at[i] = 0.5 * (cell[2 * i] + cell[2 * i + 1])
        split = 0
        for i in range(1, 3):
            if widths[i] > widths[split]:
                split = i
        # divide a wide range of frequencies first, unless T hardly changes in it
        steady = remainder < math.inf and widths[0] < STEADY * widths[split]
        if cell[1] - cell[0] > 0.5 * cell[1] and not steady:
            split = 0
        middle = at[split]
        low, high = inverse_inertia(box, (at[1], at[1]), viscous_rates(loop, at[2], at[2]))
        at[2] += loop.middle
        inside = remainder < math.inf and low <= high
        if inside and not below_level(space.parts, (0.0, 0.0, 0.0), level, space.gram):
            return VIOLATED, cells
        parted = cell[2 * split] < middle < cell[2 * split + 1]
        if cells + waiting >= most or waiting + 2 > DEPTH or not parted:
            return UNDECIDED, cells
        upper = (corner >> split) & 1  # the half with the corner is searched first
        for end in (upper, 1 - upper):
            for i in range(6):
                stack[waiting, i] = cell[i]
            stack[waiting, 2 * split + end] = middle
            waiting += 1
    return PROVED, cells


@kernel
def turn(
    loop: KernelLoop, box: KernelBox, plant: tuple[float, float], most: int
) -> tuple[float, float]:
    """Return the change of arg D [rad] for one plant from z = 1 to z = -1, and an error bound.

    D is the characteristic polynomial. `plant` is (kappa, sigma - middle). Between neighbouring
    points the enclosure of D does not contain zero, so that arg D changes by less than pi. The
    error bound is infinite if the plant is not in the box, or if more than `most` divisions are
    needed.
    """
    low, high = inverse_inertia(box, (plant[0], plant[0]), viscous_rates(loop, plant[1], plant[1]))
    space = workspace(loop)
    cell = np.empty(6)
    for end in range(2):
        cell[end] = 0.0
        cell[2 + end] = plant[0]
        cell[4 + end] = plant[1]
    ends = np.empty(DEPTH)
    before = loop_terms(loop, box, 0, cell, space).whole
    error = before[4] / modulus(before[0])
    angle = 0.0
    cells = 0
    for chart in range(2):
        reached = float(chart)
        ends[0] = 1.0 - reached
        waiting = 1
        while waiting:
            end = ends[waiting - 1]
            cell[0] = min(reached, end)
            cell[1] = max(reached, end)
            whole = loop_terms(loop, box, chart, cell, space).whole
            reach = (modulus(whole[1]) + whole[4]) * UP
            if not modulus(whole[0]) * (1.0 - 32.0 * U) > reach:
                middle = 0.5 * (reached + end)
                parted = cell[0] < middle < cell[1]
                cells += 1
                if low > high or cells > most or waiting == DEPTH or not parted:
                    return angle, math.inf
                ends[waiting] = middle
                waiting += 1
                continue
            cell[0] = end
            cell[1] = end
            whole = loop_terms(loop, box, chart, cell, space).whole
            ratio = whole[0] * complex(before[0].real, -before[0].imag)
            angle += math.atan2(ratio.imag, ratio.real)
            error += 4.0 * (whole[4] / modulus(whole[0]) + 16.0 * U)
            before = whole
            reached = end
            waiting -= 1
    return angle, math.inf if low > high else error
