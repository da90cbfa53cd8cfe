"""Random programs: any operation on any values, with inputs and states of any size; arithmetic
without a meaning."""

from __future__ import annotations

import math

import numpy as np

from frictool.control.program import Program, ProgramNode

OPERATIONS = (
    "add",
    "sub",
    "mul",
    "square",
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
)
NAMES = ("reference", "position", "velocity")


class _Drawing:
    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.program = Program()
        self.numbers: list[ProgramNode] = []
        self.truths: list[ProgramNode] = []

    def size(self, decades: float = 3.0) -> float:
        return float(10.0 ** self.random.uniform(-decades, decades))

    def interval(self) -> tuple[float, float]:
        low, high = sorted(self.size() * float(side) for side in self.random.uniform(-1.0, 1.0, 2))
        return (
            (low, high)
            if self.random.random() < 0.5
            else (-max(-low, high, 1e-3), max(-low, high, 1e-3))
        )

    def number(self) -> ProgramNode:
        return self.numbers[int(self.random.integers(len(self.numbers)))]

    def truth(self) -> ProgramNode:
        if not self.truths or self.random.random() < 0.3:
            self.truths.append(self.number() < self.number())
        return self.truths[int(self.random.integers(len(self.truths)))]

    def constant(self, name: str) -> ProgramNode:
        value = (
            float(self.random.integers(-3, 4))
            if self.random.random() < 0.3
            else self.size() * float(self.random.choice([-1, 1]))
        )
        return self.program.constant(value, name if self.random.random() < 0.7 else "")

    def add(self, index: int) -> None:
        program, one, other = self.program, self.number(), self.number()
        match str(self.random.choice(OPERATIONS)):
            case "square":
                self.numbers.append(one * one)
            case "neg":
                self.numbers.append(-one)
            case "abs":
                self.numbers.append(abs(one))
            case "sqrt":
                self.numbers.append(program.sqrt(abs(one)))
            case "lt":
                self.truths.append(one < other)
            case "le":
                self.truths.append(one <= other)
            case "and":
                self.truths.append(self.truth() & self.truth())
            case "or":
                self.truths.append(self.truth() | self.truth())
            case "not":
                self.truths.append(~self.truth())
            case "select":
                if self.random.random() < 0.2:
                    self.truths.append(program.select(self.truth(), self.truth(), self.truth()))
                else:
                    self.numbers.append(program.select(self.truth(), one, other))
            case "dot":
                count = int(self.random.integers(1, 5))
                coefficients = [self.constant(f"k{index}_{j}") for j in range(count)]
                self.numbers.append(
                    program.dot(coefficients, [self.number() for _ in range(count)])
                )
            case op:
                self.numbers.append(program.node(op, one, other))


def random_program(seed: int, operations: int = 25) -> Program:
    """A program with the three inputs, up to four states, and so many operations."""
    drawing = _Drawing(seed)
    program, random = drawing.program, drawing.random
    drawing.numbers += [program.input(name, *drawing.interval()) for name in NAMES]
    for k in range(int(random.integers(0, 5))):
        low, high = drawing.interval()
        start = "position" if k == 0 and random.random() < 0.5 else 0.5 * (low + high)
        drawing.numbers.append(program.state(f"state{k}", low, high, start=start))
    drawing.numbers += [drawing.constant(f"constant{k}") for k in range(3)]
    for index in range(operations):
        drawing.add(index)
    for name in program.states:
        program.update(name, drawing.number())
    program.output = drawing.numbers[-1]
    return program


def hostile(seed: int, program: Program, samples: int) -> list[dict[str, float]]:
    """Inputs at the ends of their intervals, anywhere between them, and far beyond them."""
    random, rows = np.random.default_rng(seed), []
    for _ in range(samples):
        row = {}
        for name, node in program.inputs.items():
            width = node.high - node.low
            pool = (
                node.low,
                node.high,
                math.nextafter(node.high, node.low),
                random.uniform(node.low, node.high),
                100.0 * width,
                -width,
            )
            row[name] = float(random.choice(pool))
        rows.append(row)
    return rows
