"""Proof of a certificate in integers: bounded-real inequalities for every constant plant of a box.

For one rectangle of rates the loop is G = [A B; C D], in coordinates x_new = W x. Let P(k) > 0 be
linear in k = K/J, and S = diag(P, I). If

    N = diag(P, g^2 I) - G' S G > 0    (BR)

then the loop of a constant plant is stable and its norm is below g. Three steps lead to integer
matrices that can be tested:

    s = sigma_v/J    G lies between four control points G_j; N is concave in G, so it is
                     positive if it is positive for each G_j
    k                G_j and P are linear: N is a cubic, positive if its four Bernstein
                     coefficients are
    rounding         each entry of G_j is known within R_j. For |D| <= R_j, any e > 0 and m
                     columns,
                     (G + D)' S (G + D) <= (1 + e) G' S G + (1 + 1/e) D' S D,
                     D' S D <= m diag(w), w_i = r_i' |S| r_i, r_i the columns of R_j

Friction only scales one input, so its largest value is the worst. No solver takes part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from frictool.documents.certificate import Bound, Certificate
from frictool.documents.certificate import Box as BoxDocument
from frictool.errors import NoSolutionError
from frictool.verify.certificate_box import (
    Interval,
    exact,
    friction_rates,
    inverse_inertia,
    uncovered,
)
from frictool.verify.certificate_loop import SENSITIVITY, CertificateLoop, closed_loop
from frictool.verify.enclosed_axis import CONTROL_POINTS, corners
from frictool.verify.exact_definiteness import first_failing_minor, inverse_of_upper, rounded_below
from frictool.verify.interval_arithmetic import BITS, ONE, Enclosure

Integers = Any  # arrays of Python integers (dtype object)
ENDS = ("low", "high")


@dataclass(frozen=True)
class CertificateCoordinates:
    """Coordinates x_new = W x.

    `forth` is W, `back` is close to its inverse, and `turned` is exactly W times `back`, in units
    of 2^(-2 BITS).
    """

    forth: Enclosure
    back: Enclosure
    turned: Integers

    @staticmethod
    def of(factor: Sequence[Sequence[float]]) -> CertificateCoordinates:
        """Return the coordinates with W = `factor`; raise ValueError if its diagonal has a zero."""
        n = len(factor)
        rows = [[0.0] * (n - len(row)) + list(row) for row in factor]
        forth = Enclosure.matrix(np.array(rows, dtype=object).reshape(n, n))
        # W is defined as the rounded matrix, so it is exact
        forth = Enclosure(forth.centre, forth.radius * 0)
        if any(forth.centre[k, k] == 0 for k in range(n)):
            raise ValueError("its diagonal has a zero")
        back = inverse_of_upper(forth.centre, ONE)
        return CertificateCoordinates(forth, Enclosure(back, back * 0), forth.centre @ back)


def prove(certificate: Certificate, loop: CertificateLoop) -> tuple[Bound, ...]:
    """Prove and return every bound of the certificate.

    `loop` has the certificate's weights. Every constant plant of the box has a stable loop, whose
    quantity is below the bound.

    Raises NoSolutionError (exit 4) for the first inequality that does not hold, with its cell and
    minor. Raises it also if the cells do not cover the box, or if the matrices do not fit the loop.
    """
    if not certificate.bounds:
        raise NoSolutionError(
            "not proved: the certificate states no bound; synthesise the controller anew"
        )
    for bound in certificate.bounds:
        _prove(bound, certificate.box, quantity_loop(loop, bound.of))
    return certificate.bounds


def quantity_loop(loop: CertificateLoop, of: Literal["norm", "sensitivity"]) -> CertificateLoop:
    """Return the loop whose norm is the quantity `of`.

    For the sensitivity this is the unweighted position loop, from s to s - position.
    """
    if of == "norm":
        return loop
    return replace(loop, controlled="position", weights=SENSITIVITY)


def _prove(bound: Bound, box: BoxDocument, loop: CertificateLoop) -> None:
    what = f"not proved: {bound.of} < {bound.below:.6g}"
    n = len(loop.states)
    if len(bound.factor) != n:
        raise NoSolutionError(
            f"{what}: the certificate's matrices are of size {len(bound.factor)}, the loop has "
            f"{n} states; synthesise the controller anew"
        )
    try:
        coordinates = CertificateCoordinates.of(bound.factor)
    except ValueError as error:
        raise NoSolutionError(
            f"{what}: the certificate's factor: {error}; synthesise the controller anew"
        ) from None
    gap = uncovered(box, bound.cells)
    if gap is not None:
        raise NoSolutionError(
            f"{what}: the cells do not cover {ranges(*gap)}; synthesise the controller anew"
        )
    for cell in bound.cells:
        rates = exact(cell.drive_rate), exact(cell.viscous_rate)
        if inverse_inertia(box, *rates) is None:
            continue
        ends = [unpacked(text, n) for text in (cell.at_low, cell.at_high)]
        if ends[0] is None or ends[1] is None:
            raise NoSolutionError(
                f"{what}: a matrix of the cell {ranges(*rates)} is not {n * (n + 1) // 2} whole "
                "numbers; synthesise the controller anew"
            )
        failing = failing_inequality(
            enclose_loop(loop, box, rates, coordinates),
            coordinates,
            (ends[0], ends[1]),
            bound.bits,
            bound.below,
        )
        if failing is not None:
            raise NoSolutionError(
                f"{what}: {failing} is not positive for {ranges(*rates)}: the controller or the "
                "certificate was changed after the "
                "proof was found; synthesise it anew, or relax the weights if that does not give "
                "a certificate"
            )


def enclose_loop(
    loop: CertificateLoop,
    box: BoxDocument,
    rates: tuple[Interval, Interval],
    coordinates: CertificateCoordinates,
) -> list[Enclosure]:
    """Return [A B; C D] at the eight corners of `enclosed_axis.corners`, in the new coordinates."""
    friction = (
        friction_rates(box, *rates) if loop.weights.disturbance else (Fraction(0), Fraction(0))
    )
    enclosures = []
    for axis in corners(*rates, friction, loop.lag, loop.period):
        whole, n = closed_loop(loop, axis)
        states = coordinates.forth @ _part(whole, slice(None, n))
        outputs = _part(whole, slice(n, None))
        rows = Enclosure(
            np.vstack([states.centre, outputs.centre]), np.vstack([states.radius, outputs.radius])
        )
        left = Enclosure(rows.centre[:, :n], rows.radius[:, :n]) @ coordinates.back
        enclosures.append(
            Enclosure(
                np.hstack([left.centre, rows.centre[:, n:]]),
                np.hstack([left.radius, rows.radius[:, n:]]),
            )
        )
    return enclosures


def failing_inequality(
    loops: Sequence[Enclosure],
    coordinates: CertificateCoordinates,
    ends: tuple[Integers, Integers],
    bits: int,
    bound: float,
) -> str | None:
    """Return the name of the first inequality that fails; None if (BR) is proved on the rectangle.

    `loops` come from `enclose_loop`. `ends` are the integer matrices (n, n) of P at the low and the
    high K/J, in units of 2^-bits.
    """
    for end, lyapunov in zip(ENDS, ends, strict=True):
        minor = first_failing_minor(lyapunov)
        if minor is not None:
            return f"minor {minor} of the Lyapunov matrix at the {end} K/J"
    n = len(ends[0])
    level = int(Fraction(bound) ** 2 * (1 << (4 * BITS + bits)))
    before = [coordinates.turned.T @ lyapunov @ coordinates.turned for lyapunov in ends]
    for point in range(CONTROL_POINTS):
        low = loops[point]
        high = loops[point + CONTROL_POINTS]
        outputs = low.centre.shape[0] - n
        columns = low.centre.shape[1]
        stored = [
            _diagonal(lyapunov, np.identity(outputs, dtype=object) << bits) for lyapunov in ends
        ]
        kept = [
            _diagonal(matrix, np.identity(columns - n, dtype=object) * level) for matrix in before
        ]
        radius = np.maximum(low.radius, high.radius)
        size = np.maximum(abs(stored[0]), abs(stored[1]))
        spread = np.array([column @ size @ column for column in radius.T], dtype=object) * columns
        finer = _finer(spread, bits)
        # Everything is multiplied by 3, since the coefficients of the cubic are thirds, and by
        # 2^finer, in units of 2^-(4 BITS + bits). With e = 2^-finer, 1 + e becomes 2^finer + 1, and
        # 1 + 1/e becomes (2^finer + 1) 2^finer.
        lost = np.diag(spread) * (3 * (1 << finer) * ((1 << finer) + 1))
        for index, (cubic, gained) in enumerate(
            zip(_cubic_of_line(kept), _cubic((low.centre, high.centre), stored), strict=True)
        ):
            left = (cubic << finer) - ((gained * ((1 << finer) + 1) + lost) << 2 * BITS)
            minor = first_failing_minor(rounded_below(left))
            if minor is not None:
                return (
                    f"minor {minor} of the bounded-real inequality (coefficient {index + 1} of 4 "
                    "in K/J, "
                    f"control point {point + 1} of {CONTROL_POINTS} in sigma_v/J)"
                )
    return None


def _cubic_of_line(ends: Sequence[Integers]) -> list[Integers]:
    """Return three times the cubic Bernstein coefficients of a linear function between two ends."""
    return [3 * ends[0], 2 * ends[0] + ends[1], ends[0] + 2 * ends[1], 3 * ends[1]]


def _cubic(loops: tuple[Integers, Integers], stored: Sequence[Integers]) -> list[Integers]:
    """Return three times the Bernstein coefficients of G' S G, G and S linear between two ends."""
    products = {
        (a, s, b): loops[a].T @ stored[s] @ loops[b]
        for a, s, b in ((0, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 1), (1, 0, 1), (1, 1, 1))
    }
    mixed = [products[0, s, 1] + products[0, s, 1].T for s in (0, 1)]
    return [
        3 * products[0, 0, 0],
        products[0, 1, 0] + mixed[0],
        products[1, 0, 1] + mixed[1],
        3 * products[1, 1, 1],
    ]


