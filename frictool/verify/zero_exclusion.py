"""Proof of stability, sensitivity and norm for every constant plant of a box, by zero exclusion.

A box contains every plant with parameters in given intervals. The closed loop of thesis figure 5.11
or 5.25 with the sampled axis is T(z) = N(z)/D(z). D is the characteristic polynomial of the whole
loop (zero_exclusion_kernel.py). Theorem: if

    (a) the roots of D lie in the unit circle for one plant of the box,
    (b) D(z) differs from zero for every plant of the box and every |z| = 1,
    (c) |T(z)| < g for every plant of the box and every |z| = 1,

then the loop of every constant plant of the box is stable with a norm below g. The reason is that
roots depend continuously on the plant, the box is connected, and by (b) no root crosses the
circle. (b) and (c) are proved on cells, which are products of an interval of the frequency and
intervals of the plant parameters. Cells are halved until the bound is proved on each cell. (a) is
proved by Mikhailov's criterion: D is a polynomial of degree n in the bilinear variable, and its
argument must change by n pi/2 along half the circle. The sensitivity is the norm of a loop without
weights.

The proof uses no solver and no grid, and g is the only stored result that it uses. All coefficients
are computed from the stored coefficients in integers, and all rounding errors of the kernel are
bounded (taylor_forms.py). The theorem is not valid for parameters that vary with time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from frictool.documents.certificate import Box, Certificate, Filter
from frictool.errors import NoSolutionError
from frictool.typing import ComplexVector, Vector
from frictool.verify.bilinear_polynomials import Polynomial, on_circle
from frictool.verify.certificate_loop import CertificateLoop, quantity_loops
from frictool.verify.exponential_enclosure import HoldPolynomials, check_range, hold_polynomials
from frictool.verify.feedback_polynomials import feedback_polynomials
from frictool.verify.proved_bound import ProvedBound
from frictool.verify.zero_exclusion_kernel import (
    PROVED,
    VIOLATED,
    KernelBox,
    KernelLoop,
    explore,
    turn,
)

Interval = tuple[Fraction, Fraction]
MOST_CELLS = 400_000  # largest number of cells for one bound; they take some seconds
ROUNDING = Fraction(1, 1 << 53)


@dataclass(frozen=True)
class OpenCell:
    """Plant (SI) and angular frequency [rad/s] at which a bound was not proved.

    violated: True if the bound is violated at this plant and frequency (computed in doubles); False
    if the proof needs too many cells.
    """

    inertia: float
    viscous: float
    constant: float
    frequency: float
    violated: bool


def prove(certificate: Certificate, loop: CertificateLoop) -> tuple[ProvedBound, ...]:
    """Prove every bound of the certificate for `loop`, which has the certificate's weights.

    Raises NoSolutionError at the first bound that is not proved; the message names a plant and a
    frequency at which the proof fails.
    """
    if not certificate.bounds:
        raise NoSolutionError(
            "not proved: the certificate states no bound; run frictool synth again"
        )
    proved = []
    for bound in certificate.bounds:
        if bound.of not in loop.quantities:
            raise NoSolutionError(
                f"not proved: {bound.of} < {bound.below:.6g}: this loop has no {bound.of}; "
                f"allowed: {', '.join(loop.quantities)}"
            )
        one = prove_bounds(quantity_loops(loop, bound.of), certificate.box, bound.below)
        if isinstance(one, OpenCell):
            finding = "violated" if one.violated else f"more than {MOST_CELLS} cells are needed"
            raise NoSolutionError(
                f"not proved: {bound.of} < {bound.below:.6g}: {finding} at inertia "
                f"{one.inertia:.6g}, viscous {one.viscous:.6g}, constant {one.constant:.6g} and "
                f"{one.frequency:.4g} rad/s; run frictool synth again"
            )
        proved.append(ProvedBound(bound.of, bound.below, one))
    return tuple(proved)


def prove_bounds(loops: Sequence[CertificateLoop], box: Box, below: float) -> int | OpenCell:
    """Prove that the norms of all `loops` are below `below`; return the total number of cells.

    If a proof fails, return a plant and a frequency at which it fails.
    """
    cells = 0
    for loop in loops:
        one = prove_bound(loop, box, below)
        if isinstance(one, OpenCell):
            return one
        cells += one
    return cells


def prove_bound(loop: CertificateLoop, box: Box, below: float) -> int | OpenCell:
    """Prove that the norm of `loop` is below `below`; return the number of cells.

    If the proof fails, return a plant and a frequency at which it fails. Raises NoSolutionError if
    the loop of the plant in the middle of the box is unstable, or if coefficients are out of the
    range of doubles.
    """
    try:
        return _prove_bound(loop, box, below)
    except (OverflowError, ValueError, ZeroDivisionError) as error:
        raise NoSolutionError(f"not proved: the loop cannot be evaluated ({error})") from None


def _prove_bound(loop: CertificateLoop, box: Box, below: float) -> int | OpenCell:
    plants = _kernel_box(box, loop.period)
    drive, viscous = _surroundings(box, loop.period)
    middle = _middle(box, loop.period)
    ratio = Fraction(loop.period) / Fraction(loop.lag) if loop.lag else Fraction(0)
    check_range(ratio, *viscous)
    at = np.zeros(3)
    cells = 0
    stable = False
    for low, high in _pieces(viscous):
        one = _kernel_loop(loop, hold_polynomials(ratio, low, high))
        centre = Fraction(one.middle)
        if not stable and low <= middle[1] <= high:
            _require_stable(one, plants, (float(middle[0]), float(middle[1] - centre)))
            stable = True
        for chart in (0, 1):
            start = np.array(
                [0.0, 1.0, _down(drive[0]), _up(drive[1]), _down(low - centre), _up(high - centre)]
            )
            outcome, count = explore(one, plants, chart, start, below, MOST_CELLS - cells, at)
            cells += count
            if outcome != PROVED:
                return _open_cell(at, chart, plants, loop.period, outcome == VIOLATED)
    if not stable:
        raise ValueError("no plant is in the middle of the box")
    return cells


def _require_stable(loop: KernelLoop, plants: KernelBox, plant: tuple[float, float]) -> None:
    """Raise NoSolutionError unless the loop of one plant is proved to be stable.

    plant: pair (kappa, sigma - middle), see zero_exclusion_kernel.py.
    """
    order = loop.denominator.shape[1] + int(not loop.free) + int(loop.lagged) + loop.delay
    angle, error = turn(loop, plants, plant, MOST_CELLS)
    if not abs(angle - 0.5 * math.pi * order) + error < 0.25 * math.pi:
        raise NoSolutionError(
            "not proved: the loop of the plant in the middle of the intervals is unstable; run "
            "frictool synth again"
        )


def _kernel_box(box: Box, period: float) -> KernelBox:
    t = Fraction(period)
    inertia, constant, viscous = _ends(box.inertia), _ends(box.constant), _ends(box.viscous)
    return KernelBox(
        (_down(t * t / inertia[1]), _up(t * t / inertia[0])),
        (_down(constant[0]), _up(constant[1])),
        (_down(viscous[0] / t), _up(viscous[1] / t)),
        max(abs(value) for value in box.coulomb),
    )


def _surroundings(box: Box, period: float) -> tuple[Interval, Interval]:
    t = Fraction(period)
    inertia, constant = _ends(box.inertia), _ends(box.constant)
    rates = [end * t / j for end in _ends(box.viscous) for j in inertia]
    return (
        (constant[0] * t * t / inertia[1], constant[1] * t * t / inertia[0]),
        (min(rates), max(rates)),
    )


def _middle(box: Box, period: float) -> tuple[Fraction, Fraction]:
    t = Fraction(period)
    inertia, constant, viscous = (
        (low + high) / 2 for low, high in map(_ends, (box.inertia, box.constant, box.viscous))
    )
    return constant * t * t / inertia, viscous * t / inertia


def _pieces(interval: Interval) -> Iterator[Interval]:
    low, high = interval
    count = max(1, math.ceil(high - low))
    for index in range(count):
        yield low + (high - low) * index / count, low + (high - low) * (index + 1) / count


def _kernel_loop(loop: CertificateLoop, holds: HoldPolynomials) -> KernelLoop:
    period = Fraction(loop.period)
    feedback = feedback_polynomials(loop)
    numerator, measured, denominator = (
        on_circle(polynomial)
        for polynomial in (feedback.numerator, feedback.measured, feedback.denominator)
    )
    scale = Fraction(2) ** -math.frexp(float(max(map(abs, denominator))))[1]
    weights = loop.weights
    return KernelLoop(
        numerator=_charts(numerator, scale),
        measured=_charts(measured, scale),
        denominator=_charts(denominator, scale),
        holds=np.array(
            [[complex(value) for value in row] for row in holds.coefficients], np.complex128
        ),
        errors=np.array([_up(error) for error in holds.errors]),
        middle=float(holds.middle),
        lagged=loop.lag > 0.0,
        lost=_lost(holds, loop.lag),
        kept=float(1 + holds.kept),
        delay=loop.delay,
        speed=loop.controlled == "speed",
        free=feedback.free,
        period=loop.period,
        error=_filter(weights.error, period),
        noise=_filter(weights.noise, period),
        disturbance=weights.disturbance,
        drive=weights.drive,
        command=weights.command,
        eta=weights.eta,
    )


def _lost(holds: HoldPolynomials, lag: float) -> float:
    """Return 1 - exp(-period/lag) as a double.

    Raises ValueError if the enclosure of the exponential is too wide.
    """
    lost = 1 - holds.kept
    if lag and holds.kept_error > ROUNDING / 4 * lost:
        raise ValueError("actuator.loop_time_constant_s is too long for this period")
    return float(lost)


def _charts(polynomial: Polynomial, scale: Fraction) -> ComplexVector:
    turns = (1.0 + 0j, 1j, -1.0 + 0j, -1j)  # i^j, exact
    values = [float(value * scale) for value in polynomial]
    row = [complex(x * turns[j % 4].real, x * turns[j % 4].imag) for j, x in enumerate(values)]
    return np.array([row, row[::-1]], np.complex128)


def _filter(weight: Filter, period: Fraction) -> tuple[float, float, float]:
    zero, pole = (
        0.0 if value is None else float(2 / (period * Fraction(value)))
        for value in (weight.zero, weight.pole)
    )
    return weight.gain, zero, pole


def _open_cell(
    at: Vector, chart: int, plants: KernelBox, period: float, violated: bool
) -> OpenCell:
    t, kappa, sigma = (float(value) for value in at)
    alpha = min(plants.inverse[1], kappa / plants.drive[0])
    if plants.viscous[0] > 0.0:
        alpha = min(alpha, sigma / plants.viscous[0])
    inertia = period * period / alpha
    angle = 2.0 * math.atan(t) if chart == 0 else math.pi - 2.0 * math.atan(t)
    return OpenCell(inertia, sigma / alpha * period, kappa / alpha, angle / period, violated)


def _ends(interval: tuple[float, ...]) -> Interval:
    return Fraction(interval[0]), Fraction(interval[1])


def _down(value: Fraction) -> float:
    near = float(value)
    return near if Fraction(near) <= value else math.nextafter(near, -math.inf)


def _up(value: Fraction) -> float:
    return -_down(-value)
