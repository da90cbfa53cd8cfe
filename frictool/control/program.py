"""List of the operations of a controller or observer, for simulation and for export.

    block files ──write into──▶ Program ──▶ compiled_program.py  double and float, simulated
                                        ──▶ fixed_point.py       q31 and q15, with the interval of
                                                                 every value
                                        ──▶ export/              the same operations in C, in the
                                                                 same order

A node (`ProgramNode`) is one operation and its result. Every operation runs at every sample, so
that each sample takes the same time. No operation is reordered or fused with another: results agree
bit by bit wherever the arithmetic is IEEE.

A state keeps a value from one sample to the next. `Program.update` defines its next value. A state
without an update, such as a scheduled parameter, is set by the caller. `low` and `high` bound a
state or an input; they determine the scaling of fixed point, in which states and inputs saturate at
these bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

LOGICAL = frozenset({"lt", "le", "and", "or", "not", "valid"})


@dataclass(frozen=True)
class ProgramNode:
    """One operation of a program and its result.

    args: operands. The operation `dot`, a sum of products, has n coefficients followed by n values.
    """

    program: Program = field(repr=False, compare=False)
    index: int
    op: str  # "constant", "input", "state", or a key of operation_codes.CODES
    args: tuple[ProgramNode, ...] = field(default=(), repr=False, compare=False)
    value: float = 0.0  # value of a constant, or start value of a state
    low: float = 0.0  # bounds of an input or a state
    high: float = 0.0

    def __add__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("add", self, other)

    def __sub__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("sub", self, other)

    def __mul__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("mul", self, other)

    def __neg__(self) -> ProgramNode:
        return self.program.node("neg", self)

    def __abs__(self) -> ProgramNode:
        return self.program.node("abs", self)

    def __lt__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("lt", self, other)

    def __gt__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("lt", other, self)

    def __le__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("le", self, other)

    def __ge__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("le", other, self)

    def __and__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("and", self, other)

    def __or__(self, other: ProgramNode) -> ProgramNode:
        return self.program.node("or", self, other)

    def __invert__(self) -> ProgramNode:
        return self.program.node("not", self)

    @property
    def is_logical(self) -> bool:
        """Return True for a logical value: a comparison, or a selection between logical values."""
        return self.op in LOGICAL or (self.op == "select" and self.args[1].is_logical)


class GuardNodes(NamedTuple):
    """Nodes of the measurement guard (control/measurement_guard.py).

    - left: the state `holds_left`, the number of further invalid samples before the fault
    - left_now: next value of this state
    - hold: the constant `hold_samples`
    - used: the inputs by name, after the guard has replaced invalid inputs
    - fault: node that is true in the fault state
    """

    left: ProgramNode
    left_now: ProgramNode
    hold: ProgramNode
    used: dict[str, ProgramNode]
    fault: ProgramNode


class Program:
    """Operations in the order in which they run, and the states kept between samples."""

    def __init__(self) -> None:
        self.nodes: list[ProgramNode] = []
        self.names: dict[int, str] = {}  # node -> its name in the exported code
        self.comments: dict[int, str] = {}  # first node of a block -> the block's comment
        self.updates: dict[int, ProgramNode] = {}  # state -> its value at the next sample
        self.starts: dict[int, str] = {}  # state -> name of the input that gives its start value
        self.inputs: dict[str, ProgramNode] = {}
        self.states: dict[str, ProgramNode] = {}
        self.output: ProgramNode | None = None
        self.guard: GuardNodes | None = None  # the guard's operations come first
        self.speed: ProgramNode | None = None  # speed that the blocks of a controller use
        self.profile: ProgramNode | None = None  # profile that the loop of a controller tracks
        self._comment = ""
        self._constants: dict[tuple[str, float], ProgramNode] = {}

    @property
    def constant_states(self) -> list[ProgramNode]:
        """Return the states that the caller sets, such as scheduled parameters."""
        return [node for node in self.states.values() if node.index not in self.updates]

    def node(
        self, op: str, *args: ProgramNode, value: float = 0.0, low: float = 0.0, high: float = 0.0
    ) -> ProgramNode:
        """Append one operation and return its node."""
        made = ProgramNode(self, len(self.nodes), op, args, value, low, high)
        self.nodes.append(made)
        if self._comment and op not in ("constant", "input", "state"):
            self.comments[made.index] = self._comment
            self._comment = ""
        return made

    def block(self, comment: str) -> None:
        """Set a one-line comment that appears before the next operation in the exported code."""
        self._comment = comment

    def named(self, name: str, node: ProgramNode) -> ProgramNode:
        """Name a node in the exported code and return the node; a node keeps its first name."""
        self.names.setdefault(node.index, name)
        return node

    def constant(self, value: float, name: str = "") -> ProgramNode:
        """Return the node of a constant; if `name` is empty, the C code contains the number."""
        key = (name, float(value))
        if key not in self._constants:
            self._constants[key] = self.node("constant", value=float(value))
            if name:
                self.names[self._constants[key].index] = name
        return self._constants[key]

    def input(self, name: str, low: float, high: float) -> ProgramNode:
        """Add an input, which the caller sets at every sample, and return its node."""
        self.inputs[name] = self.named(name, self.node("input", low=low, high=high))
        return self.inputs[name]

    def state(self, name: str, low: float, high: float, start: float | str = 0.0) -> ProgramNode:
        """Add a state and return the node of its value at the start of a sample.

        start: value at the first sample, a number or the name of an input.
        """
        made = self.node(
            "state", value=0.0 if isinstance(start, str) else start, low=low, high=high
        )
        self.states[name] = self.named(name, made)
        if isinstance(start, str):
            self.starts[made.index] = start
        return made

    def update(self, name: str, value: ProgramNode) -> None:
        """Define the value to which a state is set at the end of each sample."""
        self.updates[self.states[name].index] = value

    def last(self, name: str, value: ProgramNode, start: float | str) -> ProgramNode:
        """Return a state that contains `value` as it was one sample ago.

        - name: name of the state without the suffix `_before`; a second call with this name
          returns the same state
        - start: value at the first sample, a number or the name of an input
        """
        state = self.states.get(f"{name}_before")
        if state is None:
            state = self.state(f"{name}_before", value.low, value.high, start)
            self.update(f"{name}_before", value)
        return state

    def valid(self, one: ProgramNode) -> ProgramNode:
        """Return a node that is true if an input is a finite number.

        Raises ValueError if `one` is not an input of the program.
        """
        if one.op != "input":
            raise ValueError(
                f"the operand of `valid` is {one.op}; allowed: an input of the program, because no "
                "other value can be NaN or infinite"
            )
        return self.node("valid", one)

    def smaller(self, one: ProgramNode, other: ProgramNode) -> ProgramNode:
        """Return the smaller of two values."""
        return self.node("min", one, other)

    def larger(self, one: ProgramNode, other: ProgramNode) -> ProgramNode:
        """Return the larger of two values."""
        return self.node("max", one, other)

    def sqrt(self, one: ProgramNode) -> ProgramNode:
        """Return the square root of a value that is not negative."""
        return self.node("sqrt", one)

    def select(
        self, condition: ProgramNode, then: ProgramNode, otherwise: ProgramNode
    ) -> ProgramNode:
        """Return `then` if the condition is true, else `otherwise`."""
        return self.node("select", condition, then, otherwise)

    def polynomial(self, x: ProgramNode, coefficients: Sequence[ProgramNode]) -> ProgramNode:
        """Return the value of a polynomial at x; `coefficients`: lowest power first."""
        total = coefficients[-1]
        for coefficient in reversed(coefficients[:-1]):
            total = total * x + coefficient
        return total

    def dot(
        self, coefficients: Sequence[ProgramNode], values: Sequence[ProgramNode]
    ) -> ProgramNode:
        """Return the sum of coefficients[i] values[i].

        Raises ValueError if the numbers of coefficients and values differ or are 0.
        """
        if not coefficients or len(coefficients) != len(values):
            raise ValueError(
                f"dot product of {len(coefficients)} coefficients and {len(values)} values; "
                "allowed: as many values as coefficients, at least one of each"
            )
        return self.node("dot", *coefficients, *values)
