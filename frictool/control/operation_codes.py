"""The codes of a program's operations, and the columns of its arrays, for the kernels."""

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

# columns of `code`: operation, index of the result, indices of the operands; the operands of a dot
# are its first row of `terms` and the row behind its last

# last column of `terms`, behind the indices of coefficient and value: the right shift of their
# product in fixed point
TERM_SHIFT = 2
# columns of `formats`, one row per value: the fraction, the words at which an input or a state
# saturates, and the shifts of its operation
FRACTION, LOW, HIGH, SHIFT_A, SHIFT_B, SHIFT = range(6)
