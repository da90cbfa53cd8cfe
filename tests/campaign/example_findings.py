"""A campaign as a clutch might give it, with everything that can happen to a trial; and one worst
case."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from frictool.campaign.draws.factor_space import Factor, FactorSpace
from frictool.campaign.draws.sampling import Method
from frictool.campaign.statistics.findings import Findings, find
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, MetricLimit, Trials

HOSTILE = "</script><b>\"& '\x1b[31mé鑄\n"
METRICS = (
    MetricLimit("response_time_95", "response_time_95_s", "s", 0.4, "<="),
    MetricLimit("modulus_margin", "modulus_margin", "", 0.5, ">="),
    MetricLimit("limit_cycle", "limit_cycle", "rad", 0.01, "<="),
    MetricLimit("rest", "rest", "A", 0.0, "<="),
)


@dataclass(frozen=True)
class Kept:
    """A worst case, as the search keeps one."""

    requirement: str = "response_time_95"
    value: float = 0.47
    limit: float = 0.4
    unit: str = "s"
    relation: str = "<="
    met: bool | None = False
    values: Mapping[str, float] = field(
        default_factory=lambda: {"coulomb": 0.14, "spread.lost": -2.0}
    )
    scenario: str = "worst_response_time_95.yaml"
    command: str = (
        "frictool simulate model.yaml --controller controller.yaml --scenario "
        "worst_response_time_95.yaml -o worst.mcap"
    )
    typed: str = (
        "frictool simulate a/model.yaml --controller a/controller.yaml --scenario "
        "w/worst_response_time_95.yaml -o w/worst.mcap"
    )


def space(label: str = "Coulomb friction") -> FactorSpace:
    return FactorSpace(
        (
            Factor("coulomb", 0.1, 0.15, "N m", label, 0.12, "plant"),
            Factor("inertia", 1e-5, 2e-5, "kg m²", "inertia", 1.4e-5, "plant"),
            Factor("spread.lost", -2.0, 2.0, "1", "lost counts", 0.0, "sensor", whole=True),
        )
    )


def trials(
    n: int = 400,
    seed: int = 0,
    label: str = "Coulomb friction",
    slow: float = 0.4,
    units: np.ndarray | None = None,
) -> Trials:
    """The response is slow where friction is high and counts are lost; the very slowest never
    settle; no trial tells of a limit cycle."""
    where = space(label)
    points = np.random.default_rng(seed).random((n, 3)) if units is None else units
    values = where.values(points)
    response = 0.2 + 0.2 * points[:, 0] ** 2 + 0.02 * np.abs(values[:, 2])
    response[response > 0.43] = np.inf
    found = np.stack(
        [response, 0.6 - 0.05 * points[:, 1], np.full(len(points), np.nan), np.zeros(len(points))],
        axis=1,
    )
    metrics = (dataclasses.replace(METRICS[0], limit=slow), *METRICS[1:])
    met = np.stack(
        [_met(metric, column) for metric, column in zip(metrics, found.T, strict=True)], axis=1
    )
    passed = np.where((met == BROKEN).any(axis=1), BROKEN, MET).astype(np.int8)
    return Trials(where, metrics, points, values, found, met, passed)


def stopped(
    made: Trials, draws: tuple[int, ...], reason: str = "the position is beyond 1e3 rad"
) -> Trials:
    """The same, but that some draws could not be simulated."""
    found, met, passed = made.metric_values.copy(), made.met.copy(), made.passed.copy()
    found[list(draws)], met[list(draws)], passed[list(draws)] = np.nan, UNDECIDED, BROKEN
    return dataclasses.replace(
        made, metric_values=found, met=met, passed=passed, failed=dict.fromkeys(draws, reason)
    )


def findings(made: Trials, method: Method = "random", at_least: float | None = None) -> Findings:
    return find(made, method, [Kept()], at_least)


def _met(metric: MetricLimit, column: np.ndarray) -> np.ndarray:
    kept = column <= metric.limit if metric.relation == "<=" else column >= metric.limit
    return np.where(np.isnan(column), UNDECIDED, np.where(kept, MET, BROKEN)).astype(np.int8)


CORNERS = ((np.arange(8)[:, None] >> np.arange(3)) & 1).astype(float)
