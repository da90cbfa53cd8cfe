"""What kind of wear the moves show: one linear model of the rows with five beliefs about its parameters, compared by their evidence.

    rows = columns theta + errors       theta ~ N(mean, P_kind)

    none             dry_d,z = 1                  multiplicative   dry_d,z = w
    additive         level_d = d a                directional      dry_d,z = w_d                zones   dry_d,z = w_z

In every kind the inertia, the viscous friction and its bends, and an offset are as unsure as restriction.py says; each dry_d,z deviates by
ROUGH, as no model has its friction over position to the last per cent; and all are scaled alike by what the actuator's constant is unsure
of: what a wrong constant explains is no wear. The evidence of a kind is the density of the data under it, the parameters integrated
out, so that a kind with more parameters has to earn them; with G, b, s the sums over rows of columns' columns, columns' effort and effort's
effort, over the variance of an independent row,

    ln p = -1/2 ln det(I + P G) + 1/2 r' M r + mean' b - 1/2 mean' G mean + const      r = b - G mean, M = (P^-1 + G)^-1 = (I + P G)^-1 P

A kind of wear is told where its evidence exceeds that of none by CERTAIN and that of the other kinds; below that it is none. Values are
posterior means; their intervals hold the rough part, and not the scale (scale.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from frictool.documents.model import Model
from frictool.observe.estimate import Kind, Range, Zone
from frictool.observe.wear.layout import Layout
from frictool.observe.wear.moves import Move
from frictool.observe.wear.restriction import dry_columns, level_columns, restriction
from frictool.observe.wear.shares import SIDES, friction_share, zone_mean

Vector = NDArray[np.float64]

KINDS: tuple[Kind, ...] = ("none", "multiplicative", "additive", "directional", "zones")
WEAR = 0.3  # standard deviation of a wear, and of an added friction over the mean friction
ROUGH = 0.01  # of the model's friction, in each direction and zone
COMMON = 0.005  # of all of it
OFFSET = 0.01  # of the mean friction: by how much the drive's sensor may have drifted; more looks like friction of one direction
CERTAIN = 4.0  # of evidence, natural logarithms
MEMORY = 60.0  # moves, over which the sums are a mean
FEWEST = 2  # moves
SEEN = 0.2  # of WEAR: what the moves have told less of is not given
LEFT = 0.25  # of the rows at least, when parameters have used theirs up
PASSES = 4  # until the variance no longer moves


@dataclass(frozen=True)
class Told:
    """What the moves say. evidence: of each kind over that of none. wear: of both directions and the zones that were seen, under the kind.

    forward, backward: None where a direction was not seen. added [N m | N]: of kind additive. zones: those that were seen, of kind zones.
    """

    kind: Kind
    evidence: dict[Kind, float]
    wear: Range
    forward: Range | None
    backward: Range | None
    added: Range | None = None
    zones: tuple[Zone, ...] = ()


class Kinds:
    """Takes moves and tells their kind of wear; holds one Gram matrix."""

    def __init__(self, model: Model, layout: Layout, confidence: float = 0.95) -> None:
        self.layout = layout
        self._quantile = float(ndtri(0.5 + 0.5 * confidence))
        offset = level_columns(layout, -1.0, 1.0), 0.0, OFFSET * layout.friction
        base = restriction(model, layout, {"offset": offset}, dry_columns(layout))
        dry = dry_columns(layout)
        self._mean = base.fixed + base.matrix @ base.mean
        own = (base.matrix * base.deviation**2) @ base.matrix.T + ROUGH**2 * np.diag(dry) + COMMON**2 * np.outer(dry, dry)
        self._beliefs = {kind: own + _spread(layout, kind) for kind in KINDS}
        self._scale = relative_deviation(model) ** 2 * np.outer(self._mean, self._mean)
        self._loose = sum(self._beliefs.values(), np.zeros_like(own)) + WEAR**2 * np.diag(dry)
        self._inflation = 1.0 / (layout.every * float(np.sum(layout.phi**2)))  # rows that tell as much as one: windows overlap
        self._sides = {side: dry_columns(layout, side) for side in SIDES}
        self._zones = [dry_columns(layout, zone=zone) for zone in range(layout.zones)]
        self._shares: dict[tuple[tuple[int, ...], str | None], Vector] = {}
        self._floor = (1e-6 * layout.friction) ** 2
        self.forget()

    def forget(self) -> None:
        """The friction has changed at once: what the moves before it said is of another unit."""
        size = self._mean.size
        self._gram, self._rows, self.moves = np.zeros((size + 1, size + 1)), 0.0, 0

    def take(self, move: Move) -> None:
        """A move more; old ones fade."""
        kept = 1.0 - 1.0 / MEMORY
        self._gram, self._rows, self.moves = kept * self._gram + move.gram, kept * self._rows + move.rows, self.moves + 1

    def told(self) -> Told | None:
        """What the moves say by now; None where they are too few."""
        if self.moves < FEWEST:
            return None
        gram, right = self._information()
        found = {kind: _evidence(gram, right, self._mean, belief + self._scale) for kind, belief in self._beliefs.items()}
        over: dict[Kind, float] = {kind: value - found["none"] for kind, value in found.items()}
        best = max(over, key=lambda kind: over[kind])
        return self._values(best if over[best] >= CERTAIN else "none", over, gram, right)

    def _information(self) -> tuple[Vector, Vector]:
        """G (p, p) and b (p,), by the variance of the rows' errors under the loosest belief of all."""
        size = self._mean.size
        gram, right, squares = self._gram[:size, :size], self._gram[:size, size], float(self._gram[size, size])
        least = self._floor
        variance = max(squares / self._rows, least)
        for _ in range(PASSES):
            weight = 1.0 / (variance * self._inflation)
            theta, spread = _posterior(weight * gram, weight * right, self._mean, self._loose)
            left = squares - 2.0 * float(theta @ right) + float(theta @ gram @ theta)
            spent = self._inflation * weight * float(np.sum(spread * gram))  # rows that the parameters have used up
            variance = max(left / max(self._rows - spent, LEFT * self._rows), least)
        weight = 1.0 / (variance * self._inflation)
        return weight * gram, weight * right

    def _values(self, kind: Kind, over: dict[Kind, float], gram: Vector, right: Vector) -> Told:
        own = _posterior(gram, right, self._mean, self._beliefs[kind])
        sides = own if kind == "additive" else _posterior(gram, right, self._mean, self._beliefs["directional"])
        layout = self.layout
        zones = tuple(zone for zone, columns in enumerate(self._zones) if _tells(columns, gram))
        forward, backward = (
            self._range(self._share(zones, side), *sides) if _tells(self._sides[side], gram) else None for side in ("forward", "backward")
        )
        edges = layout.edges
        worn: tuple[Zone, ...] = ()
        if kind == "zones":
            worn = tuple(Zone(float(edges[z]), float(edges[z + 1]), self._range(zone_mean(layout, z), *own)) for z in zones)
        added = self._range(level_columns(layout, 0.5, 0.5), *own) if kind == "additive" else None
        return Told(kind, over, self._range(self._share(zones), *own), forward, backward, added, worn)

    def _share(self, zones: tuple[int, ...], side: str | None = None) -> Vector:
        key = (zones, side)
        if key not in self._shares:
            self._shares[key] = friction_share(self.layout, zones, side)
        return self._shares[key]

    def _range(self, weights: Vector, theta: Vector, spread: Vector) -> Range:
        value, deviation = float(weights @ theta), float(np.sqrt(weights @ spread @ weights))
        return Range(value, value - self._quantile * deviation, value + self._quantile * deviation)


