"""The codes of a program's operations, and the columns of its arrays, as kernels know them."""

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

# `code`: operation, place of the result, places of the operands; of a dot its first row of `terms`,
# and the one behind its last
OPERATION, RESULT, FIRST, SECOND, THIRD = range(5)
# `terms`: places of coefficient and value, and how far their product is shifted to the right in
# fixed point
COEFFICIENT, VALUE, TERM_SHIFT = range(3)
# `formats`, by place: fixed point's fraction, the words at which an input or a state saturates, and
# the shifts of its operation
FRACTION, LOW, HIGH, SHIFT_A, SHIFT_B, SHIFT = range(6)
