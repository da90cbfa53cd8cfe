"""Exact polynomials of the complete feedback from position and speed to the drive.

With eta = -position, the controller C = N/A and the filter of the speed F = N_F/A_F:

    no feedback of the speed                drive = C eta
    speed from differences of positions     drive = C (F (z - 1)/(T z) + g) eta
    measured speed, which is not filtered   drive = C (g eta - speed)

T is the sample period. g is the gain of the proportional law, or 0 if there is no such law. All
arithmetic uses integers and fractions.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from frictool.control.speed_filter import first_order
from frictool.verify.bilinear_polynomials import (
    Polynomial,
    of_sections,
    of_state_space,
    product,
    total,
)
from frictool.verify.certificate_loop import CertificateLoop, SpeedFeedback


@dataclass(frozen=True)
class FeedbackPolynomials:
    """Polynomials in z with drive = (numerator * eta - measured * speed)/denominator.

    eta is minus the position. `numerator` and `measured` have as many coefficients as the
    denominator; `measured` is empty if no sensor measures the speed. If `free` is True, the loop
    feeds back the speed only. Then drive = (numerator * (z - 1) * eta - measured *
    speed)/denominator, and the numerator is zero or has one coefficient less.
    """

    numerator: Polynomial
    measured: Polynomial
    denominator: Polynomial
    free: bool = False


def feedback_polynomials(loop: CertificateLoop) -> FeedbackPolynomials:
    """Return the exact polynomials of the feedback from position and speed to the drive."""
    numerator, denominator = (
        of_sections(loop.sections) if loop.sections else of_state_space(loop.controller)
    )
    if loop.speed is None:
        return FeedbackPolynomials(numerator, [], denominator)
    gain = Fraction(loop.speed.position_gain)
    if loop.speed.velocity.source == "measured":
        outer = product(numerator, [gain])
        return FeedbackPolynomials(outer, numerator, denominator, free=not gain)
    passed, filtered = _filter(loop.speed, loop.period)
    period = Fraction(loop.period)
    motion = product(numerator, passed)
    whole = product(product(denominator, filtered), [Fraction(0), period])
    if not gain:
        return FeedbackPolynomials(motion, [], whole, free=True)
    outer = product(product(numerator, filtered), [Fraction(0), gain * period])
    difference = product(motion, [Fraction(-1), Fraction(1)])
    return FeedbackPolynomials(total(outer, difference), [], whole)


def _filter(speed: SpeedFeedback, period: float) -> tuple[Polynomial, Polynomial]:
    passed, filtered = [Fraction(1)], [Fraction(1)]
    bandwidth = speed.velocity.bandwidth_rad_s
    if bandwidth:
        pole, through = map(Fraction, first_order(bandwidth, period))
        for _ in range(speed.velocity.order):
            passed = product(passed, [through, through])
            filtered = product(filtered, [-pole, Fraction(1)])
    return passed, filtered
