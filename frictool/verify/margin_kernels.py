"""Kernels of the modulus margin for one controller and thousands of plants.

The kernels compute the loop of verify/feedback_loops.py with one plant, and the largest gain of its
sensitivity.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.runtime.kernels import kernel
from frictool.typing import ComplexVector, IntVector, Matrix, Vector

# codes of the measured signals
SEES_ETA, SEES_DIFFERENCE, SEES_SPEED = 0, 1, 2
# largest row sum of a matrix whose power series is summed; other matrices are halved first
LARGEST_ROW = 0.5
TERMS = 16  # terms of the series; the first omitted term is below 1e-19
NEAR = 0.9  # fraction of the largest gain above which a maximum is refined
ZOOMS, ZOOMED = 4, 11  # rounds of refinement, and frequencies in each
# relative difference between the gains from the modes and from the matrices, above which the modes
# are not trusted
AGREEMENT = 1e-7
UNKNOWN = -1.0


@kernel
def exponential(matrix: Matrix) -> Matrix:
    """Return e^matrix (n, n) of a small matrix, by halving, power series and squaring."""
    n = matrix.shape[0]
    largest = 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            row += abs(matrix[i, j])
        largest = max(largest, row)
    halvings = 0
    while largest > LARGEST_ROW:
        largest *= 0.5
        halvings += 1
    scale = 0.5**halvings
    scaled = np.empty((n, n))
    total = np.empty((n, n))
    product = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            scaled[i, j] = matrix[i, j] * scale
            total[i, j] = 1.0 if i == j else 0.0
    for k in range(TERMS, 0, -1):
        _multiply(scaled, total, product)
        for i in range(n):
            for j in range(n):
                total[i, j] = (1.0 if i == j else 0.0) + product[i, j] / k
    for _ in range(halvings):
        _multiply(total, total, product)
        total, product = product, total
    return total


@kernel
def _multiply(a: Matrix, b: Matrix, out: Matrix) -> None:
    """Write the product of a and b to `out`; for few rows, this is faster than a library call."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            out[i, j] = 0.0
        for k in range(n):
            if a[i, k] != 0.0:
                for j in range(n):
                    out[i, j] += a[i, k] * b[k, j]


@kernel
def sampled_axis(
    drive: float, viscous: float, lag: float, period: float, sees: IntVector
) -> tuple[Matrix, Vector, Matrix]:
    """Return the matrices a (n, n), b (n,), c (m, n) of the axis, from command to measured signals.

    `feedback_loops.measured_axis` defines the system.

    - drive and viscous: rates of plant/linear_axis.py
    - lag: time constant of the drive [s]
    - period: sample period [s]
    - sees (m,): code of each measured signal, SEES_ETA, SEES_DIFFERENCE or SEES_SPEED
    """
    n = 3 if lag > 0.0 else 2
    whole = np.zeros((n + 1, n + 1))
    if lag > 0.0:
        whole[0, 0] = -period / lag
        whole[0, 3] = period / lag
        whole[1, 0] = period * drive
    else:
        whole[0, 2] = period * drive
    whole[n - 2, n - 2] = -period * viscous
    whole[n - 1, n - 2] = -period
    held = exponential(whole)
    # eta, then the difference of two samples of eta
    kept = np.empty(n + 1, dtype=np.int64)
    for i in range(n - 1):
        kept[i] = i
    count = n - 1
    places = np.empty(3, dtype=np.int64)
    places[SEES_SPEED] = n - 2
    for seen in range(SEES_ETA, SEES_DIFFERENCE + 1):
        is_seen = False
        for i in range(sees.shape[0]):
            is_seen = is_seen or sees[i] == seen
        if is_seen:
            places[seen] = count
            kept[count] = n - 1 + seen
            count += 1
    a = np.zeros((count, count))
    b = np.zeros(count)
    for i in range(count):
        row = min(kept[i], n - 1)
        scale = 1.0 if kept[i] < n else 1.0 / period
        b[i] = held[row, n] * scale
        for j in range(count):
            if kept[j] < n:
                before = 1.0 if kept[i] == n and kept[j] == n - 1 else 0.0
                a[i, j] = (held[row, kept[j]] - before) * scale
    rows = np.zeros((sees.shape[0], count))
    for i in range(sees.shape[0]):
        rows[i, places[sees[i]]] = -1.0 if sees[i] == SEES_SPEED else 1.0
    return a, b, rows


