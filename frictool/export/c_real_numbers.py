"""C expressions in double or float, rounded and ordered as in the simulation."""

from __future__ import annotations

import math

import numpy as np

from frictool.control.program import ProgramNode
from frictool.errors import NoSolutionError
from frictool.export.c_names import NamedArray

INFIX = {"add": "+", "sub": "-", "mul": "*", "lt": "<", "le": "<=", "and": "&&", "or": "||"}
MIRRORED = {"lt": ">", "le": ">="}
HELPERS = {"abs": "absolute", "min": "smaller", "max": "larger", "valid": "is_valid"}
COMPARED = ("add", "sub", "lt", "le")
LOOSER = {
    "mul": COMPARED,
    "dot": (),
    "add": COMPARED[2:],
    "sub": COMPARED[2:],
    "lt": ("and", "or"),
    "le": ("and", "or"),
}


class RealNumbers:
    """Writer of numbers in `kind`, the C type double or float."""

    def __init__(self, kind: str) -> None:
        self.kind = self.constant_kind = kind
        self.printed = "%a"
        self.cast = "" if kind == "double" else "(double)"
        self.words = ""
        self.suffix = "f" if kind == "float" else ""

    def literal(self, value: float) -> str:
        """Return a C literal with the fewest digits that preserve every bit.

        Raises NoSolutionError if the value is beyond the range of float.

        >>> RealNumbers("double").literal(0.1), RealNumbers("float").literal(0.1)
        ('0.1', '0.1f')
        >>> RealNumbers("double").literal(1e-05)
        '1e-05'
        """
        if self.kind == "double":
            return repr(value)
        with np.errstate(over="ignore", under="ignore"):
            rounded = float(np.float32(value))
        if not math.isfinite(rounded) or (rounded == 0.0) != (value == 0.0):
            raise NoSolutionError(
                f"{value:.3g} is beyond the range of float; use --number double, or "
                "other units in the design"
            )
        return f"{np.float32(value)!s}f"

    def exact(self, value: float, node: ProgramNode) -> str:
        """Return a literal that preserves every bit; NAN and INFINITY are macros of math.h."""
        if not math.isfinite(value):
            return "NAN" if math.isnan(value) else f"{'-' if value < 0.0 else ''}INFINITY"
        return value.hex() + self.suffix

    def constant(self, node: ProgramNode) -> str:
        """Return the C literal of a coefficient, for its declaration."""
        return self.literal(node.value)

    def number(self, node: ProgramNode) -> str:
        """Return the C literal of a number without a name, for use in an expression."""
        text = self.literal(node.value)
        return f"({text})" if text.startswith("-") else text

    @property
    def largest(self) -> str:
        """Return the largest finite number of the format."""
        return self.literal(
            float(np.finfo(np.float64 if self.kind == "double" else np.float32).max)
        )

    def parameter(self, name: str) -> str:
        """Return the parameter name of the input `name` in the C step function."""
        return name

    def entering(self, node: ProgramNode, name: str) -> list[str]:
        """Return an empty list, because a real input needs no declaration with a bound."""
        return []

    def valid(self, text: str) -> str:
        """Return the C condition that an input is a finite number."""
        return f"is_valid({text})"

    def started(self, state: ProgramNode, source: ProgramNode | None) -> str:
        """Return the C text of a state's initial value.

        The value is a number, or the position at the start if `source` is the node of the position.
        """
        return "position" if source is not None else self.literal(state.value)

    def stored(self, state: ProgramNode, source: ProgramNode | None, text: str) -> str:
        """Return `text`, because states and values have the same number format."""
        return text

    def fractions(self, table: NamedArray) -> str:
        """Return "", because real numbers have no fraction bits."""
        return ""

    def expression(self, node: ProgramNode, of: list[str]) -> str:
        """Return the C expression of a node.

        `of`: C expressions of the node's operands.
        """
        args = node.args
        match node.op:
            case "dot":
                half = len(of) // 2
                return " + ".join(f"{c} * {x}" for c, x in zip(of[:half], of[half:], strict=True))
            case "abs" | "min" | "max" | "valid":
                return f"{HELPERS[node.op]}({', '.join(of)})"
            case "sqrt":
                return f"sqrt{self.suffix}({of[0]})"
            case "neg":
                return f"-{of[0]}"
            case "not":
                return f"!{of[0]}"
            case "select":
                return f"{of[0]} ? {of[1]} : {of[2]}"
            case "lt" | "le" if args[0].op == "constant" and args[1].op != "constant":
                return f"{of[1]} {MIRRORED[node.op]} {of[0]}"
            case _:
                return f"{of[0]} {INFIX[node.op]} {of[1]}"

    def closed(self, node: ProgramNode, text: str, within: ProgramNode) -> str:
        """Return `text`, the C expression of `node`, as an operand.

        `within`: node whose expression contains the operand. The operand is put in brackets if C or
        a reader could group the operations differently.
        """
        if node.op in HELPERS or node.op == "sqrt" or within.op in HELPERS or within.op == "sqrt":
            return text
        return text if within.op in LOOSER.get(node.op, ()) else f"({text})"

    def note(self, node: ProgramNode) -> str:
        """Return "", because a real number needs no comment on its resolution."""
        return ""
