"""C expressions in fixed point, equal to control/fixed_point_kernel.py.

control/fixed_point.py determines the shifts:

    value 2^-n, rounded     shifted(value, n) in 64 bits, word(value, n) if the result is a word
    value 2^n               raised(value, n): a product, because a left shift of a negative
                            value is undefined

The word of a value is the int32_t that represents the value. Sums, products and shifted values are
computed in int64_t.
"""

from __future__ import annotations

import math

from frictool.control.fixed_point import FixedProgram
from frictool.control.fixed_point_kernel import shift_rounded
from frictool.control.program import ProgramNode
from frictool.export.c_names import NamedArray
from frictool.export.c_real_numbers import INFIX, MIRRORED

CALLS = ("abs", "min", "max", "sqrt", "mul", "add", "sub", "dot")
EDGE = 2**31


class FixedNumbers:
    """Writer of C expressions and numbers in q31, for the program `scaled` in fixed point.

    `kind`: C type of values.
    `constant_kind`: C type of coefficients.
    `printed`, `cast`: conversion specifier and cast of a value in printf.
    `words`: note on the values in the golden vectors.
    """

    printed, cast = "%ld", "(long)"
    words = ", as words"
    suffix = ""

    def __init__(self, scaled: FixedProgram) -> None:
        self.scaled = scaled
        self.kind = "int32_t"
        self.constant_kind = "int32_t"

    def literal(self, value: float) -> str:
        """Return the text of a number in SI, for macros."""
        return repr(value)

    def exact(self, value: float, node: ProgramNode) -> str:
        """Return the fixed-point integer (word) of a value in SI.

        NaN stands for an invalid input and gives INT32_MIN.
        """
        if math.isnan(value):
            return "INT32_MIN"
        return str(int(math.ldexp(value, self.scaled.fractions[node.index])))

    def constant(self, node: ProgramNode) -> str:
        """Return the word of a coefficient, for its declaration."""
        return str(self.scaled.constants[node.index])

    def number(self, node: ProgramNode) -> str:
        """Return the word of a number without a name, for use in an expression."""
        return _integer(self.scaled.constants[node.index])

    def parameter(self, name: str) -> str:
        """Return the parameter name of the input `name` in the C step function.

        `name` itself is the C variable with the bounded input.
        """
        return f"{name}_word"

    def entering(self, node: ProgramNode, name: str) -> list[str]:
        """Return the C declaration of an input, limited to the allowed range of its word."""
        return [
            f"const int32_t {name} = {self._bounded(node, self.parameter(name))};{self.note(node)}"
        ]

    def valid(self, text: str) -> str:
        """Return the C condition that an input is valid; INT32_MIN stands for an invalid input."""
        return f"{text} != INT32_MIN"

    def started(self, state: ProgramNode, source: ProgramNode | None) -> str:
        """Return the C text of a state's initial value.

        The value is a number, or the position at the start if `source` is the node of the position.
        """
        fractions = self.scaled.fractions
        if source is None:
            return str(round(math.ldexp(state.value, fractions[state.index])))
        position = self._bounded(source, "position")
        shift = fractions[source.index] - fractions[state.index]
        return (
            position
            if shift == 0 and self._range(state) == self._range(source)
            else self._bounded(state, moved(position, shift))
        )

    def stored(self, state: ProgramNode, source: ProgramNode | None, text: str) -> str:
        """Return a C expression that converts the value `text` to the state's number format.

        `source`: node of the value; None if the value already has the number format of the state.
        """
        shift = self.scaled.write_shift[state.index] if source is not None else 0
        if (
            source is not None
            and source.op == "constant"
            and source.index not in self.scaled.program.names
        ):
            return _integer(shift_rounded(self.scaled.constants[source.index], shift))
        return self._bounded(state, moved(text, shift))

    def _range(self, node: ProgramNode) -> tuple[int, int]:
        return self.scaled.words[node.index]

    def _bounded(self, node: ProgramNode, text: str) -> str:
        low, high = self._range(node)
        return f"bounded({text}, {low}, {high})"

    def expression(self, node: ProgramNode, of: list[str]) -> str:
        """Return the C expression of a node.

        `of`: C expressions of the node's operands.
        """
        args = node.args
        sa, sb, s = self.scaled.shifts.get(node.index, (0, 0, 0))
        match node.op:
            case "add" | "sub":
                one, other = self._operand(args[0], of[0], sa), self._operand(args[1], of[1], sb)
                return _word(f"{_long(one)} {INFIX[node.op]} {other}", s)
            case "mul":
                return _word(f"{_long(of[0])} * {of[1]}", s)
            case "dot":
                half = len(of) // 2
                shifts = self.scaled.term_shifts[node.index]
                terms = [
                    moved(f"{_long(c)} * {x}", n)
                    for c, x, n in zip(of[:half], of[half:], shifts, strict=True)
                ]
                return _word(" + ".join(terms), s)
            case "lt" | "le":
                one, other = self._operand(args[0], of[0], sa), self._operand(args[1], of[1], sb)
                if args[0].op == "constant" and args[1].op != "constant":
                    return f"{other} {MIRRORED[node.op]} {one}"
                return f"{one} {INFIX[node.op]} {other}"
            case "min" | "max":
                one, other = self._operand(args[0], of[0], sa), self._operand(args[1], of[1], sb)
                return f"{'smaller' if node.op == 'min' else 'larger'}({one}, {other})"
            case "select":
                return (
                    f"{of[0]} ? {self._operand(args[1], of[1], sa, word=True)} : "
                    f"{self._operand(args[2], of[2], sb, word=True)}"
                )
            case "abs":
                return f"absolute({of[0]})"
            case "neg":
                return f"-{of[0]}"
            case "sqrt":
                return f"whole_root({moved(of[0], -s)})"
            case "not":
                return f"!{of[0]}"
            case "valid":
                return self.valid(self.parameter(of[0]))
            case _:
                return f"{of[0]} {INFIX[node.op]} {of[1]}"

    def _operand(self, node: ProgramNode, text: str, shift: int, word: bool = False) -> str:
        """Return an operand, shifted right by `shift` bits.

        `word`: True if the shifted operand has 32 bits, False if it has 64.
        """
        if node.op == "constant" and node.index not in self.scaled.program.names:
            return _integer(shift_rounded(self.scaled.constants[node.index], shift))
        return (_word if word and shift else moved)(text, shift)

    def closed(self, node: ProgramNode, text: str, within: ProgramNode) -> str:
        """Return `text`, the C expression of `node`, as an operand, in brackets if necessary.

        `within`: node whose expression contains the operand.
        """
        if node.op in CALLS or (node.op in ("lt", "le", "valid") and within.op in ("and", "or")):
            return text
        return f"({text})"

    def fractions(self, table: NamedArray) -> str:
        """Return a C comment with the number of fraction bits of each element of an array."""
        counts = [
            str(self.scaled.fractions[node.index]) if node is not None else "-"
            for _, node in table.elements()
        ]
        one = f"fraction of {table.name}" if len(set(counts)) == 1 else f"fractions of {table.name}"
        return f"/* {one}: {', '.join(counts[:1] if len(set(counts)) == 1 else counts)} */\n"

    def note(self, node: ProgramNode) -> str:
        """Return a C comment with the resolution of a value, such as 2^-20."""
        return "" if node.is_logical else f" /* {power(self.scaled.fractions[node.index])} */"


def power(fraction: int) -> str:
    """Return 2^-fraction as text."""
    return f"2^{-fraction}" if fraction else "1"


def _integer(word: int) -> str:
    if abs(word) >= EDGE:
        return f"INT64_C({word})"
    return str(word) if word >= 0 else f"({word})"


def _long(text: str) -> str:
    return text if text.startswith(("shifted(", "raised(")) else f"(int64_t){text}"


def moved(text: str, shift: int) -> str:
    """Return a C expression for the integer `text` times 2^-shift, rounded to nearest."""
    return (
        text
        if shift == 0
        else f"shifted({text}, {shift})"
        if shift > 0
        else f"raised({text}, {-shift})"
    )


def _word(text: str, shift: int) -> str:
    if shift > 0:
        return f"word({text}, {shift})"
    return f"(int32_t)({text})" if shift == 0 else f"(int32_t)raised({text}, {-shift})"
