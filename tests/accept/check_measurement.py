"""Backlash and delay on simulated clutches with an encoder of 4096 points: how often their
intervals hold what was put in.

The intervals reach over two windows, so that they may hold more often than stated; that is no
failure here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.identify.fit_result import Interval
from frictool.identify.measurement.reversals import reversals
from studies.rigs.identification_rigs import record
from studies.rigs.sample_logs import sines
from tests.support.identification_statistics import FINE_STEP, RATE, experiment

SEEDS = 100
CHANCE = 1e-3


def coverage() -> dict[str, Any]:
    """Width of 1 to 4 rad, delay within two samples either way."""
    held, halves = np.zeros((SEEDS, 2), dtype=np.bool_), np.full((SEEDS, 2), np.nan)
    for seed in range(SEEDS):
        generator, (truth, bench) = np.random.default_rng([seed, 19]), experiment(seed, FINE_STEP)
        put_in = float(generator.uniform(1.0, 4.0)), float(generator.uniform(-2e-3, 2e-3))
        truth = truth._replace(backlash=put_in[0])
        log = record(sines(seed, truth), truth)
        found = reversals(
            [replace(log, effort=np.interp(log.time - put_in[1], log.time, log.effort))],
            bench,
            RATE,
        )
        for k, (one, true) in enumerate(zip(found, put_in, strict=True)):
            if isinstance(one, Interval):
                held[seed, k], halves[seed, k] = one.low <= true <= one.high, one.half_width
    least, names = int(binom.ppf(CHANCE, SEEDS, RATE)), ("backlash", "delay")
    out = {f"{name}_covered": int(held[:, k].sum()) for k, name in enumerate(names)}
    out |= {f"{name}_told": int(np.isfinite(halves[:, k]).sum()) for k, name in enumerate(names)}
    sizes = {
        f"{name}_half_width": float(np.nanmedian(halves[:, k])) for k, name in enumerate(names)
    }
    return {
        "passed": int(held.sum(axis=0).min()) >= least,
        "seeds": SEEDS,
        "least_accepted": least,
        **out,
        **sizes,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"identify: backlash and delay": coverage}
