"""Do the intervals of `identify` cover at their stated rate? Over seeds of the synthetic clutch and
of the mass of table 4.1.

Each seed has its own noise, its own encoder phase, its own turns, and its own axis: inertia drawn
from the bench's interval, every friction within 20 % of the sample logs'. The intervals of `auto`
have to cover in at least 92 % of 400 records. They include effects that the model may lack, so that
they cover a true model more often than stated; the median half width may be three times the rms
error (1.96 times at the stated rate). Breakaway's width is judged by `check_breakaway`, because its
interval holds every fall of friction over speed that the encoder does not refute.

The binomial distribution at the stated rate judges the count of covers of every other method. The
check fails if so few covers would come by chance only once in a thousand runs; more covers than
stated are no failure.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.fit_result import SLIDING
from frictool.identify.methods import DEFAULT, IdentificationSettings, run
from studies.rigs.identification_rigs import MASS, mass_bench, mass_sine, record
from studies.rigs.sample_logs import TRUTH, sines
from tests.support.identification_statistics import (
    CHANCE,
    FINE_STEP,
    LOWEST,
    RATE,
    SEEDS,
    experiment,
    found,
    in_published_order,
    linear_covered,
    table_errors,
)

MASS_SEEDS = 400
WIDEST = 3.0  # median half width divided by the rms error


def _coverage(encoder_step: float) -> dict[str, Any]:
    expected = {*SLIDING, "breakaway"}
    results = [found(seed, encoder_step) for seed in range(SEEDS)]
    counts, ratios = {}, {}
    for name in sorted(expected):
        pairs = [result[name] for result in results if name in result]
        counts[name] = sum(one.low <= truth <= one.high for one, truth in pairs)
        error = np.array([one.value / truth - 1.0 for one, truth in pairs])
        half = np.array([one.half_width / abs(truth) for one, truth in pairs])
        ratios[name] = float(np.median(half) / np.sqrt(np.mean(error**2)))
    identified = all(set(result) == expected for result in results)
    return {
        "passed": identified
        and min(counts.values()) >= LOWEST * SEEDS
        and max(ratios[name] for name in SLIDING) <= WIDEST,
        "seeds": SEEDS,
        "stated_rate": RATE,
        **_flat("covered", counts),
        **_flat("half_width_over_rms_error", ratios),
    }


def _flat(what: str, figures: dict[str, Any]) -> dict[str, Any]:
    """One figure a key, which the runner prints."""
    return {f"{what}_{name}": figure for name, figure in figures.items()}


def clutch_coarse() -> dict[str, Any]:
    """Encoder of 56 points: friction by sines, inertia by the weak form, as assess says."""
    return _coverage(TRUTH.encoder_step)


def clutch_fine() -> dict[str, Any]:
    """Encoder of 4096 points: all by least squares."""
    return _coverage(FINE_STEP)


def clutch_repeated() -> dict[str, Any]:
    """Sines that turn at the same places all the time: their strokes repeat the encoder's error,
    which is no noise to average out."""
    names, hits, clusters = ("viscous", "coulomb", "offset"), np.zeros(3, dtype=int), []
    for seed in range(SEEDS):
        truth, bench = experiment(seed)
        fit = least_squares(
            [record(sines(seed, truth, repeated=True), truth)], bench, IdentificationSettings(RATE)
        )
        hits += [
            fit.parameters[name].low <= getattr(truth, name) <= fit.parameters[name].high
            for name in names
        ]
        clusters.append(fit.details["clusters"])
    least = int(binom.ppf(CHANCE, SEEDS, RATE))
    return {
        "passed": int(hits.min()) >= least,
        "seeds": SEEDS,
        "stated_rate": RATE,
        "least_accepted": least,
        **_flat("covered", dict(zip(names, hits.tolist(), strict=True))),
        "clusters": float(np.median(clusters)),
    }


def inverse_dynamic_linear() -> dict[str, Any]:
    """The published pipeline on the axis that it is meant for; spanning two intervals, it covers
    more often than stated."""
    hits = [linear_covered(seed) for seed in range(SEEDS)]
    counts = {name: sum(hit.get(name, False) for hit in hits) for name in SLIDING}
    least = int(binom.ppf(CHANCE, SEEDS, RATE))
    return {
        "passed": all(set(hit) == set(SLIDING) for hit in hits) and min(counts.values()) >= least,
        "seeds": SEEDS,
        "stated_rate": RATE,
        "least_accepted": least,
        **_flat("covered", counts),
    }


def table_4_1() -> dict[str, Any]:
    """The mass of table 4.1: rms errors in % of the default method at most 1.15 times those of the
    trial's Savitzky-Golay, and coverage."""
    names, limits = ("inertia", "viscous", "coulomb"), np.array([3.5, 0.134, 0.42])
    errors, hits = [], np.zeros(3, dtype=int)
    with tempfile.TemporaryDirectory() as folder:
        bench = mass_bench(Path(folder))
    for seed in range(MASS_SEEDS):
        fit_ = run(DEFAULT, [mass_sine(seed)], bench, IdentificationSettings(RATE))
        intervals = [fit_.parameters[name] for name in names]
        truth = [getattr(MASS, name) for name in names]
        errors.append(
            [interval.value / value - 1.0 for interval, value in zip(intervals, truth, strict=True)]
        )
        hits += [
            interval.low <= value <= interval.high
            for interval, value in zip(intervals, truth, strict=True)
        ]
    rms = 100.0 * np.sqrt(np.mean(np.square(errors), axis=0))
    least = int(binom.ppf(CHANCE, MASS_SEEDS, RATE))
    return {
        "passed": bool(np.all(rms <= 1.15 * limits)) and int(hits.min()) >= least,
        "seeds": MASS_SEEDS,
        **_flat("rms_percent", dict(zip(names, rms.tolist(), strict=True))),
        **_flat("trial_percent", dict(zip(names, limits.tolist(), strict=True))),
        "least_accepted": least,
        **_flat("covered", dict(zip(names, hits.tolist(), strict=True))),
    }


def tables_4_2_and_4_3() -> dict[str, Any]:
    """The published order of the errors, in % rms."""
    errors = table_errors(range(MASS_SEEDS))
    figures = {
        f"{name}_{parameter}_percent": 100.0 * float(value)
        for name, row in errors.items()
        for parameter, value in zip(("inertia", "viscous", "coulomb"), row, strict=True)
    }
    return {"passed": in_published_order(errors), "seeds": MASS_SEEDS, **figures}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "identify: coverage, clutch, 56 points": clutch_coarse,
    "identify: coverage, clutch, 4096 points": clutch_fine,
    "identify: coverage, clutch, strokes that repeat each other": clutch_repeated,
    "identify: coverage, inverse-dynamic": inverse_dynamic_linear,
    "identify: table 4.1": table_4_1,
    "identify: tables 4.2 and 4.3": tables_4_2_and_4_3,
}
