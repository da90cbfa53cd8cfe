"""Block diagrams of linear systems, written as a table of blocks and sums of named signals.

    blocks = {
        "axis": DiagramBlock(axis, ("drive", "friction"), ("speed",)),
        "W2": DiagramBlock(w2, ("error",), ("z",)),
    }
    sums = {"error": {"reference": 1.0, "speed": -1.0}}
    connect(blocks, sums, inputs=("reference", "friction", "drive"), outputs=("z", "speed"))

A signal is an input of the diagram, an output of exactly one block, or a sum. A sum may contain
sums that precede it in the table; an empty sum is zero.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from frictool.plant.lti import Lti, block_diagonal
from frictool.typing import Matrix


@dataclass(frozen=True)
class DiagramBlock:
    """Linear system with the names of its input and output signals."""

    system: Lti
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def connect(
    blocks: Mapping[str, DiagramBlock],
    sums: Mapping[str, Mapping[str, float]],
    inputs: Sequence[str],
    outputs: Sequence[str],
) -> Lti:
    """Return the system from `inputs` to `outputs`, with the states in the order of `blocks`.

    Raises ValueError if a signal has no source or more than one, if the sample periods of the
    blocks differ, or if an algebraic loop has no solution.
    """
    periods = {block.system.period for block in blocks.values()}
    if len(periods) > 1:
        raise ValueError(f"blocks with different periods: {sorted(periods)} s; allowed: one period")
    produced = [name for block in blocks.values() for name in block.outputs]
    available = [*inputs, *produced]
    doubled = {name for name in [*available, *sums] if [*available, *sums].count(name) > 1}
    if doubled:
        raise ValueError(f"signals with two sources: {sorted(doubled)}")
    rows: dict[str, Matrix] = dict(zip(available, np.eye(len(available)), strict=True))
    for name, terms in sums.items():
        rows[name] = sum(
            (factor * _row(rows, term) for term, factor in terms.items()),
            start=np.zeros(len(available)),
        )
    m = len(inputs)
    entering = np.array(
        [_row(rows, name) for block in blocks.values() for name in block.inputs]
    ).reshape(-1, len(available))
    leaving = np.array([_row(rows, name) for name in outputs]).reshape(-1, len(available))
    a, b, c, d = (
        block_diagonal(*(getattr(block.system, part) for block in blocks.values()))
        for part in "abcd"
    )
    # produced = c x + d entering,  entering = e_in inputs + e_out produced
    e_in = entering[:, :m]
    e_out = entering[:, m:]
    l_in = leaving[:, :m]
    l_out = leaving[:, m:]
    loop = np.eye(len(produced)) - d @ e_out
    if len(produced) and np.linalg.cond(loop) > 1e12:
        raise ValueError("the diagram has an algebraic loop without a solution")
    from_x = np.linalg.solve(loop, c)
    from_in = np.linalg.solve(loop, d @ e_in)
    return Lti(
        a + b @ e_out @ from_x,
        b @ (e_in + e_out @ from_in),
        l_out @ from_x,
        l_in + l_out @ from_in,
        periods.pop() if periods else 0.0,
    )


def _row(rows: Mapping[str, Matrix], name: str) -> Matrix:
    if name not in rows:
        raise ValueError(
            f"no block provides the signal {name}; available: {', '.join(sorted(rows))}"
        )
    return rows[name]
