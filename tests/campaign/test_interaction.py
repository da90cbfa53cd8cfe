"""Second-order variance shares against their definition, cell by cell, in plain loops."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.campaign.statistics.interaction import joint_share
from frictool.campaign.statistics.slices import Slices

Vector = np.ndarray


def plain_beyond(first: Vector, second: Vector, values: Vector) -> tuple[float, float]:
    """Return Sobol's second-order share less what chance explains, and the standard deviation of
    that chance."""
    centred = values - values.mean()
    left = np.array(
        [
            v - centred[first == i].mean() - centred[second == j].mean()
            for v, i, j in zip(centred, first, second, strict=True)
        ]
    )
    cells = sorted(set(zip(first.tolist(), second.tolist(), strict=True)))
    inside = [left[(first == i) & (second == j)] for i, j in cells]
    alone = sum(float(np.sum((cell - cell.mean()) ** 2)) for cell in inside)
    pooled = alone / max(1, left.size - len(cells))
    noise = np.array([np.var(cell, ddof=1) if cell.size > 1 else pooled for cell in inside])
    explained = sum(cell.size * cell.mean() ** 2 for cell in inside)
    freedom = max(0.0, len(cells) - len(set(first)) - len(set(second)) + 1.0) / len(cells)
    total = float(centred @ centred)
    return (explained - freedom * noise.sum()) / total, float(
        np.sqrt(2.0 * freedom * np.sum(noise**2))
    ) / total


@pytest.mark.parametrize(
    "draws", [12, 20, 200]
)  # of 16 cells: some empty, some with one draw, all filled
@pytest.mark.parametrize("seed", range(3))
def test_the_share_beyond_both_factors_is_its_definition(draws: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    first, second = generator.integers(0, 4, draws), generator.integers(0, 4, draws)
    first[:4], second[:4] = np.arange(4), np.arange(4)
    values = generator.normal(size=draws) + first * second
    joint = joint_share(Slices(first, 4), Slices(second, 4), values, drawn=True)
    assert (joint.beyond, joint.error) == pytest.approx(
        plain_beyond(first, second, values), rel=1e-9, abs=1e-12
    )


def test_cells_in_a_row_leave_chance_no_freedom() -> None:
    # six draws in five cells: as many cells as 4 + 3 slices have parameters, less two, so that no
    # cell mean is free
    first, second = np.array([0, 0, 1, 1, 2, 3]), np.array([0, 0, 0, 1, 1, 2])
    joint = joint_share(
        Slices(first, 4), Slices(second, 3), np.array([0.0, 1.0, 3.0, 2.0, 5.0, 4.0]), drawn=True
    )
    assert joint.error == 0.0
    assert joint.beyond >= 0.0
