"""Identification of many simulated rigs: coverage of intervals, and errors by method."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from frictool.documents.bench import Bench
from frictool.identify.estimators.inverse_dynamic import inverse_dynamic
from frictool.identify.estimators.power_balance import by_speed
from frictool.identify.fit_result import Interval
from frictool.identify.identification import identify_records
from frictool.identify.methods import DEFAULT, IdentificationSettings
from frictool.identify.rows.difference_fit import differenced
from frictool.identify.rows.regression_samples import fit
from frictool.plant.axis import AxisParameters
from frictool.typing import Vector
from studies.rigs.identification_rigs import MASS, clutch, mass_sine, record
from studies.rigs.sample_logs import TRUTH, ramp, sines
from tests.support.linear_axis import linear_axis, linear_bench

RATE = 0.95
CHANCE = 1e-3
LOWEST, HIGHEST = 0.92, 0.98
SEEDS = 400
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


def found(seed: int, encoder_step: float = TRUTH.encoder_step) -> dict[str, tuple[Interval, float]]:
    """Return the interval and the true value of each identified parameter."""
    truth, bench = experiment(seed, encoder_step)
    logs = [
        record(make(seed, truth), truth, name) for name, make in (("sines", sines), ("ramp", ramp))
    ]
    result = identify_records(logs, [], bench, DEFAULT, IdentificationSettings(RATE))
    return {name: (one, getattr(truth, name)) for name, one in result.identified.items()}


def covered(seed: int, encoder_step: float = TRUTH.encoder_step) -> dict[str, bool]:
    """Return, for each identified parameter, if its interval holds the truth."""
    return {
        name: bool(one.low <= truth <= one.high)
        for name, (one, truth) in found(seed, encoder_step).items()
    }


def linear_covered(seed: int) -> dict[str, bool]:
    """Return, for each parameter of the published pipeline, if its interval holds the truth."""
    truth, log = linear_axis(seed)
    parameters = inverse_dynamic([log], linear_bench(), IdentificationSettings(RATE)).parameters
    return {
        name: bool(interval.low <= getattr(truth, name) <= interval.high)
        for name, interval in parameters.items()
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
            fitted = fit(samples, weight, memory, RATE, {}).parameters
            errors[name].append(
                np.array([fitted[p].value for p in ("inertia", "viscous", "coulomb")]) / truth - 1.0
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
