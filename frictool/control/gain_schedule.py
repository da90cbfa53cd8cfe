"""Scheduled coefficients: a weighted sum of the corners' matrices (thesis, (5.46), (5.64)).

    alpha_i = product over all parameters: (distance from the end opposite to corner i)/(width)

A corner is a combination of interval ends, one end for each parameter; `width` is the width of the
parameter's interval. The parameters are states that the caller sets, such as the torque constant
from a temperature, or the friction from an observer. A value outside its interval is replaced by
the nearer end. The weights alpha_i are not negative, and their sum is 1 up to rounding.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from frictool.control.difference_equation import CoefficientNodes, DifferenceEquation, coefficients
from frictool.control.program import Program, ProgramNode


def corner_weights(
    program: Program, names: Sequence[str], corners: Sequence[Mapping[str, float]]
) -> list[ProgramNode]:
    """Return the weight alpha_i of each corner, a combination of ends of the parameter intervals.

    - names: scheduled parameters
    - corners: values of the parameters at each corner

    Each parameter becomes a state of the program, which starts in the middle of the parameter's
    interval.
    """
    program.block("weights of the scheduled parameters (5.46)")
    one = program.constant(1.0)
    shares: dict[str, tuple[ProgramNode, ProgramNode, float]] = {}
    for name in names:
        values = [corner[name] for corner in corners]
        low, high = min(values), max(values)
        if high > low:
            parameter = program.state(name, low, high, start=0.5 * (low + high))
            inside = program.smaller(
                program.larger(parameter, program.constant(low, f"{name}_low")),
                program.constant(high, f"{name}_high"),
            )
            share = (inside - program.constant(low, f"{name}_low")) * program.constant(
                1.0 / (high - low), f"per_{name}"
            )
            shares[name] = program.named(f"{name}_share", share), one - share, high
    weights: list[ProgramNode] = []
    for corner in corners:
        product = one
        for name, (at_high, at_low, high) in shares.items():
            factor = at_high if corner[name] == high else at_low
            product = factor if product is one else product * factor
        weights.append(
            product if product is one else program.named(f"weight_{len(weights)}", product)
        )
    return weights


def weighted_coefficients(
    program: Program, equations: Sequence[DifferenceEquation], weights: list[ProgramNode]
) -> CoefficientNodes:
    """Return the coefficients of the scheduled controller: sums over the corners with `weights`.

    equations: controller of each corner. A coefficient that is equal at all corners becomes a
    constant.
    """
    program.block("scheduled coefficients: sums over the corners with these weights")
    each = [
        coefficients(program, equation, f"corner{index}_")
        for index, equation in enumerate(equations)
    ]

    def total(nodes: list[ProgramNode]) -> ProgramNode:
        if all(node.value == nodes[0].value for node in nodes):
            return nodes[0]
        return program.dot(nodes, weights)

    n = len(equations[0].b)
    return CoefficientNodes(
        [[total([k.a[i][j] for k in each]) for j in range(n)] for i in range(n)],
        [total([k.b[i] for k in each]) for i in range(n)],
        [total([k.c[i] for k in each]) for i in range(n)],
        total([k.d for k in each]),
        [total([k.gains[i] for k in each]) for i in range(n)],
    )
