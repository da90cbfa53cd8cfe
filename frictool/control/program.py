"""What runs at every sample as a program: one list of operations, from which both the simulation
and the exported code are made.

    block files ──write into──▶ Program ──▶ compiled_program.py      double and float, as the
                                                                     simulation runs them
                                        ──▶ fixed_point.py  q31 and q15, with the interval of every
                                        value
                                        ──▶ export/         the same operations in C, in the same
                                                            order

A value is the result of one operation (`Node`); every operation is done at every sample, and what
depends on a condition is selected, so that a sample always takes the same time. Nothing is
reordered or contracted: results are equal bit by bit wherever IEEE arithmetic is.

A state holds a value from one sample to the next. `update` says what it becomes; one without an
update is set by the caller (a scheduled parameter). `low`, `high` are what a state or an input is
known to stay within: fixed point takes its scaling from them, and saturates there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

Op = Literal[
    "constant",
    "input",
    "state",
    "add",
    "sub",
    "mul",
    "neg",
    "abs",
    "min",
    "max",
    "sqrt",
    "lt",
    "le",
    "and",
    "or",
    "not",
    "select",
    "dot",
    "valid",
]
LOGICAL = frozenset({"lt", "le", "and", "or", "not", "valid"})


@dataclass(frozen=True)
class ProgramNode:
    """One value. `args` are nodes; of a `dot` the coefficients, then as many values. `name` stands
    in the exported code."""

    program: Program = field(repr=False, compare=False)
    index: int
    op: Op
    args: tuple[ProgramNode, ...] = field(default=(), repr=False, compare=False)
    value: float = 0.0  # of a constant; where a state starts
    low: float = 0.0  # of an input or a state
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
        """Whether it is true or false; a selection between two that are is one, too."""
        return self.op in LOGICAL or (self.op == "select" and self.args[1].is_logical)


class GuardNodes(NamedTuple):
    """Nodes of control/measurement_guard.py: the state `holds_left` and its next value, the
    constant hold, the inputs as they are used."""

    left: ProgramNode
    left_now: ProgramNode
    hold: ProgramNode
    used: dict[str, ProgramNode]
    fault: ProgramNode


class Program:
    """The operations in the order in which they are done, and what is kept between samples."""

    def __init__(self) -> None:
        self.nodes: list[ProgramNode] = []
        self.names: dict[int, str] = {}  # node -> its name in the exported code
        self.comments: dict[int, str] = {}  # first node of a block -> what the block is
        self.updates: dict[int, ProgramNode] = {}  # state -> its value at the next sample
        self.starts: dict[
            int, str
        ] = {}  # state -> the input that it starts at, where that is no constant
        self.inputs: dict[str, ProgramNode] = {}
        self.states: dict[str, ProgramNode] = {}
        self.output: ProgramNode | None = None
        self.guard: GuardNodes | None = None  # its operations come first
        self.speed: ProgramNode | None = None  # what the blocks of a controller take for the speed
        self._comment = ""
        self._constants: dict[tuple[str, float], ProgramNode] = {}

    def node(
        self, op: Op, *args: ProgramNode, value: float = 0.0, low: float = 0.0, high: float = 0.0
    ) -> ProgramNode:
        """Appends one operation."""
        made = ProgramNode(self, len(self.nodes), op, args, value, low, high)
        self.nodes.append(made)
        if self._comment and op not in ("constant", "input", "state"):
            self.comments[made.index] = self._comment
            self._comment = ""
        return made

    def block(self, comment: str) -> None:
        """What follows is a block; `comment` is one line for its reader."""
        self._comment = comment

    def named(self, name: str, node: ProgramNode) -> ProgramNode:
        """The node with a name of its own in the exported code; the first name stays."""
        self.names.setdefault(node.index, name)
        return node

    def constant(self, value: float, name: str = "") -> ProgramNode:
        """A coefficient. Numbers without a name (0, 1, 2) are written where they stand."""
        key = (name, float(value))
        if key not in self._constants:
            self._constants[key] = self.node("constant", value=float(value))
            if name:
                self.names[self._constants[key].index] = name
        return self._constants[key]

    def input(self, name: str, low: float, high: float) -> ProgramNode:
        """What the caller gives at every sample."""
        self.inputs[name] = self.named(name, self.node("input", low=low, high=high))
        return self.inputs[name]

    def state(self, name: str, low: float, high: float, start: float | str = 0.0) -> ProgramNode:
        """What it was after the last sample; at first `start`, a number or the name of an input at
        the first sample."""
        made = self.node(
            "state", value=0.0 if isinstance(start, str) else start, low=low, high=high
        )
        self.states[name] = self.named(name, made)
        if isinstance(start, str):
            self.starts[made.index] = start
        return made

    def update(self, name: str, value: ProgramNode) -> None:
        """What the state will be at the next sample."""
        self.updates[self.states[name].index] = value

    def last(self, name: str, value: ProgramNode, start: float | str) -> ProgramNode:
        """Return the state that holds `value`, within its bounds, from one sample to the next; it
        is made once for each name."""
        state = self.states.get(f"{name}_before")
        if state is None:
            state = self.state(f"{name}_before", value.low, value.high, start)
            self.update(f"{name}_before", value)
        return state

    def valid(self, one: ProgramNode) -> ProgramNode:
        """Return whether an input is a finite number."""
        if one.op != "input":
            raise ValueError(
                f"found {one.op}; allowed: an input, whose value is known to be a number once it is past the guard"
            )
        return self.node("valid", one)

    def smaller(self, one: ProgramNode, other: ProgramNode) -> ProgramNode:
        return self.node("min", one, other)

    def larger(self, one: ProgramNode, other: ProgramNode) -> ProgramNode:
        return self.node("max", one, other)

    def sqrt(self, one: ProgramNode) -> ProgramNode:
        """Of a value that is not negative."""
        return self.node("sqrt", one)

    def select(
        self, condition: ProgramNode, then: ProgramNode, otherwise: ProgramNode
    ) -> ProgramNode:
        return self.node("select", condition, then, otherwise)

    def dot(
        self, coefficients: Sequence[ProgramNode], values: Sequence[ProgramNode]
    ) -> ProgramNode:
        """The sum of products in their order, from the left. Raises ValueError where there is
        none."""
        if not coefficients or len(coefficients) != len(values):
            raise ValueError(
                f"dot of {len(coefficients)} coefficients and {len(values)} values; allowed: as many of each, at least one"
            )
        return self.node("dot", *coefficients, *values)
