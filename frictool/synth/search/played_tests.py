"""Interfaces of the tests in which a search simulates (plays) a candidate.

The caller of the search implements the tests.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from frictool.documents.controller import Controller
from frictool.typing import Vector

RESERVE = 0.05  # relative distance to each limit that the search aims at
EXACT = ("oscillations", "drive_peak", "rest", "limit_cycle", "saturation_time_s")  # no reserve
FAILED = 10.0  # shortfall of a candidate that cannot be played
EACH = 0.02  # weight of the sum of all shortfalls, which is added to the largest shortfall
# shortfall of a response that does not settle:
# STANDSTILL + PER_ERROR log(1 + shortfall of the static error)
STANDSTILL, PER_ERROR = 2.0, 0.3


class JudgedRuns(Protocol):
    """Results of one controller in a simulated test with several plants."""

    @property
    def metrics(self) -> Sequence[Any]:
        """Return the requirements with their `key`, `name`, `limit`, `unit` and `relation`."""

    @property
    def plants(self) -> tuple[int, ...]:
        """Return the indices of the plants."""

    @property
    def values(self) -> Vector:
        """Return each plant's worst value of each requirement [SI], (plants, requirements)."""

    @property
    def reserves(self) -> Vector:
        """Return the distances of `values` from their limits, relative to the limits.

        The array has the shape (plants, requirements). A distance is negative if the requirement is
        violated, and NaN if the requirement is undecided.
        """

    @property
    def met(self) -> Any:
        """Return an array (plants, requirements): 1 if met, 0 if violated, -1 if undecided."""

    @property
    def failed(self) -> Mapping[int, str]:
        """Return the reason for each plant that could not be simulated, by the plant's index."""

    @property
    def speeds(self) -> Vector:
        """Return the largest speed of each plant [rad/s | m/s], (plants,)."""


Stop = Callable[[JudgedRuns], bool]


class CandidateJudge(Protocol):
    """Function that simulates a controller with all plants, or with the plants `only`."""

    def __call__(
        self,
        controller: Controller,
        only: Sequence[int] | None = None,
        until: Stop | None = None,
    ) -> JudgedRuns:
        """Simulate a controller and return the results.

        - only: indices of the plants, in the order of the simulation
        - until: function of the results so far, called after each plant; if it returns True, the
          simulation ends
        """


@dataclass(frozen=True)
class PlayedTests:
    """Tests of rising cost; only a candidate that passes a test is played in the next test.

    - screen: two short steps with some plants
    - short: all steps with all plants, shortened and without the steps of kind `hold_s`
    - whole: the complete test, which decides
    - others: short steps with other plants and from other initial positions
    - places: short steps with the worst plants of `whole`, from many initial positions within one
      encoder count
    - hard: indices of the plants with which `screen` begins
    - plants: number of plants of `screen`, `short` and `whole`

    In `others` and `places`, a design must meet the requirements, but need not keep the reserve.
    """

    screen: CandidateJudge
    short: CandidateJudge
    whole: CandidateJudge
    others: tuple[CandidateJudge, ...]
    places: Callable[[Controller, JudgedRuns, Stop | None], Iterable[JudgedRuns]]
    hard: tuple[int, ...]
    plants: int

    def without_reserve(
        self, controller: Controller, whole: JudgedRuns, until: Stop | None = None
    ) -> Iterator[JudgedRuns]:
        """Play the tests in which a design need not keep the reserve, and yield their results.

        - whole: results of the complete test; its worst plants are played in `places`
        - until: as in CandidateJudge
        """
        for judge in self.others:
            yield judge(controller, None, until)
        yield from self.places(controller, whole, until)


def shortfalls(runs: JudgedRuns, reserve: float = RESERVE) -> Vector:
    """Return the shortfalls (plants, requirements): requested reserve minus actual reserve.

    A reserve is the distance to the limit, relative to the limit. A shortfall of 0 or less means
    that the requirement is met with the reserve. An undecided requirement has the shortfall 0.
    Above 1 a shortfall grows logarithmically. If a response does not settle, the shortfall of the
    response time is computed from the static error, so that a search can reduce this shortfall.
    """
    wanted = np.array([0.0 if one.key in EXACT else reserve for one in runs.metrics])
    reserves = np.array(runs.reserves, dtype=np.float64)
    broken = (runs.met == 0) & ~(reserves < 0.0)
    short = wanted - np.where(broken, -0.5, reserves)
    short = np.where(runs.met == 1, np.minimum(short, wanted), short)  # rounding at a limit
    for column, one in enumerate(runs.metrics):
        if one.limit == 0.0:  # a reserve relative to 0 is undefined
            short[:, column] = np.where(runs.met[:, column] == 0, 0.5, 0.0)
    short = np.where(np.isnan(short), 0.0, short)
    error = next((k for k, one in enumerate(runs.metrics) if one.key == "static_error"), None)
    rest = 0.0 if error is None else np.where(np.isinf(short[:, error]), 0.0, short[:, error])
    endless = STANDSTILL + PER_ERROR * np.log1p(np.maximum(rest, 0.0))
    graded = np.where(np.isposinf(short), np.reshape(endless, (-1, 1)), short)
    return np.maximum(np.where(graded > 1.0, 1.0 + np.log(np.maximum(graded, 1.0)), graded), -1.0)


def shortfall(runs: JudgedRuns, reserve: float = RESERVE) -> float:
    """Return the objective of the search: largest shortfall + EACH (sum of positive shortfalls).

    Each requirement contributes its largest shortfall of all plants. The result is at most 0 if all
    requirements are met with the reserve, and FAILED if a plant could not be simulated.
    """
    if runs.failed:
        return FAILED
    worst = shortfalls(runs, reserve).max(axis=0, initial=-1.0)
    largest = float(worst.max(initial=-1.0))
    return largest if largest <= 0.0 else largest + EACH * float(np.maximum(worst, 0.0).sum())


def missing(runs: JudgedRuns) -> dict[str, float]:
    """Return the largest violation of each requirement over all plants.

    The keys of the result are the keys of the requirements. A violation is relative to the limit;
    it is 0 or less if the requirement is met, and grows logarithmically above 1. It is FAILED if a
    plant could not be simulated.
    """
    if runs.failed:
        return {one.key: FAILED for one in runs.metrics}
    worst = shortfalls(runs, 0.0).max(axis=0)
    return {one.key: float(value) for one, value in zip(runs.metrics, worst, strict=True)}


def worst_value(runs: JudgedRuns, key: str) -> float:
    """Return the worst value of a requirement over all plants [SI]; NaN if no run determines it."""
    for one, column in zip(runs.metrics, np.transpose(runs.values), strict=True):
        known = column[~np.isnan(column)]
        if one.key == key and known.size:
            return float(known.max() if one.relation == "<=" else known.min())
    return math.nan
