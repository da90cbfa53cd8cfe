"""Scaling of a program in fixed point, and the proof that no operation overflows.

    intervals of inputs and states ──▶ interval of every value ──▶ its fraction, and the shifts of
    its operation ──▶ intervals of the words, checked

A value is stored as a 32-bit word, value = word 2^-fraction; its fraction is the number of
fractional bits. Products and sums are formed in 64 bits. In q31, a coefficient has a sign, 31 bits
and a separate fraction. In q15, only the coefficients are shorter (15 bits and a sign). A state
saturates at its bounds `low` and `high`; intervals that are valid at one sample are therefore valid
at every sample. The overflow proof repeats every operation on the words at both ends of its
operands' intervals, with integers of any size instead of real numbers. Each intermediate result
must fit into 64 bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.control.coefficient_words import BITS, FINEST, coefficient
from frictool.control.compiled_program import FIXED, CompiledProgram, compile_program, ports
from frictool.control.program import Program, ProgramNode

WORD, LONG = 2**31, 2**63
FILLED = (
    0.98  # fraction of a word's range that the real interval may fill; the rest is for rounding
)
WIDEST = 31  # largest left shift of a word
Interval = tuple[float, float]
Words = tuple[int, int]


class FixedPointOverflow(ValueError):
    """Error: a value has no finite interval, or a fixed-point operation would overflow."""


@dataclass(frozen=True)
class FixedProgram:
    """Program in fixed point; the keys of its dictionaries are indices of nodes of the program.

    - bits: bits of a coefficient without its sign
    - fractions: number of fractional bits of each value
    - shifts: right shifts (a, b, result) of the operands and the result of each operation
    - term_shifts: shift of each product in a sum of products
    - write_shift: shift of the next value of each state
    - constants: integer word of each constant
    - words: proved interval of each value's integer word
    - longest: largest magnitude of all intermediate results
    """

    program: Program
    bits: int
    fractions: dict[int, int]
    shifts: dict[int, tuple[int, int, int]]
    term_shifts: dict[int, tuple[int, ...]]
    write_shift: dict[int, int]
    constants: dict[int, int]
    words: dict[int, Words]
    longest: int


def fixed_program(program: Program, bits: int = BITS["q31"]) -> FixedProgram:
    """Return a program scaled for fixed point; raise FixedPointOverflow if this is impossible."""
    return _Scaling(program, bits).done()


def fixed_machine(scaled: FixedProgram) -> CompiledProgram:
    """Return the scaled program as arrays for the kernels, started at rest at position 0."""
    program = scaled.program
    plain = compile_program(scaled.program)
    writes = plain.writes
    formats = np.zeros((len(program.nodes) + len(writes), 6), dtype=np.int64)
    word = np.zeros(len(formats), dtype=np.int64)
    for node in program.nodes:
        low, high = scaled.words[node.index]
        formats[node.index] = [
            scaled.fractions[node.index],
            low,
            high,
            *scaled.shifts.get(node.index, (0, 0, 0)),
        ]
        if node.op == "constant":
            word[node.index] = scaled.constants[node.index]
        elif node.op == "state":
            word[node.index] = round(math.ldexp(node.value, scaled.fractions[node.index]))
    terms = plain.terms.copy()
    at = 0
    for node in program.nodes:
        if node.op == "dot":
            for shift in scaled.term_shifts[node.index]:
                terms[at, 2] = shift
                at += 1
    for k, (state, _) in enumerate(writes):
        formats[len(program.nodes) + k, 5] = scaled.write_shift[int(state)]
    nothing: NDArray[np.float32] = np.empty(0, dtype=np.float32)
    return CompiledProgram(
        FIXED,
        plain.code,
        terms,
        writes,
        ports(program),
        plain.starts,
        np.empty(0),
        nothing,
        word,
        formats,
    )


class _Scaling:
    def __init__(self, program: Program, bits: int) -> None:
        self.program, self.bits = program, bits
        self.real: dict[int, Interval] = {}
        self.fraction: dict[int, int] = {}
        self.shifts: dict[int, tuple[int, int, int]] = {}
        self.terms: dict[int, tuple[int, ...]] = {}
        self.constants: dict[int, int] = {}
        self.words: dict[int, Words] = {}
        self.longest = 0

    def done(self) -> FixedProgram:
        for node in self.program.nodes:
            if node.op == "constant":
                word, self.fraction[node.index] = coefficient(
                    node.value, self.bits if node.index in self.program.names else 31
                )
                value = math.ldexp(word, -self.fraction[node.index])
                self.constants[node.index], self.real[node.index] = word, (value, value)
                self.words[node.index] = (word, word)
            elif node.op in ("input", "state"):
                self._keep_bounds(node)
            else:
                self.real[node.index] = self._interval(node)
                self._scale(node)
                self.words[node.index] = self._checked(node, *self._word_interval(node))
        writes = {}
        for state, source in self.program.updates.items():
            writes[state] = self.fraction[source.index] - self.fraction[state]
            for word in self.words[source.index]:
                self._after(self.program.nodes[state], word, writes[state])
        return FixedProgram(
            self.program,
            self.bits,
            self.fraction,
            self.shifts,
            self.terms,
            writes,
            self.constants,
            self.words,
            self.longest,
        )

    def _called(self, node: ProgramNode) -> str:
        return self.program.names.get(node.index, f"value {node.index} ({node.op})")

    def _keep_bounds(self, node: ProgramNode) -> None:
        if not (math.isfinite(node.low) and math.isfinite(node.high)):
            raise FixedPointOverflow(f"{self._called(node)} has no bounds")
        self.real[node.index] = (node.low, node.high)
        f = self.fraction[node.index] = self._fraction(node, node.low, node.high)
        self.words[node.index] = self._checked(
            node, math.ceil(math.ldexp(node.low, f)), math.floor(math.ldexp(node.high, f))
        )

    def _fraction(self, node: ProgramNode, low: float, high: float) -> int:
        largest = max(abs(low), abs(high))
        if not math.isfinite(largest):
            raise FixedPointOverflow(f"{self._called(node)} has no bounds")
        if largest == 0.0:
            return 0
        fraction = math.floor(math.log2(FILLED * WORD / largest))
        if fraction < -FINEST:
            raise FixedPointOverflow(
                f"{self._called(node)} reaches {largest:.3g}, too large for a fixed-point word"
            )
        return min(fraction, FINEST)

    def _interval(self, node: ProgramNode) -> Interval:
        if node.is_logical:
            return 0.0, 1.0
        of = [self.real[arg.index] for arg in node.args]
        match node.op:
            case "add":
                return of[0][0] + of[1][0], of[0][1] + of[1][1]
            case "sub":
                return of[0][0] - of[1][1], of[0][1] - of[1][0]
            case "mul":
                return (
                    (0.0, max(of[0][0] ** 2, of[0][1] ** 2))
                    if node.args[0] is node.args[1]
                    else _product(of[0], of[1])
                )
            case "neg":
                return -of[0][1], -of[0][0]
            case "abs":
                return 0.0, max(-of[0][0], of[0][1])
            case "min":
                return min(of[0][0], of[1][0]), min(of[0][1], of[1][1])
            case "max":
                return max(of[0][0], of[1][0]), max(of[0][1], of[1][1])
            case "sqrt":
                return 0.0, math.sqrt(max(of[0][1], 0.0))
            case "select":
                return min(of[1][0], of[2][0]), max(of[1][1], of[2][1])
            case _:
                half = len(of) // 2
                products = [_product(c, x) for c, x in zip(of[:half], of[half:], strict=True)]
                return sum(low for low, _ in products), sum(high for _, high in products)

    def _scale(self, node: ProgramNode) -> None:
        index = node.index
        of = [self.fraction[arg.index] for arg in node.args]
        wanted = 0 if node.is_logical else self._fraction(node, *self.real[index])
        match node.op:
            case "add" | "sub" | "lt" | "le":
                common = min(max(of), min(of) + WIDEST - 1)
                self.fraction[index] = wanted if node.is_logical else min(wanted, common)
                self.shifts[index] = (
                    of[0] - common,
                    of[1] - common,
                    0 if node.is_logical else common - self.fraction[index],
                )
            case "mul":
                self.fraction[index] = min(wanted, sum(of))
                self.shifts[index] = (0, 0, sum(of) - self.fraction[index])
            case "neg" | "abs":
                self.fraction[index] = of[0]
            case "min" | "max":
                self.fraction[index] = min(wanted, max(of))
                self.shifts[index] = (of[0] - self.fraction[index], of[1] - self.fraction[index], 0)
            case "select":
                self.fraction[index] = wanted if node.is_logical else min(wanted, max(of[1:]))
                self.shifts[index] = (of[1] - self.fraction[index], of[2] - self.fraction[index], 0)
            case "sqrt":
                free_bits = 62 - max(self.words[node.args[0].index][1], 1).bit_length()
                left = free_bits - (of[0] + free_bits) % 2
                self.fraction[index] = (of[0] + left) // 2
                self.shifts[index] = (0, 0, left)
            case "dot":
                self._scale_dot(node, wanted)
            case _:
                self.fraction[index] = 0

    def _scale_dot(self, node: ProgramNode, wanted: int) -> None:
        half = len(node.args) // 2
        pairs = [
            (c.index, x.index) for c, x in zip(node.args[:half], node.args[half:], strict=True)
        ]
        products = [self.fraction[c] + self.fraction[x] for c, x in pairs]
        counted = [
            f
            for f, (c, x) in zip(products, pairs, strict=True)
            if any(self.words[c]) and any(self.words[x])
        ] or [wanted]
        total = sum(max(map(abs, _product(self.real[c], self.real[x]))) for c, x in pairs)
        free_bits = 61 - math.frexp(total)[1] if total > 0.0 else wanted
        common = (
            min(*counted, free_bits, FINEST + WIDEST)
            if len(counted) > 1
            else min(counted[0], free_bits)
        )
        self.fraction[node.index] = min(wanted, common)
        self.terms[node.index] = tuple(
            min(max(f - common, 0), 62) if any(self.words[c]) and any(self.words[x]) else 0
            for f, (c, x) in zip(products, pairs, strict=True)
        )
        self.shifts[node.index] = (0, 0, common - self.fraction[node.index])

    def _word_interval(self, node: ProgramNode) -> Words:
        if node.is_logical:
            for arg, shift in zip(node.args, self.shifts.get(node.index, (0, 0))[:2], strict=False):
                if node.op in ("lt", "le"):
                    for word in self.words[arg.index]:
                        self._after(node, word, shift)
            return 0, 1
        of = [self.words[arg.index] for arg in node.args]
        sa, sb, s = self.shifts.get(node.index, (0, 0, 0))

        def after(word: int, shift: int) -> int:
            return self._after(node, word, shift)

        match node.op:
            case "add":
                return after(after(of[0][0], sa) + after(of[1][0], sb), s), after(
                    after(of[0][1], sa) + after(of[1][1], sb), s
                )
            case "sub":
                return after(after(of[0][0], sa) - after(of[1][1], sb), s), after(
                    after(of[0][1], sa) - after(of[1][0], sb), s
                )
            case "mul":
                ends = [after(x * y, s) for x in of[0] for y in of[1]]
                return (0 if node.args[0] is node.args[1] else min(ends)), max(ends)
            case "neg":
                return -of[0][1], -of[0][0]
            case "abs":
                return 0, max(-of[0][0], of[0][1])
            case "min" | "max":
                choose = min if node.op == "min" else max
                return choose(after(of[0][0], sa), after(of[1][0], sb)), choose(
                    after(of[0][1], sa), after(of[1][1], sb)
                )
            case "sqrt":
                if of[0][0] < 0:
                    raise FixedPointOverflow(
                        f"{self._called(node)} is the square root of a value that may be negative"
                    )
                return 0, math.isqrt(self._long(node, of[0][1] << s))
            case "select":
                then, otherwise = (
                    [after(word, sa) for word in of[1]],
                    [after(word, sb) for word in of[2]],
                )
                return min(then[0], otherwise[0]), max(then[1], otherwise[1])
            case _:
                half = len(of) // 2
                low = high = 0
                for c, x, shift in zip(of[:half], of[half:], self.terms[node.index], strict=True):
                    ends = [after(p * q, shift) for p in c for q in x]
                    low, high = (
                        self._long(node, low + min(ends)),
                        self._long(node, high + max(ends)),
                    )
                return after(low, s), after(high, s)

    def _after(self, node: ProgramNode, word: int, shift: int) -> int:
        self._long(node, abs(word) + (1 << max(shift, 1) >> 1))
        return self._long(node, _moved(word, shift))

    def _long(self, node: ProgramNode, value: int) -> int:
        if abs(value) >= LONG:
            raise FixedPointOverflow(f"{self._called(node)} needs more than 64 bits")
        self.longest = max(self.longest, abs(value))
        return value

    def _checked(self, node: ProgramNode, low: int, high: int) -> Words:
        if max(-low, high) >= WORD:
            raise FixedPointOverflow(f"{self._called(node)} needs more than 32 bits")
        return low, high


def _product(one: Interval, other: Interval) -> Interval:
    ends = [x * y for x in one for y in other]
    return min(ends), max(ends)


def _moved(value: int, shift: int) -> int:
    if shift <= 0:
        return value << -shift
    half = 1 << (shift - 1)
    return (value + half) >> shift if value >= 0 else -((half - value) >> shift)
