"""Ticks of an axis at round numbers, and their labels."""

from __future__ import annotations

import math
from dataclasses import dataclass

STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
MOST, FEWEST = 9, 2  # number of ticks on an axis
# decimal exponents of the largest tick for which the labels need no common factor
PLAIN = range(-4, 6)


@dataclass(frozen=True)
class AxisTicks:
    """Ticks at the values `at` with the labels `labels`, and short ticks at `minor` without labels.

    - factor: common factor of the labels, such as 1e6; empty if there is none
    - has_grid: True if grid lines are drawn at the ticks
    """

    at: tuple[float, ...]
    labels: tuple[str, ...]
    minor: tuple[float, ...] = ()
    factor: str = ""
    has_grid: bool = True


def linear_ticks(ends: tuple[float, float], most: int, least_step: float = 0.0) -> AxisTicks:
    """Return ticks at round numbers between `ends`, at most `most` + 1 ticks if possible.

    least_step: smallest allowed distance of two ticks; 1 for whole numbers. With 0, the axis
        has a grid and at least FEWEST ticks, even if this number exceeds `most`.
    """
    low, high = ends
    most = most if least_step > 0.0 else min(max(most, 1), MOST)
    step = max(_rounded_up((high - low) / most), least_step)
    at = _multiples(low, high, step)
    while len(at) < FEWEST and least_step == 0.0:
        step = _rounded_up(0.4 * step)
        at = _multiples(low, high, step)
    largest = max((abs(one) for one in at), default=0.0)
    exponent = math.floor(math.log10(largest)) if largest > 0.0 else 0
    exponent = 0 if exponent in PLAIN else exponent
    decimals = _decimals(step / 10.0**exponent)
    labels = tuple(_minus(f"{one / 10.0**exponent:.{decimals}f}") for one in at)
    factor = _minus(f"1e{exponent}") if exponent else ""
    return AxisTicks(tuple(at), labels, factor=factor, has_grid=least_step == 0.0)


def log_ticks(ends: tuple[float, float]) -> AxisTicks:
    """Return ticks at powers of ten between `ends`, and short ticks at 2 to 9 times a power."""
    low, high = ends
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    at = tuple(10.0**one for one in decades if low <= 10.0**one <= high)
    minor = tuple(
        part * 10.0**one
        for one in decades
        for part in range(2, 10)
        if low <= part * 10.0**one <= high
    )
    return AxisTicks(at, tuple(_minus(f"{one:g}") for one in at), minor)


def _rounded_up(step: float) -> float:
    scale = 10.0 ** math.floor(math.log10(step))
    return next(part * scale for part in STEPS if part * scale >= step * (1.0 - 1e-9))


def _multiples(low: float, high: float, step: float) -> list[float]:
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [index * step for index in range(first, last + 1)]


def _decimals(step: float) -> int:
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return decimals + (abs(step * 10.0**decimals - round(step * 10.0**decimals)) > 1e-6)


def _minus(text: str) -> str:
    return text.replace("-", "\N{MINUS SIGN}")
