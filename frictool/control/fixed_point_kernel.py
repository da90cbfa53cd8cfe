"""Integer arithmetic of the fixed-point formats, identical to the exported C.

    value = word 2^-fraction

Every value is a 32-bit word; sums and products have 64 bits. Words of inputs and states saturate at
their bounds. Right shifts round to nearest, ties away from zero, so that a mirrored input gives the
mirrored drive. No operation overflows, since control/fixed_point.py chooses every fraction from the
proved interval of the value.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictool.control import operation_codes as op
from frictool.runtime.kernels import bare_kernel, kernel
from frictool.typing import IntVector

Rows = NDArray[np.uint32]
INVALID = -(2**31)  # word of a value that is not finite; every other word is above it


@kernel
def shift_rounded(value: int, shift: int) -> int:
    """Return `value` times 2^-shift, rounded to nearest with ties away from zero."""
    if shift <= 0:
        return value << -shift
    half = 1 << (shift - 1)
    return (value + half) >> shift if value >= 0 else -((half - value) >> shift)


@kernel
def whole_root(value: int) -> int:
    """Return the integer square root of `value` >= 0, rounded down."""
    root = 0
    bit = 1 << 62
    while bit > value:
        bit >>= 2
    while bit != 0:
        if value >= root + bit:
            value -= root + bit
            root = (root >> 1) + bit
        else:
            root >>= 1
        bit >>= 2
    return root


@kernel
def from_real(form: IntVector, value: float) -> int:
    """Return the fixed-point word nearest to a value, saturated; INVALID for NaN or infinity.

    Ties round to even.

    - form: row of `CompiledProgram.formats` that belongs to the value
    """
    if not math.isfinite(value):
        return INVALID
    scaled = math.ldexp(value, form[op.FRACTION])
    if scaled >= float(form[op.HIGH]):
        return int(form[op.HIGH])
    if scaled <= float(form[op.LOW]):
        return int(form[op.LOW])
    return int(np.rint(scaled))


@kernel
def to_real(form: IntVector, word: int) -> float:
    """Return the exact value of a fixed-point word; NaN for INVALID.

    form: row of `CompiledProgram.formats` that belongs to the value.
    """
    return math.nan if word == INVALID else math.ldexp(float(word), -form[op.FRACTION])


@bare_kernel
def run_words(
    code: Rows, terms: Rows, writes: Rows, formats: IntVector, w: IntVector, first: int
) -> None:
    """Run the operations of one sample in fixed point on the integer words w, in place.

    first: first row of `code` to run. The other arrays are fields of `CompiledProgram`.
    """
    for k in range(first, code.shape[0]):
        operation = code[k, 0]
        d = code[k, 1]
        a = code[k, 2]
        b = code[k, 3]
        c = code[k, 4]
        sa, sb, s = formats[d, op.SHIFT_A], formats[d, op.SHIFT_B], formats[d, op.SHIFT]
        if operation == op.DOT:
            total = shift_rounded(w[terms[a, 0]] * w[terms[a, 1]], terms[a, op.TERM_SHIFT])
            for j in range(a + 1, b):
                total += shift_rounded(w[terms[j, 0]] * w[terms[j, 1]], terms[j, op.TERM_SHIFT])
            w[d] = shift_rounded(total, s)
        elif operation == op.ADD:
            w[d] = shift_rounded(shift_rounded(w[a], sa) + shift_rounded(w[b], sb), s)
        elif operation == op.SUB:
            w[d] = shift_rounded(shift_rounded(w[a], sa) - shift_rounded(w[b], sb), s)
        elif operation == op.MUL:
            w[d] = shift_rounded(w[a] * w[b], s)
        elif operation == op.SELECT:
            w[d] = shift_rounded(w[b], sa) if w[a] != 0 else shift_rounded(w[c], sb)
        elif operation == op.LT:
            w[d] = 1 if shift_rounded(w[a], sa) < shift_rounded(w[b], sb) else 0
        elif operation == op.LE:
            w[d] = 1 if shift_rounded(w[a], sa) <= shift_rounded(w[b], sb) else 0
        elif operation == op.AND:
            w[d] = 1 if w[a] != 0 and w[b] != 0 else 0
        elif operation == op.OR:
            w[d] = 1 if w[a] != 0 or w[b] != 0 else 0
        elif operation == op.NOT:
            w[d] = 1 if w[a] == 0 else 0
        elif operation == op.NEG:
            w[d] = -w[a]
        elif operation == op.ABS:
            w[d] = -w[a] if w[a] < 0 else w[a]
        elif operation == op.MIN:
            w[d] = min(shift_rounded(w[a], sa), shift_rounded(w[b], sb))
        elif operation == op.MAX:
            w[d] = max(shift_rounded(w[a], sa), shift_rounded(w[b], sb))
        elif operation == op.SQRT:
            w[d] = whole_root(w[a] << s)
        elif operation == op.VALID:
            w[d] = 1 if w[a] != INVALID else 0
    kept = w.shape[0] - writes.shape[0]
    for k in range(writes.shape[0]):
        w[kept + k] = w[writes[k, 1]]
    for k in range(writes.shape[0]):
        state = writes[k, 0]
        w[state] = min(
            max(shift_rounded(w[kept + k], formats[kept + k, op.SHIFT]), formats[state, op.LOW]),
            formats[state, op.HIGH],
        )
