"""Output error at full count: table 4.1 in closed loop, and coverage of the intervals of the open
loop."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.identify.estimators.output_error import simulation_error
from frictool.identify.fit_result import SLIDING
from frictool.identify.methods import IdentificationSettings
from tests.support.driven_axes import closed_loop_errors
from tests.support.linear_axis import linear_axis, linear_bench

RATE, CHANCE = 0.95, 1e-3
SEEDS, AXES = 400, 100
MARGIN = 1.15
TRIAL = {"inertia": 3.2, "viscous": 0.10, "coulomb": 0.32}  # % rms, of table 4.1's mass


def table_4_1_closed_loop() -> dict[str, Any]:
    """rms errors of the simulation error in closed loop, in %, at most 1.15 times the trial's."""
    with tempfile.TemporaryDirectory() as folder:
        errors = [closed_loop_errors(seed, Path(folder)) for seed in range(SEEDS)]
    rms = dict(
        zip(TRIAL, (100.0 * np.sqrt(np.mean(np.square(errors), axis=0))).tolist(), strict=True)
    )
    passed = all(rms[name] <= MARGIN * limit for name, limit in TRIAL.items())
    return {
        "passed": passed,
        "seeds": SEEDS,
        **{f"rms_percent_{name}": value for name, value in rms.items()},
    }


def open_loop_coverage() -> dict[str, Any]:
    """Return the coverage of the open loop's intervals, for a carriage under its own servo."""
    hits = np.zeros(len(SLIDING), dtype=int)
    for seed in range(AXES):
        truth, record = linear_axis(seed)
        found = simulation_error(
            [record], linear_bench(), IdentificationSettings(RATE), ()
        ).parameters
        hits += [found[name].low <= getattr(truth, name) <= found[name].high for name in SLIDING]
    least = int(binom.ppf(CHANCE, AXES, RATE))
    covered = {f"covered_{name}": int(count) for name, count in zip(SLIDING, hits, strict=True)}
    return {
        "passed": int(hits.min()) >= least,
        "seeds": AXES,
        "stated_rate": RATE,
        "least_accepted": least,
        **covered,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "output error: table 4.1, closed loop": table_4_1_closed_loop,
    "output error: coverage, open loop": open_loop_coverage,
}
