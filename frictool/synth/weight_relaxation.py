"""Weight relaxation (`relax: auto`): strictest feasible W1 (disturbance rejection) and W3 (effort).

The weight on the command changes with W3. The thesis changes W1 and W3 by hand, from (1, 1.26) with
gamma 20.9 to (0.1, 0.05) with gamma 1.15 (5.4.3.1). gamma does not fall when W1 rises. For each W3,
the largest W1 with gamma <= 1 can therefore be enclosed between a feasible and an infeasible W1.
This W1 is one point of the trade-off curve. To save evaluations, the search interpolates. It
assumes that gamma^2 minus its value at W1 = 0 is proportional to a power of W1, which is nearly
true. Without two points to interpolate, the search bisects.

W3 is lowered only as long as W1 rises. The result is the point with the largest W3 among the
points whose W1 is within 10 % of the largest W1. At still lower W3, W1 falls again, because the
noise weight of one encoder count grows. The search ends at the value of W3 at which this noise
alone reaches the limit of W2, even if the design has no noise weight.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import PlantWeights
from frictool.synth.synthesis_problem import SynthesisProblem
from frictool.synth.weights import ChosenWeights

COLUMNS = 6  # number of values of W3 tried before the best value is refined
REFINEMENTS = 4
FLAT = 0.9  # share of the largest W1 above which W1 is treated as largest
BUDGET = 48  # largest number of evaluations
TOLERANCE = 0.01  # gamma between 0.99 and 1 times the requested value is accepted
DEEPEST = 1e-5  # W1, relative to its start, that is treated as W1 = 0
SLOPE = 0.8  # slope of log gamma over log W1, assumed while only one point is known


@dataclass(frozen=True)
class TradePoint:
    """Weights W1 (`disturbance`) and W3 (`drive`), and the gamma or norm `level` that results."""

    disturbance: float
    drive: float
    level: float


@dataclass(frozen=True)
class Trade:
    """Result of a weight relaxation: chosen weights and the reason for the choice.

    - curve: for each weight W3 of the drive, the point with the largest feasible weight W1 of the
      friction
    - points: all evaluated points
    - start: the point before the relaxation
    - required: largest allowed gamma
    """

    weights: PlantWeights
    chosen: TradePoint
    why: str
    curve: tuple[TradePoint, ...]
    points: tuple[TradePoint, ...]
    start: TradePoint
    required: float


def relax(
    chosen: ChosenWeights,
    level: Callable[[PlantWeights], float],
    required: float = 1.0,
    *,
    progress: Callable[[str], None] = lambda _: None,
) -> Trade:
    """Return relaxed weights and the record of the search, which starts from the weights `chosen`.

    `level`: function that maps weights to gamma; it may raise NoSolutionError. There are at most
    BUDGET evaluations; `progress` is called with the largest feasible W1 at each W3. Raises
    NoSolutionError if no weights have a gamma of at most `required`.
    """
    return _TradeSearch(chosen, level, required, progress).trade()


def relaxed_problem(
    problem: SynthesisProblem,
    chosen: ChosenWeights,
    guide: Callable[[SynthesisProblem], float],
    required: float = 1.0,
    *,
    progress: Callable[[str], None] = lambda _: None,
) -> tuple[SynthesisProblem, Trade]:
    """Return the problem with relaxed weights, and the record of the search.

    `guide` returns the gamma of a problem; the relaxation lowers gamma to `required`. The search
    requires that gamma rises with W1. This is true of the gamma of inequalities, but not of the
    norm with a constant controller.
    """

    def level(weights: PlantWeights) -> float:
        return guide(replace(problem, weights=weights))

    trade = relax(chosen, level, required, progress=progress)
    return replace(problem, weights=trade.weights), trade


class _TradeSearch:
    """Search for relaxed weights W1 and W3.

    In the methods, `disturbance` is log W1 and `effort` log W3, relative to the start of the
    search.
    """

    def __init__(
        self,
        chosen: ChosenWeights,
        level: Callable[[PlantWeights], float],
        required: float,
        progress: Callable[[str], None],
    ) -> None:
        self.chosen = chosen
        self.level = level
        self.required = required
        self.progress = progress
        self.points: list[TradePoint] = []
        self.curve: dict[
            float, tuple[float, TradePoint]
        ] = {}  # log effort -> log disturbance and its point
        self.tried: set[float] = set()  # log efforts tried, feasible or not

    def trade(self) -> Trade:
        start = self._at(0.0, 0.0)
        if start.level <= self.required:
            return self._trade(
                0.0, 0.0, start, start, "the strictest weights are achievable as they are"
            )
        self._columns()
        for _ in range(REFINEMENTS):
            self._refine()
        if not self.curve:
            nearest = min(self.points, key=lambda point: point.level)
            raise NoSolutionError(
                f"relax: auto finds no gamma <= {self.required:g}; the least is "
                f"{nearest.level:.3g} (W1 {nearest.disturbance:.3g}, W3 {nearest.drive:.3g}); "
                "lower weights.bandwidth_rad_s or modulus_margin, or raise weights.static_error"
            )
        effort = self._best()
        disturbance, point = self.curve[effort]
        return self._trade(disturbance, effort, point, start, self._why(point, start, effort))

    def _columns(self) -> None:
        least = math.log(self.chosen.least_effort)
        efforts = np.linspace(0.0, least, COLUMNS) if least < 0.0 else np.zeros(1)
        middle = len(efforts) // 2
        for side in (efforts[middle::-1], efforts[middle + 1 :]):
            for effort in side:
                self._column(float(effort))

    def _at(self, disturbance: float, effort: float) -> TradePoint:
        weights = self.chosen.relaxed(math.exp(disturbance), math.exp(effort))
        try:
            level = self.level(weights)
        except (NoSolutionError, np.linalg.LinAlgError):
            level = math.inf
        self.points.append(TradePoint(weights.disturbance, weights.drive, level))
        return self.points[-1]

    def _best(self) -> float:
        """Return the largest effort (log W3) whose W1 is at least FLAT times the largest W1."""
        enough = max(level for level, _ in self.curve.values()) + math.log(FLAT)
        return max(effort for effort, (level, _) in self.curve.items() if level >= enough)

    def _column(self, effort: float) -> None:
        if len(self.points) >= BUDGET:
            return
        self.tried.add(effort)
        bracket = _Bracket(self.required, self._at(math.log(DEEPEST), effort))
        trial = self._guess(effort)
        while bracket.open and len(self.points) < BUDGET:
            bracket.put(trial, self._at(trial, effort))
            trial = bracket.next()
        drive = math.exp(effort) * self.chosen.weights.drive
        if bracket.kept is None:
            self.progress(f"W3 {drive:.3g}: gamma stays above {self.required:g}")
        else:
            self.curve[effort] = bracket.low, bracket.kept
            self.progress(
                f"W3 {drive:.3g}: the largest W1 with gamma <= {self.required:g} is "
                f"{bracket.kept.disturbance:.3g}"
            )

    def _guess(self, effort: float) -> float:
        known = sorted(self.curve, key=lambda other: abs(other - effort))[:2]
        if not known:
            strictest = self.points[0].level
            return (
                max(math.log(DEEPEST), math.log(self.required / strictest) / SLOPE)
                if math.isfinite(strictest)
                else 0.5 * math.log(DEEPEST)
            )
        values = [self.curve[other][0] for other in known]
        if len(known) == 1:
            return min(0.0, values[0] + (known[0] - effort))
        slope = (values[0] - values[1]) / (known[0] - known[1])
        return min(0.0, max(math.log(DEEPEST), values[0] + slope * (effort - known[0])))

    def _refine(self) -> None:
        if not self.curve or len(self.tried) < 2:
            return
        ordered = sorted(self.tried)
        best = self._best()
        top = max(self.curve, key=lambda effort: self.curve[effort][0])
        at, highest = ordered.index(best), ordered.index(top)
        lower_ends = [at] if self.curve[top][0] >= 0.0 else [at, highest, highest - 1]
        gaps = [(ordered[i], ordered[i + 1]) for i in lower_ends if 0 <= i < len(ordered) - 1]
        if gaps:
            low, high = max(gaps, key=lambda gap: gap[1] - gap[0])
            self._column(0.5 * (low + high))

    def _why(self, point: TradePoint, start: TradePoint, effort: float) -> str:
        given_up = [
            math.log10(before / after)
            for before, after in (
                (start.disturbance, point.disturbance),
                (start.drive, point.drive),
            )
        ]
        return (
            f"{given_up[0]:.2f} decades of disturbance rejection are given up (W1 "
            f"{start.disturbance:.3g} to {point.disturbance:.3g}) and "
            f"{given_up[1]:.2f} of effort (W3 {start.drive:.3g} to {point.drive:.3g}); W3 is "
            f"not lowered further, because {self._end(effort)}"
        )

    def _end(self, effort: float) -> str:
        less = [other for other in self.tried if other < effort]
        if not less:
            return "one encoder count alone would then exceed the bound of the error weight"
        if not any(other in self.curve for other in less):
            return (
                f"with W3 {math.exp(max(less)) * self.chosen.weights.drive:.3g} no W1 has gamma "
                f"{self.required:g}"
            )
        return f"W1 would not rise by {100.0 * (1.0 / FLAT - 1.0):.0f} %"

    def _trade(
        self, disturbance: float, effort: float, point: TradePoint, start: TradePoint, why: str
    ) -> Trade:
        weights = self.chosen.relaxed(math.exp(disturbance), math.exp(effort))
        curve = tuple(self.curve[at][1] for at in sorted(self.curve, reverse=True)) or (point,)
        return Trade(weights, point, why, curve, tuple(self.points), start, self.required)


class _Bracket:
    """Interval [low, high] that contains the largest feasible x = log W1, for one W3.

    floor: gamma at W1 = 0.
    """

    def __init__(self, required: float, deepest: TradePoint) -> None:
        self.required = required
        self.floor = deepest.level
        self.low = math.log(DEEPEST)
        self.high = 0.0
        self.kept: TradePoint | None = deepest if deepest.level <= required else None
        # (x, log(gamma^2 - floor^2)/2) at the last feasible and at the last infeasible point
        self.below: tuple[float, float] | None = None
        self.above: tuple[float, float] | None = None
        self.open = self.kept is not None

    def put(self, x: float, point: TradePoint) -> None:
        seen = (x, self._excess(point.level))
        if point.level <= self.required:
            self.low, self.kept, self.below = x, point, seen
        else:
            self.high, self.above = x, seen
        near = self.kept is not None and self.kept.level >= (1.0 - TOLERANCE) * self.required
        self.open = not near and self.low < 0.0 and self.high - self.low > 0.5 * TOLERANCE

    def next(self) -> float:
        """Return the next x = log W1 to evaluate.

        Interpolation of log(gamma^2 - floor^2)/2 predicts the required gamma at this x. If
        interpolation is impossible, x is the middle of the interval that contains the solution.
        """
        wanted = self._excess((1.0 - 0.5 * TOLERANCE) * self.required)
        known = [
            seen for seen in (self.below, self.above) if seen is not None and math.isfinite(seen[1])
        ]
        if len(known) == 2 and known[1][1] > known[0][1]:
            slope = (known[1][1] - known[0][1]) / (known[1][0] - known[0][0])
            middle = known[0][0] + (wanted - known[0][1]) / slope
        elif len(known) == 1 and math.isfinite(wanted):
            middle = known[0][0] + (wanted - known[0][1]) / SLOPE
        else:
            return 0.5 * (self.low + self.high)
        margin = 0.02 * (self.high - self.low)
        return min(self.high - (margin if self.above else 0.0), max(self.low + margin, middle))

    def _excess(self, level: float) -> float:
        squares = level**2 - self.floor**2
        return (
            0.5 * math.log(squares)
            if squares > 0.0 and math.isfinite(squares)
            else math.copysign(math.inf, squares)
        )
