"""The linear controller as a difference equation in state-space form, with the observer form of
anti-windup.

    u[k] = c x[k] + d e[k],   x[k+1] = a x[k] + b e[k] + l (limited u[k] - u[k])

Sums are formed in the order written: d e first, then c x; b e, l times the excess, then a x. What
is 0 is left out.

An integrator, a state whose row of `a` is that of the identity, may be held instead: while the
drive is released (5.2.2), and with `conditional` while the drive is limited and what enters would
move it further, and at rest, where every other state is 0.

Known of it: with l the state follows a - l c, x+ = (a - l c) x + (b - l d) e + l (limited u),
whatever u would be. Where that is stable every state is bounded by sums of its impulse responses,
which is where fixed point takes its scaling from.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.control.program import Program, ProgramNode

Matrix = NDArray[np.float64]
SUMMED = 2**20  # samples of an impulse response, at most
DIED = 1e-9  # of what has been summed


@dataclass(frozen=True)
class DifferenceEquation:
    """a (n, n), b (n,), c (n,), d, gains l (n,)."""

    a: Matrix
    b: Matrix
    c: Matrix
    d: float
    gains: Matrix

    @property
    def integrators(self) -> list[int]:
        """States whose row of `a` is the identity's."""
        return [i for i, row in enumerate(self.a) if row[i] == 1.0 and np.count_nonzero(row) == 1]


@dataclass(frozen=True)
class CoefficientNodes:
    """The equation's numbers as nodes: constants of the program, or sums over the corners of a
    schedule."""

    a: list[list[ProgramNode]]
    b: list[ProgramNode]
    c: list[ProgramNode]
    d: ProgramNode
    gains: list[ProgramNode]


def coefficients(
    program: Program, equation: DifferenceEquation, prefix: str = ""
) -> CoefficientNodes:
    """The equation as constants of the program, their names after `prefix`."""
    n = len(equation.b)

    def row(name: str, values: Matrix) -> list[ProgramNode]:
        return [
            program.constant(float(value), f"{prefix}{name}[{i}]") for i, value in enumerate(values)
        ]

    rows = [
        [program.constant(float(equation.a[i, j]), f"{prefix}a[{i}][{j}]") for j in range(n)]
        for i in range(n)
    ]
    return CoefficientNodes(
        rows,
        row("b", equation.b),
        row("c", equation.c),
        program.constant(equation.d, f"{prefix}d"),
        row("l", equation.gains),
    )


def output(
    program: Program, k: CoefficientNodes, entering: ProgramNode, bounds: Matrix
) -> ProgramNode:
    """u before its limit. `bounds` (n,) of the states."""
    program.block("linear controller: u = d e + c x")
    x = [program.state(f"x[{i}]", -float(bound), float(bound)) for i, bound in enumerate(bounds)]
    terms = _present([k.d, *k.c], [entering, *x])
    return program.named("linear_drive", program.dot(*terms) if terms[0] else program.constant(0.0))


def advance(
    program: Program,
    integrators: Collection[int],
    k: CoefficientNodes,
    entering: ProgramNode,
    excess: ProgramNode,
    held: ProgramNode | None,
    resting: ProgramNode | None,
) -> None:
    """Moves x. excess = limited drive - drive; `held`: where the states `integrators` are;
    `resting`: where the others are 0."""
    program.block("its states: next x = b e + l excess + a x")
    n = len(k.b)
    x = [program.states[f"x[{i}]"] for i in range(n)]
    for i in range(n):
        terms = _present([k.b[i], k.gains[i], *k.a[i]], [entering, excess, *x])
        following = program.dot(*terms) if terms[0] else program.constant(0.0)
        holds = held is not None and i in integrators
        if held is not None and holds:
            following = program.select(held, x[i], following)
        if resting is not None and not holds:
            following = program.select(resting, program.constant(0.0), following)
        program.update(f"x[{i}]", following)


def _present(
    coefficients: list[ProgramNode], values: list[ProgramNode]
) -> tuple[list[ProgramNode], list[ProgramNode]]:
    """Without the terms whose coefficient is the constant 0."""
    kept = [
        (c, v)
        for c, v in zip(coefficients, values, strict=True)
        if not (c.op == "constant" and c.value == 0.0)
    ]
    return [c for c, _ in kept], [v for _, v in kept]


def state_bounds(
    equation: DifferenceEquation, entering: float, drive: float, conditional: bool
) -> Matrix:
    """|x| (n,) for |e| <= entering and a drive within +-drive, inf where nothing bounds it.

    Integrators that are held while they would push a limited drive further: what the drive's limit
    leaves them beside the other states. That holds of a single one that moves the drive the way of
    what enters, c b >= 0, and moves no other state. A drive to which something is added before its
    limit, or that is released, is not covered: there a word saturates.
    """
    n, held = len(equation.b), equation.integrators if conditional else []
    free = [i for i in range(n) if i not in held]
    closed = equation.a - np.outer(equation.gains, equation.c)
    a = closed[np.ix_(free, free)]
    # with the limit: x+ = (a - l c) x + (b - l d) e + l (limited u), and what held integrators send
    # in through l
    into_e, into_u = (equation.b - equation.gains * equation.d)[free], equation.gains[free]
    bounds = np.full(n, np.inf)
    if held and (np.any(equation.gains[free]) or np.any(equation.a[np.ix_(free, held)])):
        return bounds
    bounds[free] = _reach(impulse_sums(a, into_e), entering) + _reach(
        impulse_sums(a, into_u), drive
    )
    for i in held:
        others = float(np.sum(np.abs(equation.c[free]) * bounds[free])) + abs(equation.d) * entering
        if equation.c[i] != 0.0 and len(held) == 1 and equation.c[i] * equation.b[i] >= 0.0:
            bounds[i] = (drive + others) / abs(equation.c[i]) + abs(equation.b[i]) * entering
    return bounds


def _reach(sums: Matrix, bound: float) -> Matrix:
    """sums (n,) times a bound, either of them possibly inf; what nothing enters stays 0."""
    found = np.zeros(len(sums))
    found[sums != 0.0] = sums[sums != 0.0] * bound
    return found


def impulse_sums(a: Matrix, b: Matrix) -> Matrix:
    """sum_k |a^k b| (n,): how far each state of x+ = a x + b e goes for |e| <= 1, from above; inf
    where a is not stable."""
    n = len(b)
    if n == 0 or not np.any(b):
        return np.zeros(n)
    if float(np.max(np.abs(np.linalg.eigvals(a)))) >= 1.0:
        return np.full(n, np.inf)
    responses, power = b[:, None], a
    while True:
        total = np.sum(np.abs(responses), axis=1)
        if responses.shape[1] >= SUMMED or np.all(np.abs(power) @ total <= DIED * total):
            break
        responses, power = np.hstack([responses, power @ responses]), power @ power
    # as many samples again are at most |a^m| times these, and so on: a geometric series
    if float(np.max(np.abs(np.linalg.eigvals(np.abs(power))))) >= 1.0:
        return np.full(n, np.inf)
    return np.linalg.solve(np.eye(n) - np.abs(power), total)
