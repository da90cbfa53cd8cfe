"""Judges that play a candidate, as a search uses them; the caller provides them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from frictool.documents.controller import Controller
from frictool.typing import Vector

RESERVE = 0.05  # relative distance to each limit that the search aims at
EXACT = ("oscillations", "drive_peak", "rest", "limit_cycle", "saturation_time_s")  # without it
FAILED = 10.0  # shortfall of a candidate that cannot be played
EACH = 0.02  # weight of the sum of all shortfalls beside the largest
# shortfall of a response that does not end, and its growth with that of the static error
STANDSTILL, PER_ERROR = 2.0, 0.3


class JudgedRuns(Protocol):
    """Figures of one controller on p plants against r requirements."""

    @property
    def metrics(self) -> Sequence[Any]:
        """Requirements with their `key`, `name`, `limit`, `unit` and `relation`."""

    @property
    def plants(self) -> tuple[int, ...]:
        """Indices of the plants."""

    @property
    def values(self) -> Vector:
        """Worst values (p, r) in SI."""

    @property
    def reserves(self) -> Vector:
        """Relative distances (p, r) to the limits: negative beyond one, NaN if undecided."""

    @property
    def met(self) -> Any:
        """1 met, 0 broken, -1 undecided (p, r)."""

    @property
    def failed(self) -> Mapping[int, str]:
        """Plants that could not be simulated, with the reason."""


class CandidateJudge(Protocol):
    """Player of a controller on all plants, or on those of `only`, by index."""

    def __call__(self, controller: Controller, only: Sequence[int] | None = None) -> JudgedRuns:
        """Return the figures of a controller."""


@dataclass(frozen=True)
class PlayedTests:
    """Tests of rising cost: a candidate is played in the next only if it passes the one before.

    `screen`: two short steps, played on some plants. `short`: all steps, without their holds, on
    all plants. `whole`: the test that decides. `others`: short steps on other plants and from other
    places, which a found design must pass without the reserve. `places`: short steps on the worst
    plants of the whole test, from many places within a count, without the reserve. `hard`: plants
    on which the search begins.
    """

    screen: CandidateJudge
    short: CandidateJudge
    whole: CandidateJudge
    others: tuple[CandidateJudge, ...]
    places: Callable[[Controller, JudgedRuns], Sequence[JudgedRuns]]
    hard: tuple[int, ...]

    def without_reserve(self, controller: Controller, whole: JudgedRuns) -> Iterator[JudgedRuns]:
        """Yield the runs of the tests that follow the whole one, whose runs are `whole`."""
        for judge in self.others:
            yield judge(controller, None)
        yield from self.places(controller, whole)


def shortfalls(runs: JudgedRuns, reserve: float = RESERVE) -> Vector:
    """Return the distance (p, r) of each figure to its limit with the reserve; 0 or less if met.

    An undecided figure has no shortfall. Beyond 1 it grows with the logarithm. A response
    that does not end is graded by the static error, so that a search can reduce it.
    """
    wanted = np.array([0.0 if one.key in EXACT else reserve for one in runs.metrics])
    reserves = np.array(runs.reserves, dtype=np.float64)
    broken = (runs.met == 0) & ~(reserves < 0.0)
    short = wanted - np.where(broken, -0.5, reserves)
    short = np.where(runs.met == 1, np.minimum(short, wanted), short)  # rounding at a limit
    for column, one in enumerate(runs.metrics):
        if one.limit == 0.0:  # its reserve has a unit
            short[:, column] = np.where(runs.met[:, column] == 0, 0.5, 0.0)
    short = np.where(np.isnan(short), 0.0, short)
    error = next((k for k, one in enumerate(runs.metrics) if one.key == "static_error"), None)
    rest = 0.0 if error is None else np.where(np.isinf(short[:, error]), 0.0, short[:, error])
    endless = STANDSTILL + PER_ERROR * np.log1p(np.maximum(rest, 0.0))
    graded = np.where(np.isposinf(short), np.reshape(endless, (-1, 1)), short)
    return np.maximum(np.where(graded > 1.0, 1.0 + np.log(np.maximum(graded, 1.0)), graded), -1.0)


def shortfall(runs: JudgedRuns, reserve: float = RESERVE) -> float:
    """Return the objective of a search: 0 or less if every figure has its reserve."""
    if runs.failed:
        return FAILED
    worst = shortfalls(runs, reserve).max(axis=0, initial=-1.0)
    largest = float(worst.max(initial=-1.0))
    return largest if largest <= 0.0 else largest + EACH * float(np.maximum(worst, 0.0).sum())


def missing(runs: JudgedRuns) -> dict[str, float]:
    """Return the largest shortfall of each requirement without the reserve, by key."""
    worst = shortfalls(runs, 0.0).max(axis=0)
    return {one.key: float(value) for one, value in zip(runs.metrics, worst, strict=True)}


def worst_value(runs: JudgedRuns, key: str) -> float:
    """Return the worst value of a requirement over the plants [SI]; NaN if none decides it."""
    for one, column in zip(runs.metrics, np.transpose(runs.values), strict=True):
        known = column[~np.isnan(column)]
        if one.key == key and known.size:
            return float(known.max() if one.relation == "<=" else known.min())
    return math.nan
