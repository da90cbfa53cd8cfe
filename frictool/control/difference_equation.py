"""The linear controller as a difference equation in state space, with observer-form anti-windup.

    u[k] = c x[k] + d e[k],   x[k+1] = a x[k] + b e[k] + l (limited u[k] - u[k])

x is the state, e the input, u the drive before its limit, and l the anti-windup gain.

An integrator is a state whose row of `a` equals the row of the identity matrix. An integrator keeps
its value while a limiter releases the drive near the target (section 5.2.2 of the thesis). With
conditional integration it also keeps its value in two cases: in the mode REST of the rest band
(control/target_band.py), and while the drive is limited and the input would move the drive
further into the limit. In the mode REST every other state is set to 0.

Property: the state obeys x+ = (a - l c) x + (b - l d) e + l (limited u) for any u. If a - l c is
stable, sums of the absolute impulse responses from e and from the limited u bound every state.
These bounds determine the scaling of fixed point.
"""

from __future__ import annotations

import functools
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from frictool.control.program import Program, ProgramNode
from frictool.typing import Matrix

SUMMED = 2**20  # largest number of samples of an impulse response
DIED = 1e-9  # relative size of the remainder at which the sum ends


@dataclass(frozen=True)
class DifferenceEquation:
    """Linear controller x+ = a x + b e, u = c x + d e, with anti-windup gains.

    x is the state, e the input, u the drive.

    - a: matrix (n, n)
    - b, c: vectors (n,); d: number
    - gains: anti-windup gains (n,)
    """

    a: Matrix
    b: Matrix
    c: Matrix
    d: float
    gains: Matrix

    @property
    def integrators(self) -> list[int]:
        """Return the indices of the states whose row of `a` is the row of the identity matrix."""
        return [i for i, row in enumerate(self.a) if row[i] == 1.0 and np.count_nonzero(row) == 1]


@dataclass(frozen=True)
class CoefficientNodes:
    """Program nodes of the coefficients of a difference equation.

    A node is a constant or, with a gain schedule, a weighted sum over the corners of the schedule
    (control/gain_schedule.py).
    """

    a: list[list[ProgramNode]]
    b: list[ProgramNode]
    c: list[ProgramNode]
    d: ProgramNode
    gains: list[ProgramNode]


def coefficients(
    program: Program, equation: DifferenceEquation, prefix: str = ""
) -> CoefficientNodes:
    """Add the coefficients of `equation` to a program as constants, and return their nodes.

    prefix: text before the name of each constant, such as `a[0][1]`.
    """
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
    """Write the drive u = d e + c x to the program and return its node.

    - k: coefficients
    - entering: input e
    - bounds (n,): bounds of |x|; the states x are added to the program with these bounds
    """
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
    hold: ProgramNode | None,
    resting: ProgramNode | None,
) -> None:
    """Write the state update x[k+1] = a x[k] + b e[k] + l (limited u[k] - u[k]) to the program.

    - k: coefficients
    - entering: input e
    - excess: limited u minus u

    While `hold` is true, the states with the indices `integrators` keep their values. While
    `resting` is true, all other states are set to 0.
    """
    program.block("states of the linear controller: next x = b e + l excess + a x")
    n = len(k.b)
    x = [program.states[f"x[{i}]"] for i in range(n)]
    for i in range(n):
        terms = _present([k.b[i], k.gains[i], *k.a[i]], [entering, excess, *x])
        following = program.dot(*terms) if terms[0] else program.constant(0.0)
        holds = hold is not None and i in integrators
        if hold is not None and holds:
            following = program.select(hold, x[i], following)
        if resting is not None and not holds:
            following = program.select(resting, program.constant(0.0), following)
        program.update(f"x[{i}]", following)


def _present(
    coefficients: list[ProgramNode], values: list[ProgramNode]
) -> tuple[list[ProgramNode], list[ProgramNode]]:
    kept = [
        (c, v)
        for c, v in zip(coefficients, values, strict=True)
        if not (c.op == "constant" and c.value == 0.0)
    ]
    return [c for c, _ in kept], [v for _, v in kept]


def state_bounds(
    equation: DifferenceEquation, entering: float, drive: float, conditional: bool
) -> Matrix:
    """Return the bounds (n,) of |x| for |e| <= entering and |limited u| <= drive; inf if unbounded.

    x is the state, e the input and u the drive of `equation`.

    conditional: True for conditional integration. The integrator then keeps its value while the
    drive is limited. The bound of the integrator follows from the drive's limit and the bounds of
    the other states. This requires a single integrator with c b >= 0 that enters no other state,
    and an anti-windup gain of 0 for all other states.

    The bounds are not valid while the drive is released, nor if another term is added to the drive
    before its limit. The fixed-point word of the state may then saturate.
    """
    n = len(equation.b)
    held_states = equation.integrators if conditional else []
    free = [i for i in range(n) if i not in held_states]
    closed = equation.a - np.outer(equation.gains, equation.c)
    a = closed[np.ix_(free, free)]
    # x+ = (a - l c) x + (b - l d) e + l (limited u); an integrator that keeps its value adds a term
    into_e = (equation.b - equation.gains * equation.d)[free]
    into_u = equation.gains[free]
    bounds = np.full(n, np.inf)
    if held_states and (
        np.any(equation.gains[free]) or np.any(equation.a[np.ix_(free, held_states)])
    ):
        return bounds
    bounds[free] = _reach(impulse_sums(a, into_e), entering) + _reach(
        impulse_sums(a, into_u), drive
    )
    for i in held_states:
        others = float(np.sum(np.abs(equation.c[free]) * bounds[free])) + abs(equation.d) * entering
        if equation.c[i] != 0.0 and len(held_states) == 1 and equation.c[i] * equation.b[i] >= 0.0:
            bounds[i] = (drive + others) / abs(equation.c[i]) + abs(equation.b[i]) * entering
    return bounds


def _reach(sums: Matrix, bound: float) -> Matrix:
    bounds = np.zeros(len(sums))
    bounds[sums != 0.0] = sums[sums != 0.0] * bound
    return bounds


def impulse_sums(a: Matrix, b: Matrix) -> Matrix:
    """Return sum_k |a^k b| (n,), an upper bound of |x| in x+ = a x + b e for |e| <= 1.

    The result is inf if a is not stable. It is cached, because a search composes the program of the
    same linear controller for many candidates.
    """
    n = len(b)
    if n == 0 or not np.any(b):
        return np.zeros(n)
    rows, column = (np.asarray(one, dtype=np.float64).tobytes() for one in (a, b))
    return _impulse_sums(rows, column, n).copy()


@functools.lru_cache(maxsize=256)
def _impulse_sums(a_bytes: bytes, b_bytes: bytes, n: int) -> Matrix:
    a = np.frombuffer(a_bytes).reshape(n, n)
    b = np.frombuffer(b_bytes)
    if float(np.max(np.abs(np.linalg.eigvals(a)))) >= 1.0:
        return np.full(n, np.inf)
    responses = b[:, None]
    power = a
    while True:
        total = np.sum(np.abs(responses), axis=1)
        if responses.shape[1] >= SUMMED or np.all(np.abs(power) @ total <= DIED * total):
            break
        responses = np.hstack([responses, power @ responses])
        power = power @ power
    # each further block of m samples is at most |a^m| times the block before: a geometric series
    if float(np.max(np.abs(np.linalg.eigvals(np.abs(power))))) >= 1.0:
        return np.full(n, np.inf)
    return np.linalg.solve(np.eye(n) - np.abs(power), total)
