"""Arithmetic of first-order Taylor forms with a remainder that bounds all rounding errors.

A form (c, t, k, s, r) represents every complex function of e_1, e_2, e_3 in [-1, 1] with

    |f(e) - (c + t e_1 + k e_2 + s e_3)| <= r

c, t, k and s are complex doubles, r is a double. r contains the products of first-order terms and
all rounding errors. With U = 2^-53, the error of a product of complex doubles is at most sqrt(5) U
|x| |y| (Brent, Percival and Zimmermann, Math. Comp. 76, 2007), and the error of a sum is at most U
times the sum. A radius r is the sum of nonnegative doubles, computed with fewer than 64 roundings
and multiplied by UP; TINY bounds underflow. A form with a NaN or an infinite radius proves nothing:
every comparison of a proof with such a form is false.
"""

from __future__ import annotations

import math
from typing import Any

from frictool.runtime.kernels import kernel
from frictool.typing import ComplexVector

Form = Any  # (complex, complex, complex, complex, float)
U = 2.0**-53
UP = 1.0 + 128.0 * U
TINY = 1e-290


@kernel
def modulus(z: complex) -> float:
    """Return an upper bound of |z| with a relative error of at most 8 U."""
    return math.sqrt(z.real * z.real + z.imag * z.imag) * (1.0 + 8.0 * U) + TINY


@kernel
def taxicab(x: Form) -> float:
    """Return |Re c| + |Im c| plus the same sums for t, k and s of the form x = (c, t, k, s, r)."""
    c, t, k, s, _ = x
    total = abs(c.real) + abs(c.imag) + abs(t.real) + abs(t.imag)
    return float(total + abs(k.real) + abs(k.imag) + abs(s.real) + abs(s.imag))


@kernel
def constant(value: float) -> Form:
    """Return a real number as a Taylor form."""
    return complex(value, 0.0), 0j, 0j, 0j, 0.0


@kernel
def times(x: Form, y: Form) -> Form:
    """Return the product of the Taylor forms x and y."""
    c, t, k, s, r = x
    d, u, j, v, q = y
    m, a = modulus(c), modulus(t) + modulus(k) + modulus(s)
    n, b = modulus(d), modulus(u) + modulus(j) + modulus(v)
    radius = (m + a + r) * q + (n + b) * r + a * b + 4.0 * U * (m + a) * (n + b)
    return c * d, c * u + t * d, c * j + k * d, c * v + s * d, radius * UP + TINY


@kernel
def plus(x: Form, y: Form) -> Form:
    """Return the sum of the Taylor forms x and y."""
    c, t, k, s, r = x
    d, u, j, v, q = y
    z = (c + d, t + u, k + j, s + v, 0.0)
    return z[0], z[1], z[2], z[3], (r + q + U * taxicab(z)) * UP


@kernel
def scaled(x: Form, g: float) -> Form:
    """Return the product of the Taylor form x and a number g with a relative error <= 2 U."""
    c, t, k, s, r = x
    z = (c * g, t * g, k * g, s * g, 0.0)
    return z[0], z[1], z[2], z[3], (abs(g) * r + 4.0 * U * taxicab(z)) * UP + TINY


@kernel
def minus(x: Form, y: Form) -> Form:
    """Return the difference x - y of two Taylor forms."""
    return plus(x, scaled(y, -1.0))


@kernel
def inverse(x: Form) -> Form:
    """Return 1/x of the Taylor form x; the radius is infinite if x contains zero.

    With h the deviation of x from c: 1/(c + h) = 1/c - h/c^2 + h^2/(c^2 (c + h))
    """
    c, t, k, s, r = x
    size = c.real * c.real + c.imag * c.imag
    least = math.sqrt(size) * (1.0 - 8.0 * U)
    a = modulus(t) + modulus(k) + modulus(s)
    reach = (a + r) * (1.0 + 8.0 * U)
    gap = (least - reach) * (1.0 - 8.0 * U)
    if not (gap > TINY and size > TINY):
        return 0j, 0j, 0j, 0j, math.inf
    d = complex(c.real / size, -c.imag / size)
    square = -d * d
    radius = r / (least * least) + reach * reach / (least * least * gap)
    radius += 16.0 * U / least + 40.0 * U * a / (least * least)
    return d, t * square, k * square, s * square, radius * UP + TINY


@kernel
def power(x: Form, n: int) -> Form:
    """Return the power x^n of the Taylor form x, n >= 0."""
    y = constant(1.0)
    for _ in range(n):
        y = times(y, x)
    return y


