"""Do the intervals of `identify` cover at their stated rate? Over seeds of the synthetic clutch and
of the mass of table 4.1.

Each seed has its own noise, its own encoder phase, its own turns, and its own axis: inertia drawn
from the bench's interval, every friction within 20 % of the sample logs'. The intervals of `auto`
have to cover in 92 to 98 % of 400 records. Of the other methods a count of covers is judged against
the binomial distribution at the stated rate: it fails where so few covers would come by chance once
in a thousand runs, and more than stated are no failure.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.documents.bench import Bench
from frictool.identify.estimators.inverse_dynamic import inverse_dynamic
from frictool.identify.estimators.least_squares import least_squares
from frictool.identify.estimators.power_balance import by_speed
from frictool.identify.fit_result import SLIDING
from frictool.identify.identification import identify_records
from frictool.identify.methods import DEFAULT, IdentificationSettings, run
from frictool.identify.rows.differences import differenced
from frictool.identify.rows.regression_samples import fit
from frictool.plant.axis import AxisParameters
from frictool.typing import Vector
from studies.rigs.identification_rigs import MASS, clutch, mass_bench, mass_sine, record
from studies.rigs.sample_logs import TRUTH, ramp, sines
from tests.identify.linear_axis import linear_axis, linear_bench

RATE = 0.95
CHANCE = 1e-3
LOWEST, HIGHEST = 0.92, 0.98
SEEDS = 400
MASS_SEEDS = 400
FINE_STEP = 2.0 * np.pi / 4096.0


def experiment(seed: int, encoder_step: float = TRUTH.encoder_step) -> tuple[AxisParameters, Bench]:
    """The axis of a seed, and the bench that knows it as the clutch's bench does."""
    generator, bench = np.random.default_rng([seed, 9]), clutch()
    low, high = bench.mechanics.inertia.interval
    scale = generator.uniform(0.8, 1.2, 3)
    truth = TRUTH._replace(
        inertia=generator.uniform(low, high),
        viscous=TRUTH.viscous * scale[0],
        coulomb=TRUTH.coulomb * scale[1],
        breakaway=TRUTH.breakaway * scale[1],
        offset=TRUTH.offset * scale[2],
        encoder_step=encoder_step,
    )
    return truth, bench


def covered(seed: int, encoder_step: float = TRUTH.encoder_step) -> dict[str, bool]:
    """Return, for each identified parameter, if its interval holds the truth."""
    truth, bench = experiment(seed, encoder_step)
    logs = [
        record(make(seed, truth), truth, name) for name, make in (("sines", sines), ("ramp", ramp))
    ]
    result = identify_records(logs, [], bench, DEFAULT, IdentificationSettings(RATE))
    return {
        name: bool(found.low <= getattr(truth, name) <= found.high)
        for name, found in result.identified.items()
    }


def _coverage(encoder_step: float) -> dict[str, Any]:
    expected = {*SLIDING, "breakaway"}
    hits = [covered(seed, encoder_step) for seed in range(SEEDS)]
    counts = {name: sum(hit.get(name, False) for hit in hits) for name in sorted(expected)}
    identified = all(set(hit) == expected for hit in hits)
    return {
        "passed": identified
        and min(counts.values()) >= LOWEST * SEEDS
        and max(counts.values()) <= HIGHEST * SEEDS,
        "seeds": SEEDS,
        "stated_rate": RATE,
        **_flat("covered", counts),
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


def linear_covered(seed: int) -> dict[str, bool]:
    """Return, for each parameter of the published pipeline, if its interval holds the truth."""
    truth, log = linear_axis(seed)
    found = inverse_dynamic([log], linear_bench(), IdentificationSettings(RATE)).parameters
    return {
        name: bool(interval.low <= getattr(truth, name) <= interval.high)
        for name, interval in found.items()
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
        found = [fit_.parameters[name] for name in names]
        truth = [getattr(MASS, name) for name in names]
        errors.append(
            [interval.value / value - 1.0 for interval, value in zip(found, truth, strict=True)]
        )
        hits += [
            interval.low <= value <= interval.high
            for interval, value in zip(found, truth, strict=True)
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


def table_errors(seeds: Iterable[int]) -> dict[str, Vector]:
    """rms relative errors (3,) of m, sigma_v and F_c: plain, weighted by velocity (4.23), and
    filtered too (tau = m/sigma_v = 2.5 ms)."""
    truth, errors = (
        np.array([MASS.inertia, MASS.viscous, MASS.coulomb]),
        {"plain": [], "weighted": [], "filtered": []},
    )
    for seed in seeds:
        log = mass_sine(seed)
        for name, time_constant, by in (
            ("plain", 0.0, None),
            ("weighted", 0.0, by_speed),
            ("filtered", 2.5e-3, by_speed),
        ):
            samples, memory = differenced([log], time_constant)
            weight = np.ones(samples.velocity.size) if by is None else by(samples)
            found = fit(samples, weight, memory, RATE, {}).parameters
            errors[name].append(
                np.array([found[p].value for p in ("inertia", "viscous", "coulomb")]) / truth - 1.0
            )
    return {name: np.sqrt(np.mean(np.square(rows), axis=0)) for name, rows in errors.items()}


def in_published_order(errors: dict[str, Vector]) -> bool:
    """Tables 4.2 and 4.3: weighting costs m and gives sigma_v and F_c; filtering gives m, and costs
    the others nothing."""
    plain, weighted, filtered = errors["plain"], errors["weighted"], errors["filtered"]
    by_weight = weighted[0] > plain[0] and bool(np.all(weighted[1:] < plain[1:]))
    return (
        by_weight and filtered[0] < weighted[0] and bool(np.all(filtered[1:] < 1.05 * weighted[1:]))
    )


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
