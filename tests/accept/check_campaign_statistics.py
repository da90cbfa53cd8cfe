"""Checks of a campaign's statistics at full count: dummy factors, bounds, known shares.

python -m tests.accept build/accept.json "campaign: dummies" "campaign: bounds of a Latin hypercube"
"campaign: known shares" ...
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy import stats

from frictool.campaign.draws.factor_space import FactorSpace
from frictool.campaign.draws.sampling import Method, draws_of
from frictool.campaign.statistics.clopper_pearson import interval, lower
from frictool.campaign.statistics.distribution import COVERED, distribution
from frictool.campaign.statistics.sensitivity import LEVEL, sensitivity
from frictool.campaign.trials.trials import BROKEN, MET, MetricLimit, Trials
from tests.support.campaign_trials import factors
from tests.support.sensitivity_functions import FUNCTIONS

Array = np.ndarray
METHODS: tuple[Method, Method] = ("random", "latin")
SURE = 0.999  # of a share of runs, one-sided


def _trials(
    space: FactorSpace,
    functions: list[Callable[[Array], Array]],
    limits: list[float],
    n: int,
    method: Method,
    seed: int,
) -> Trials:
    units = draws_of(method, n, space.size, seed).units
    values = space.values(units)
    found = np.stack([function(values) for function in functions], axis=1)
    met = np.where(found <= limits, MET, BROKEN).astype(np.int8)
    metrics = tuple(
        MetricLimit(f"metric_{j}", f"metric_{j}", "1", limit, "<=")
        for j, limit in enumerate(limits)
    )
    return Trials(space, metrics, units, values, found, met, met.min(axis=1))


def _hinge(v: Array) -> Array:
    return np.asarray(np.maximum(0.0, v[:, 0] - 0.4) + 0.2 * (v[:, 1] > 0.7))


def _wild(v: Array) -> Array:
    return np.where(v[:, 0] * v[:, 1] > 0.5, np.inf, np.exp(6.0 * v[:, 0]))


def _rare(v: Array) -> Array:
    return np.asarray((v[:, 0] > 0.9).astype(float))


def dummies_are_named_as_rarely_as_it_says() -> dict[str, Any]:
    """Four of six factors do nothing: how often one is named, in the table of failures and in that
    of shares; hinges, heavy tails, rare failures.
    """
    runs, found, passed = 1000, {}, True
    for method in METHODS:
        for n in (40, 60, 200, 1000):
            wrong = np.zeros(2)
            for seed in range(runs):
                told = sensitivity(
                    _trials(factors(6), [_hinge, _wild, _rare], [0.5, 100.0, 0.5], n, method, seed),
                    drawn=True,
                )
                wrong += [
                    any(i >= 2 for one in table for i in one.named)
                    for table in (told.questions, told.influences)
                ]
            found[f"{method} {n}"] = {"failures": wrong[0] / runs, "shares": wrong[1] / runs}
            passed = passed and bool(wrong.max() <= stats.binom.ppf(SURE, runs, LEVEL))
    return {"passed": passed, "level": LEVEL, **found}


def _corner(v: Array) -> Array:
    return np.asarray(np.all(v > 0.6, axis=1))


def _parity(v: Array) -> Array:
    return np.asarray((v > 0.5).sum(axis=1) % 2 == 1)


def _diagonal(v: Array) -> Array:
    return np.asarray(np.abs(v[:, 0] - v[:, 1]) < 0.02)


def _end(v: Array) -> Array:
    return np.asarray(v[:, 0] > 0.97)


FAILURES = {
    "corner of three": (3, _corner, 0.064),
    "parity of two": (2, _parity, 0.5),
    "parity of three": (3, _parity, 0.5),
    "diagonal": (2, _diagonal, 0.0396),
    "end of one": (3, _end, 0.03),
}


def bounds_hold() -> dict[str, Any]:
    """Count how often interval and lower bound miss the pass rate; 5 % of each is allowed."""
    runs, found, passed = 10_000, {}, True
    for method in METHODS:
        for name, (d, fails, share) in FAILURES.items():
            for n in (42, 300):
                good = np.array(
                    [
                        n - np.count_nonzero(fails(draws_of(method, n, d, seed).units))
                        for seed in range(runs)
                    ]
                )
                ends = {
                    k: (interval(int(k), n, 0.95, method), lower(int(k), n, 0.95, method))
                    for k in np.unique(good)
                }
                rate = 1.0 - share
                both = np.mean([not ends[k][0][0] <= rate <= ends[k][0][1] for k in good])
                below = np.mean([ends[k][1] > rate for k in good])
                found[f"{method}, {name}, {n}"] = {
                    "interval misses": both,
                    "lower bound misses": below,
                }
                passed = passed and max(both, below) * runs <= stats.binom.ppf(SURE, runs, 0.05)
    worst = max((_parity_missed(n), n) for n in range(4, 3001, 2))
    return {
        "passed": bool(passed and worst[0] <= 0.05),
        "parity, exactly: worst": worst[0],
        "at": worst[1],
        **found,
    }


def _parity_missed(n: int) -> float:
    """Return the rate at which the interval misses 1/2 for the parity of two factors.

    Its counts have a hypergeometric distribution.
    """
    both = np.arange(n // 2 + 1)
    chances = stats.hypergeom.pmf(both, n, n // 2, n // 2)
    seen = chances > 1e-9
    ends = np.array([interval(int(n - 2 * k), n, 0.95, "latin") for k in both[seen]])
    return float(
        chances[seen][(ends[:, 0] > 0.5) | (ends[:, 1] < 0.5)].sum() + chances[~seen].sum()
    )


def tolerance_bounds_hold() -> dict[str, Any]:
    """Count how often less than 95 % of the plants keep the bound; 5 % is allowed.

    The metric is a function of three factors with a known distribution.
    """
    runs, found, passed = 3000, {}, True
    for method in METHODS:
        for n in (60, 200, 1000):
            missed = 0
            for seed in range(runs):
                # -log of a product of three uniform values is Gamma(3)
                made = _trials(
                    factors(3), [lambda v: -np.log(v).sum(axis=1)], [5.0], n, method, seed
                )
                bound = distribution(made, 0, method).bound
                assert bound is not None
                missed += stats.gamma.cdf(bound, 3.0) < COVERED
            found[f"{method} {n}"] = missed / runs
            passed = passed and missed <= stats.binom.ppf(SURE, runs, 0.05)
    return {"passed": bool(passed), **found}


def shares_are_known() -> dict[str, Any]:
    """Ishigami, Sobol's g-function and a linear one: the mean of the estimates less the known
    index, their spread, and the error that is told.
    """
    found, passed = {}, True
    for name, (space, function, known) in FUNCTIONS.items():
        for method in METHODS:
            for n, seeds, near in (
                (300, 200, 0.05),
                (1000, 200, 0.015),
                (10_000, 60, 0.004),
                (100_000, 10, 0.003),
            ):
                rows = [
                    sensitivity(_trials(space, [function], [np.inf], n, method, seed), drawn=True)
                    .influences[0]
                    .shares
                    for seed in range(seeds)
                ]
                shares, errors = (
                    np.array([[getattr(s, what) for s in row] for row in rows])
                    for what in ("share", "error")
                )
                off = float(np.abs(shares.mean(axis=0) - known).max())
                ratio = float((shares.std(axis=0) / errors.mean(axis=0)).max())
                found[f"{name}, {method}, {n}"] = {"off": off, "spread over error told": ratio}
                passed = passed and off < near and (seeds < 50 or ratio < 1.3)
    return {"passed": passed, **found}


CHECKS = {
    "campaign: dummies": dummies_are_named_as_rarely_as_it_says,
    "campaign: bounds of the pass rate": bounds_hold,
    "campaign: tolerance bounds": tolerance_bounds_hold,
    "campaign: known shares": shares_are_known,
}