@kernel
def shifted(
    coefficients: ComplexVector, middle: float, half: float, work: ComplexVector
) -> tuple[complex, complex, float]:
    """Return c, t and r of the form of a polynomial on [middle - half, middle + half].

    The polynomial's coefficients (n + 1,), lowest power first, are real or imaginary, with a
    relative error of at most U. The polynomial is expanded about `middle`: each term of a new
    coefficient has at most 2 n + 1 roundings (Higham 2002, section 5.1). Let p be the polynomial
    whose coefficients are the moduli of `coefficients`. The sum of the errors is below (2 n + 4) U
    p(|middle| + half). `work` (n + 1,) is overwritten.
    """
    n = len(coefficients) - 1
    for j in range(n + 1):
        work[j] = coefficients[j]
    for i in range(n):
        for j in range(n - 1, i - 1, -1):
            work[j] += middle * work[j + 1]
    reach = (abs(middle) + half) * (1.0 + 8.0 * U)
    moduli = 0.0
    beyond = 0.0
    for j in range(n, -1, -1):
        moduli = moduli * reach + modulus(coefficients[j])
        if j >= 2:
            beyond = (beyond + modulus(work[j])) * half
    beyond *= half
    moduli *= 1.0 + 4.0 * n * U
    radius = beyond * (1.0 + 4.0 * n * U) + (2.0 * n + 8.0) * U * moduli
    slope = work[1] * half if n else 0j
    return work[0], slope, radius * UP + TINY


@kernel
def corner_above(parts: ComplexVector, remainder: float, level: float, gram: ComplexVector) -> int:
    """Return a corner of a first-order family of matrices at which the norm may reach `level`.

    The family is T_0 + T_1 e_1 + T_2 e_2 + T_3 e_3 + E with |E| <= remainder; `parts` (4, z, w) are
    T_0 to T_3. The norm is convex, so that its largest value is at one of the eight corners. Bit i
    of the result is set if e_(i+1) = 1 there. The result is -1 only if every matrix of the family
    has a norm below `level`. `gram` (w, w) is overwritten.
    """
    sizes = 0.0
    for i in range(4):
        total = 0.0
        for z in range(parts.shape[1]):
            for w in range(parts.shape[2]):
                value = parts[i, z, w]
                total += value.real * value.real + value.imag * value.imag
        sizes += math.sqrt(total)
    sizes *= 1.0 + 64.0 * U
    reduced_level = (level - (remainder + 16.0 * U * sizes) * UP) * (1.0 - 8.0 * U)
    if sizes < reduced_level:
        return -1
    for corner in range(8):
        at = (1.0 if corner & 1 else -1.0, 1.0 if corner & 2 else -1.0, 1.0 if corner & 4 else -1.0)
        if not (reduced_level > 0.0 and below_level(parts, at, reduced_level, gram)):
            return corner
    return -1


@kernel
def below_level(
    parts: ComplexVector, at: tuple[float, float, float], level: float, gram: ComplexVector
) -> bool:
    """Return True only if T_0 + T_1 e_1 + T_2 e_2 + T_3 e_3 has a norm below `level`.

    T is this sum, and T* its conjugate transpose. The roundings of T, T* T and the factorisation
    change level^2 - T* T by less than 2^-43 (trace(T* T) + level^2), which is subtracted first. The
    matrices have at most 16 rows and columns.
    """
    rows, columns = parts.shape[1], parts.shape[2]
    trace = 0.0
    for i in range(columns):
        for j in range(i + 1):
            total = 0j
            for z in range(rows):
                x = parts[0, z, i]
                y = parts[0, z, j]
                for e in range(3):
                    x += at[e] * parts[e + 1, z, i]
                    y += at[e] * parts[e + 1, z, j]
                total += complex(x.real, -x.imag) * y
            gram[i, j] = -total
            if i == j:
                trace += total.real
    shift = level * level - 2.0**-43 * (level * level + trace)
    for i in range(columns):
        for j in range(i + 1):
            total = gram[i, j]
            if i == j:
                total += shift
            for m in range(j):
                total -= gram[i, m] * complex(gram[j, m].real, -gram[j, m].imag)
            if i == j:
                if not total.real > 0.0:
                    return False
                gram[i, i] = complex(math.sqrt(total.real), 0.0)
            else:
                gram[i, j] = total / gram[j, j].real
    return True
