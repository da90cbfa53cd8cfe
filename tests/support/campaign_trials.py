"""Trials that nobody had to simulate: metrics that are functions of the draws, for tests of what is
made of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from frictool.campaign.draws.factor_space import Factor, FactorSpace
from frictool.campaign.trials.trials import (
    BROKEN,
    MET,
    MetricLimit,
    TrialResult,
    Trials,
    collect_trials,
)
from frictool.typing import Vector

Function = Callable[[Vector], Vector]  # values (n, d) -> a metric (n,)


def factors(count: int, low: float = 0.0, high: float = 1.0) -> FactorSpace:
    """x1, x2, ... each uniform in [low, high]."""
    return FactorSpace(
        tuple(
            Factor(f"x{k}", low, high, "1", f"x{k}", 0.5 * (low + high), "plant")
            for k in range(1, count + 1)
        )
    )


def trials_of(
    space: FactorSpace,
    functions: Sequence[Function],
    limits: Sequence[float],
    n: int,
    seed: int = 0,
    failed: Sequence[int] = (),
) -> Trials:
    """n random draws of `space`; metric j is functions[j] and met where it is at most limits[j];
    `failed` could not be simulated."""
    units = np.random.default_rng(seed).random((n, space.size))
    values = space.values(units)
    found = np.stack([function(values) for function in functions], axis=1)
    metrics = [
        MetricLimit(f"metric_{j}", f"metric_{j}", "1", limit, "<=")
        for j, limit in enumerate(limits, start=1)
    ]
    trials = []
    for index, row in enumerate(found):
        met = tuple(
            MET if value <= limit else BROKEN for value, limit in zip(row, limits, strict=True)
        )
        if index in failed:
            trials.append(TrialResult(index, (), (), "the plant is out of range"))
        else:
            trials.append(TrialResult(index, tuple(map(float, row)), met))
    return collect_trials(space, metrics, units, trials)
