"""Programs done once more, an operation at a time in plain Python: in numpy.float32, and in whole
numbers without bounds."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from frictool.control.fixed_point import FixedProgram
from frictool.control.program import Program, ProgramNode

WORD, LONG = 2**31, 2**63
INVALID = -WORD
Single = np.float32


class InFloat:
    """A program in IEEE single precision. `values` by node, after a sample."""

    def __init__(self, program: Program, position: float) -> None:
        self.program = program
        self.states = {state.index: Single(state.value) for state in program.states.values()}
        self.states |= dict.fromkeys(program.starts, Single(position))
        self.values: dict[int, np.float32] = {}

    def step(self, inputs: Mapping[str, float]) -> float:
        self.values = dict(self.states)
        for name, node in self.program.inputs.items():
            self.values[node.index] = Single(inputs[name])
        for node in self.program.nodes:
            if node.index not in self.values:
                self.values[node.index] = self.done(
                    node, [self.values[arg.index] for arg in node.args]
                )
        for state, source in self.program.updates.items():
            self.states[state] = self.values[source.index]
        assert self.program.output is not None
        return float(self.values[self.program.output.index])

    def done(self, node: ProgramNode, of: list[np.float32]) -> np.float32:
        match node.op:
            case "constant":
                return Single(node.value)
            case "add":
                return of[0] + of[1]
            case "sub":
                return of[0] - of[1]
            case "mul":
                return of[0] * of[1]
            case "sqrt":
                return np.sqrt(of[0])
            case "dot":
                total, half = of[0] * of[len(of) // 2], len(of) // 2
                for c, x in zip(of[1:half], of[half + 1 :], strict=True):
                    total = total + c * x
                return total
            case _:
                return Single(chosen(node, of))


def chosen(node: ProgramNode, of: list[Any]) -> Any:
    """The operations that do not round: comparisons, logic, choices, signs."""
    match node.op:
        case "neg":
            return -of[0]
        case "abs":
            return abs(of[0])
        case "min":
            return of[1] if of[1] < of[0] else of[0]
        case "max":
            return of[1] if of[1] > of[0] else of[0]
        case "lt":
            return of[0] < of[1]
        case "le":
            return of[0] <= of[1]
        case "and":
            return of[0] != 0 and of[1] != 0
        case "or":
            return of[0] != 0 or of[1] != 0
        case "not":
            return of[0] == 0
        case "valid":
            return math.isfinite(of[0])
        case "select":
            return of[1] if of[0] != 0 else of[2]
    raise AssertionError(node.op)


class Overflow(AssertionError):
    """A value that is not where it was proved to be."""


def shifted(value: int, shift: int) -> int:
    """value 2^-shift to the nearest, halves away from zero; what is formed on the way fits 64
    bits."""
    if shift <= 0:
        return long(value * 2**-shift)
    size = long(abs(value) + 2 ** (shift - 1)) // 2**shift
    return size if value >= 0 else -size


def long(value: int) -> int:
    if not -LONG < value < LONG:
        raise Overflow(f"{value} needs more than 64 bits")
    return value


class InWords:
    """A program in fixed point, in whole numbers; raises Overflow where a value leaves its proved
    interval, its word or 64 bits."""

    def __init__(self, scaled: FixedProgram, position: float) -> None:
        self.scaled, self.program = scaled, scaled.program
        fraction = scaled.fractions
        self.states = {
            state.index: round(math.ldexp(state.value, fraction[state.index]))
            for state in self.program.states.values()
        }
        for state in self.program.starts:
            measured = self.program.inputs["position"].index
            word = shifted(self.given(measured, position), fraction[measured] - fraction[state])
            self.states[state] = self.within(state, word)
        self.values: dict[int, int] = {}
        self.saturated: set[int] = set()

    def within(self, place: int, word: int) -> int:
        low, high = self.scaled.words[place]
        return min(max(word, low), high)

    def given(self, place: int, value: float) -> int:
        """The word of an input: nearest, halves to even, saturated; INVALID for what is no
        number."""
        if not math.isfinite(value):
            return INVALID
        return self.within(place, round(math.ldexp(value, self.scaled.fractions[place])))

    def step(self, inputs: Mapping[str, float]) -> float:
        self.values = dict(self.states)
        for name, node in self.program.inputs.items():
            self.values[node.index] = self.given(node.index, inputs[name])
        for node in self.program.nodes:
            if node.index not in self.values:
                self.values[node.index] = self.done(
                    node, [self.values[arg.index] for arg in node.args]
                )
            low, high = self.scaled.words[node.index]
            if self.values[node.index] == INVALID and node.op == "input":
                continue
            if not (low <= self.values[node.index] <= high and abs(self.values[node.index]) < WORD):
                raise Overflow(
                    f"value {node.index} ({node.op}) is {self.values[node.index]}, outside "
                    f"[{low}, {high}]"
                )
        for state, source in self.program.updates.items():
            word = shifted(self.values[source.index], self.scaled.write_shift[state])
            self.states[state] = self.within(state, word)
            if self.states[state] != word:
                self.saturated.add(state)
        assert self.program.output is not None
        return math.ldexp(
            self.values[self.program.output.index],
            -self.scaled.fractions[self.program.output.index],
        )

    def done(self, node: ProgramNode, of: list[int]) -> int:
        sa, sb, s = self.scaled.shifts.get(node.index, (0, 0, 0))
        match node.op:
            case "constant":
                return self.scaled.constants[node.index]
            case "add":
                return shifted(long(shifted(of[0], sa) + shifted(of[1], sb)), s)
            case "sub":
                return shifted(long(shifted(of[0], sa) - shifted(of[1], sb)), s)
            case "mul":
                return shifted(long(of[0] * of[1]), s)
            case "sqrt":
                return math.isqrt(long(of[0] * 2**s))
            case "dot":
                total, half = 0, len(of) // 2
                for c, x, shift in zip(
                    of[:half], of[half:], self.scaled.term_shifts[node.index], strict=True
                ):
                    total = long(total + shifted(long(c * x), shift))
                return shifted(total, s)
            case "select":
                return shifted(of[1], sa) if of[0] else shifted(of[2], sb)
            case "valid":
                return int(of[0] != INVALID)
            case "lt" | "le" | "min" | "max":
                return int(chosen(node, [shifted(of[0], sa), shifted(of[1], sb)]))
            case _:
                return int(chosen(node, of))
