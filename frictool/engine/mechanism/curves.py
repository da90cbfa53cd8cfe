"""Values of the curves of `PackedMechanism`: piecewise cubic, constant outside their range."""

from __future__ import annotations

from frictool.engine.mechanism import array_layout as ly
from frictool.runtime.kernels import bare_kernel
from frictool.typing import IntVector, Vector


@bare_kernel
def _piece(k: IntVector, p: Vector, curve: int, x: float) -> tuple[int, float]:
    first = k[k[ly.CURVE_START] + curve]
    last = k[k[ly.CURVE_START] + curve + 1]
    breaks = k[ly.BREAKS] + curve
    x = min(max(x, p[breaks + first]), p[breaks + last])
    low = first
    high = last - 1
    while low < high:
        middle = (low + high + 1) // 2
        if p[breaks + middle] <= x:
            low = middle
        else:
            high = middle - 1
    return low, x


@bare_kernel
def curve_value(k: IntVector, p: Vector, curve: int, x: float) -> float:
    """Return the value of a curve at x."""
    piece, at = _piece(k, p, curve, x)
    s = at - p[k[ly.BREAKS] + curve + piece]
    c = k[ly.CUBIC] + 4 * piece
    return float(p[c] + s * (p[c + 1] + s * (p[c + 2] + s * p[c + 3])))


@bare_kernel
def curve_integral(k: IntVector, p: Vector, curve: int, x: float) -> float:
    """Return the integral of a curve from the start of its range to x."""
    first = k[k[ly.CURVE_START] + curve]
    breaks = k[ly.BREAKS] + curve
    piece, at = _piece(k, p, curve, x)
    total = 0.0
    for i in range(first, piece + 1):
        s = (at if i == piece else p[breaks + i + 1]) - p[breaks + i]
        c = k[ly.CUBIC] + 4 * i
        total += s * (p[c] + s * (p[c + 1] / 2.0 + s * (p[c + 2] / 3.0 + s * p[c + 3] / 4.0)))
    return total + (x - at) * curve_value(k, p, curve, x)
