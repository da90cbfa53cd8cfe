"""Numeric codes of a program's operations, and columns of the arrays that the kernels read."""

from __future__ import annotations

ADD, SUB, MUL, NEG, ABS, MIN, MAX, SQRT, LT, LE, AND, OR, NOT, SELECT, DOT, VALID = range(16)
CODES = {
    "add": ADD,
    "sub": SUB,
    "mul": MUL,
    "neg": NEG,
    "abs": ABS,
    "min": MIN,
    "max": MAX,
    "sqrt": SQRT,
    "lt": LT,
    "le": LE,
    "and": AND,
    "or": OR,
    "not": NOT,
    "select": SELECT,
    "dot": DOT,
    "valid": VALID,
}

# columns of `code`: operation, index of the result, indices of the operands; the operation dot has,
# in place of operands, the index of its first row in `terms` and the index after its last row

# column of `terms` with the right shift of a product in fixed point; the first two columns are the
# indices of coefficient and value
TERM_SHIFT = 2
# columns of `formats`, one row per value: the fraction, the words at which an input or a state
# saturates, and the shifts of its operation
FRACTION, LOW, HIGH, SHIFT_A, SHIFT_B, SHIFT = range(6)
