"""The linear controller as a chain of second-order sections in the transposed direct form II.

    y = b0 e + s1,   s1+ = b1 e - a1 y + s2,   s2+ = b2 e - a2 y

e is the input and y the output of a section; s1 and s2 are its states. The output y of one section
is the input e of the next. Anti-windup adds a gain times (limited drive - drive) to every state, as
in control/difference_equation.py. A chain of sections has no separate integrator state. A
controller with a limit-cycle limiter or conditional integration therefore has the state-space form.
Property: rounding a coefficient moves only one pair of poles.
"""

from __future__ import annotations

import numpy as np

from frictool.control.program import Program, ProgramNode
from frictool.typing import Matrix

Chain = tuple[tuple[float, ...], ...]


def chain_state_space(sections: Chain) -> tuple[Matrix, Matrix, Matrix, float]:
    """Return (a, b, c, d) of the chain of second-order sections.

    The states are s1 and s2 of the first section, then of the next.
    """
    n = 2 * len(sections)
    a = np.zeros((n, n))
    b = np.zeros(n)
    # input of section k = c x + d (input of the chain)
    c = np.zeros(n)
    d = 1.0
    for k, (b0, b1, b2, _, a1, a2) in enumerate(sections):
        first = 2 * k
        second = 2 * k + 1
        for row, ahead, back in ((first, b1, a1), (second, b2, a2)):
            a[row] += (ahead - back * b0) * c
            a[row, first] -= back
            b[row] += (ahead - back * b0) * d
        a[first, second] += 1.0
        c, d = b0 * c, b0 * d
        c[first] += 1.0
    return a, b, c, d


def output(
    program: Program, sections: Chain, entering: ProgramNode, bounds: Matrix
) -> tuple[ProgramNode, list[tuple[ProgramNode, ProgramNode]]]:
    """Write m second-order sections to the program.

    Return the node of the unlimited drive, and a list of the pairs (input, output) of the sections.

    - entering: input e of the first section
    - bounds (2 m,): bounds of the states s1, s2 of each section
    """
    program.block("linear controller: second-order sections, transposed direct form II")
    passed = []
    signal = entering
    for k, (b0, *_) in enumerate(sections):
        program.constant(1.0, f"sos[{k}][3]")
        one = program.state(f"s[{k}][0]", -float(bounds[2 * k]), float(bounds[2 * k]))
        program.state(f"s[{k}][1]", -float(bounds[2 * k + 1]), float(bounds[2 * k + 1]))
        leaving = program.constant(b0, f"sos[{k}][0]") * signal + one
        passed.append((signal, leaving))
        signal = leaving
    return program.named("linear_drive", signal), passed


def advance(
    program: Program,
    sections: Chain,
    gains: Matrix,
    passed: list[tuple[ProgramNode, ProgramNode]],
    excess: ProgramNode,
    resting: ProgramNode | None,
) -> None:
    """Write the update of the states s1, s2 of the m sections.

    - passed: input and output of each section
    - excess: limited drive minus drive
    - gains (2 m,): anti-windup gains, factors of `excess`

    While `resting` is true, all states are set to 0.
    """
    program.block("states of the second-order sections")
    for k, ((_, b1, b2, _, a1, a2), (entered, left)) in enumerate(
        zip(sections, passed, strict=True)
    ):
        for row, ahead, back in ((0, b1, a1), (1, b2, a2)):
            numerator, denominator = (
                program.constant(ahead, f"sos[{k}][{1 + row}]"),
                program.constant(back, f"sos[{k}][{4 + row}]"),
            )
            following = numerator * entered - denominator * left
            if row == 0:
                following = following + program.states[f"s[{k}][1]"]
            gain = float(gains[2 * k + row])
            if gain != 0.0:
                following = following + program.constant(gain, f"l[{2 * k + row}]") * excess
            if resting is not None:
                following = program.select(resting, program.constant(0.0), following)
            program.update(f"s[{k}][{row}]", following)
