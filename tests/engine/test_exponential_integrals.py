"""Integrals of exponentials against 150-digit decimal arithmetic, equal and nearly equal rates
included."""

from __future__ import annotations

from decimal import Decimal, localcontext

from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.engine.exponential_integrals import (
    convolved,
    convolved_integral,
    phi1,
    phi1_slope,
    phi2,
)

ARGUMENTS = st.one_of(st.just(0.0), st.floats(-50.0, -1e-3), st.floats(-1e-3, -1e-25))
RATES = st.one_of(st.just(0.0), st.floats(1e-3, 1e4))


def _phi1(x: Decimal) -> Decimal:
    return Decimal(1) if x == 0 else (x.exp() - 1) / x


def _phi2(x: Decimal) -> Decimal:
    return Decimal("0.5") if x == 0 else (x.exp() - 1 - x) / x**2


def _close(found: float, exact: Decimal, tolerance: float = 2e-14) -> bool:
    return abs(Decimal(found) - exact) <= Decimal(tolerance) * abs(exact)


@settings(derandomize=True, deadline=None)
@given(x=ARGUMENTS)
def test_phi(x: float) -> None:
    with localcontext() as context:
        context.prec = 150
        exact = Decimal(x)
        slope = Decimal("0.5") if x == 0 else (exact.exp() - _phi1(exact)) / exact
        assert _close(phi1(x), _phi1(exact))
        assert _close(phi2(x), _phi2(exact))
        assert _close(phi1_slope(x), slope)


@settings(max_examples=2 * settings.default.max_examples)
@given(
    a=RATES,
    t=st.floats(1e-6, 1.0),
    b=RATES,
    apart=st.sampled_from([None, 0.0, 1e-15, 1e-9, 1e-3, 0.019, 0.021]),
)
def test_convolutions(a: float, t: float, b: float, apart: float | None) -> None:
    if apart is not None:
        b = a * (1.0 + apart)  # equal, or on either side of where averaging takes over
    if max(a, b) * t > 600.0:
        t = 600.0 / max(a, b)
    with localcontext() as context:
        context.prec = 150
        p, q, time = Decimal(a), Decimal(b), Decimal(t)
        if p == q:
            q = p + Decimal("1e-25") * max(p, Decimal(1))
        once = ((-q * time).exp() - (-p * time).exp()) / (p - q)
        twice = time * (_phi1(-q * time) - _phi1(-p * time)) / (p - q)
        assert _close(convolved(a, b, t), once, 2e-13)
        assert _close(convolved_integral(a, b, t), twice, 2e-13)
        assert convolved(a, b, t) == convolved(b, a, t)