@kernel
def sensitivity(
    controller: tuple[Matrix, Matrix, Matrix, Matrix],
    delay_samples: int,
    axis: tuple[Matrix, Vector, Matrix],
) -> tuple[Matrix, Vector, Vector]:
    """Return the matrices a (n, n), b (n,) and c (n,) of 1/(1 + L) - 1, with the loop gain L.

    - controller: matrices a, b, c, d of the controller, with one input per measured signal and one
      output
    - axis: result of `sampled_axis`

    The states belong to controller, delay and axis, in this order. The input is added to the
    controller's drive.
    """
    ca, cb, cc, cd = controller
    axis_a, push, seen = axis
    n, m = ca.shape[0], axis_a.shape[0]
    first = n + delay_samples
    a = np.zeros((first + m, first + m))
    b = np.zeros(first + m)
    c = np.zeros(first + m)
    for j in range(n):
        c[j] = cc[0, j]
        for i in range(n):
            a[i, j] = ca[i, j]
    for j in range(m):
        for i in range(m):
            a[first + i, first + j] = axis_a[i, j]
    for signal in range(seen.shape[0]):
        for j in range(m):
            c[first + j] += cd[0, signal] * seen[signal, j]
            for i in range(n):
                a[i, first + j] += cb[i, signal] * seen[signal, j]
    if delay_samples > 0:
        b[n] = 1.0
        for k in range(1, delay_samples):
            a[n + k, n + k - 1] = 1.0
        for i in range(m):
            a[first + i, first - 1] = push[i]
    else:
        for i in range(m):
            b[first + i] = push[i]
    for i in range(first + m):
        if b[i] != 0.0:
            for j in range(first + m):
                a[i, j] += b[i] * c[j]
    return a, b, c


@kernel
def _solve(matrix: NDArray[np.complex128], right: ComplexVector) -> bool:
    n = right.shape[0]
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        if matrix[best, k] == 0.0:
            return False
        if best != k:
            for j in range(k, n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
            right[k], right[best] = right[best], right[k]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            factor = matrix[i, k] * inverse
            if factor != 0.0:
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                right[i] -= factor * right[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
    return True


@kernel
def _on_circle(angle: float) -> complex:
    return complex(np.exp(1j * angle))


@kernel
def _by_modes(poles: ComplexVector, residues: ComplexVector, point: complex) -> float:
    total = complex(1.0)
    for k in range(poles.shape[0]):
        total += residues[k] / (point - poles[k])
    return abs(total)


@kernel
def _by_matrices(loop: tuple[Matrix, Vector, Vector], point: complex) -> float:
    a, b, c = loop
    n = b.shape[0]
    matrix = np.empty((n, n), dtype=np.complex128)
    x = np.empty(n, dtype=np.complex128)
    for i in range(n):
        x[i] = b[i]
        for j in range(n):
            matrix[i, j] = -complex(a[i, j])
        matrix[i, i] += point
    if not _solve(matrix, x):
        return math.inf
    total = complex(0.0)
    for i in range(n):
        total += c[i] * x[i]
    return abs(1.0 + total)


@kernel
def _with_angles(grid: Vector, poles: ComplexVector) -> Vector:
    count = grid.shape[0]
    angles = np.empty(count + poles.shape[0])
    for k in range(count):
        angles[k] = grid[k]
    for k in range(poles.shape[0]):
        angle = abs(np.angle(poles[k]))
        index = count + k
        while index > 0 and angles[index - 1] > angle:
            angles[index] = angles[index - 1]
            index -= 1
        angles[index] = angle
    return angles


@kernel
def peak(
    loop: tuple[Matrix, Vector, Vector],
    poles: ComplexVector,
    vectors: NDArray[np.complex128],
    grid: Vector,
) -> float:
    """Return the largest gain of a stable loop; UNKNOWN if the eigenvectors are too imprecise.

    - loop: matrices from `sensitivity`
    - poles (n,), vectors (n, n): eigenvalues and eigenvectors of a
    - grid (k,): rising angles in [0, pi] at which the search starts, in addition to the angles of
      the poles

    The search computes the gain from poles and residues. At the peak, the gain is computed again
    from the matrices.
    """
    _, b, c = loop
    n = poles.shape[0]
    residues = np.empty(n, dtype=np.complex128)
    solved = np.empty((n, n), dtype=np.complex128)
    for i in range(n):
        residues[i] = b[i]
        for j in range(n):
            solved[i, j] = vectors[i, j]
    if not _solve(solved, residues):
        return UNKNOWN
    for k in range(n):
        output = complex(0.0)
        for i in range(n):
            output += c[i] * vectors[i, k]
        residues[k] *= output
    angles = _with_angles(grid, poles)
    last = angles.shape[0] - 1
    responses = np.empty(last + 1)
    for k in range(last + 1):
        responses[k] = _by_modes(poles, residues, _on_circle(angles[k]))
    top = responses[0]
    for response in responses:
        if response > top or math.isnan(response):
            top = response
    least = NEAR * top
    expected = 0.0
    largest = 0.0
    for k in range(last + 1):
        left, right = max(k - 1, 0), min(k + 1, last)
        if not responses[k] >= max(least, responses[left], responses[right]):
            continue
        low = angles[left]
        high = angles[right]
        for _ in range(ZOOMS):
            step = (high - low) / (ZOOMED - 1)
            best = 0
            gain = -1.0
            for j in range(ZOOMED):
                value = _by_modes(poles, residues, _on_circle(low + j * step))
                if value > gain:
                    best, gain = j, value
            at = low + best * step
            high = low + min(best + 1, ZOOMED - 1) * step
            low += max(best - 1, 0) * step
        expected = max(expected, gain)
        largest = max(largest, _by_matrices(loop, _on_circle(at)))
    return largest if abs(largest - expected) <= AGREEMENT * largest else UNKNOWN