def _tells(columns: Vector, gram: Vector) -> bool:
    """Whether the moves alone tell the wear of these columns to better than SEEN of what is known beforehand, were all else known."""
    return bool(columns @ gram @ columns * (SEEN * WEAR) ** 2 > 1.0)


def relative_deviation(model: Model) -> float:
    """Of the actuator's constant, whose interval on the bench is taken as one of 95 %; 0 where it has none."""
    low, high = model.bench.actuator.constant.interval
    return 0.5 * (high - low) / (1.96 * model.bench.actuator.constant.value)


def _spread(layout: Layout, kind: Kind) -> Vector:
    """What a kind adds to the covariance (p, p) of the columns' parameters."""
    if kind == "multiplicative":
        worn = [WEAR * dry_columns(layout)]
    elif kind == "additive":
        worn = [WEAR * layout.friction * level_columns(layout, 1.0, 1.0)]
    elif kind == "directional":
        worn = [WEAR * dry_columns(layout, side) for side in SIDES]
    elif kind == "zones":
        worn = [WEAR * dry_columns(layout, zone=zone) for zone in range(layout.zones)]
    else:
        worn = []
    size = len(layout.names)
    return sum((np.outer(one, one) for one in worn), np.zeros((size, size)))


def _posterior(gram: Vector, right: Vector, mean: Vector, belief: Vector) -> tuple[Vector, Vector]:
    """Mean (p,) and covariance (p, p) after the data; the belief may be singular."""
    spread: Vector = np.linalg.solve(np.eye(mean.size) + belief @ gram, belief).astype(np.float64)
    return mean + spread @ (right - gram @ mean), spread


def _evidence(gram: Vector, right: Vector, mean: Vector, belief: Vector) -> float:
    """ln p of the data under a belief, but for what all beliefs have in common."""
    residual, whole = right - gram @ mean, np.eye(mean.size) + belief @ gram
    spread = np.linalg.solve(whole, belief)
    _, logarithm = np.linalg.slogdet(whole)
    return float(-0.5 * logarithm + 0.5 * residual @ spread @ residual + mean @ right - 0.5 * mean @ gram @ mean)