def _finer(spread: Integers, bits: int) -> int:
    """Return the exponent of 1/e for which e and spread/e are about equal.

    P and the norm are of the order of one.
    """
    largest = max(int(value) for value in spread)
    return max(1, min(2 * BITS, (2 * BITS + bits - largest.bit_length()) // 2))


def _diagonal(first: Integers, second: Integers) -> Integers:
    n, m = len(first), len(second)
    whole = np.zeros((n + m, n + m), dtype=object)
    whole[:n, :n], whole[n:, n:] = first, second
    return whole


def _part(whole: Enclosure, rows: slice) -> Enclosure:
    return Enclosure(whole.centre[rows], whole.radius[rows])


def unpacked(text: str, n: int) -> Integers | None:
    """Return the symmetric integer matrix (n, n) of a cell; None if the text is not one."""
    words = text.split()
    if len(words) != n * (n + 1) // 2 or not all(
        word.removeprefix("-").isdecimal() and len(word) < 40 for word in words
    ):
        return None
    matrix = np.zeros((n, n), dtype=object)
    upper = np.triu_indices(n)
    matrix[upper] = [int(word) for word in words]
    return matrix + np.triu(matrix, 1).T


def pack_matrix(lyapunov: Integers) -> str:
    """Return the upper triangle as text, row by row."""
    return " ".join(str(int(value)) for value in lyapunov[np.triu_indices(len(lyapunov))])


def ranges(drive: Interval, viscous: Interval) -> str:
    """Return a rectangle of rates as words for a message."""
    return (
        f"K/J {float(drive[0]):.6g} to {float(drive[1]):.6g}, sigma_v/J {float(viscous[0]):.6g} "
        f"to {float(viscous[1]):.6g}"
    )
