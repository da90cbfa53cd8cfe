"""Classification of wear: five kinds are priors of one linear model, compared by their evidence.

    effort = C theta + errors           theta ~ N(mean, P_kind), C: matrix of the rows
    none             dry_d,z = 1
    multiplicative   dry_d,z = w        alpha of thesis (6.13)
    additive         level_d = a        alpha of thesis (6.22)
    directional      dry_d,z = w_d
    zones            dry_d,z = w_z

Here dry_d,z and level_d are coefficients of weak_form_layout.py for the direction d (1 or -1) and
the zone z; w, w_d and w_z are factors of wear, and a is an added friction. parameter_restriction.py
and filter_bank.py define the prior of the other parameters (docs/theory/wear_kinds.md). Each
dry_d,z has the additional standard deviation ROUGH, the usual accuracy of a model's
position-dependent friction. The prior contains a common factor of all coefficients for the error of
the actuator's constant. A wrong constant therefore does not look like wear.

The evidence of a kind (bayesian_evidence.py) is the probability density of the data, integrated
over the parameters. A kind of wear is reported if its log evidence exceeds the log evidence of
`none` by CERTAIN. If the log evidence of several kinds is within ALIKE of the largest, the first of
these kinds in KINDS is reported. Intervals include the deviation ROUGH, but not the error of the
actuator's constant (constant_error.py).

The weight of a move decays within the next MEMORY moves. The last moves (at most RECENT) are
compared with the earlier moves. If the evidence is larger with separate friction levels for the two
groups, the earlier moves are forgotten.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from frictool.documents.model import Model
from frictool.observe.wear.bayesian_evidence import (
    best_fit,
    evidences,
    mixture,
    posterior,
    posterior_means,
)
from frictool.observe.wear.constant_error import relative_deviation
from frictool.observe.wear.filter_bank import BEFOREHAND, UNMODELLED, rising_penalty
from frictool.observe.wear.log_moves import Move
from frictool.observe.wear.parameter_restriction import (
    dry_columns,
    level_columns,
    offset_of,
    restriction,
)
from frictool.observe.wear.repeated_moves import MoveRepeats
from frictool.observe.wear.weak_form_layout import WeakFormLayout
from frictool.observe.wear.zone_weights import SIDES, friction_share, zone_edges, zone_mean
from frictool.observe.wear_estimate import EstimateRange, Kind, WearZone
from frictool.typing import Vector

# in the order in which kinds with similar evidence are preferred
KINDS: tuple[Kind, ...] = ("none", "multiplicative", "additive", "directional", "zones")
WEAR = 0.3  # prior deviation of a wear factor, and of added friction relative to mean friction
ROUGH = 0.01  # relative standard deviation of the model's friction in each direction and zone
# relative standard deviation of an estimate that many moves do not reduce, because the model's
# friction over position is not exact
FLOOR = 0.005
# standard deviation of the offset of the drive's sensor, relative to the mean friction; a larger
# offset looks like wear of one direction
OFFSET = 0.01
CERTAIN = 4.0  # difference of log evidence above which wear is reported
ALIKE = 1.0  # difference of log evidence below which two kinds are similar
MEMORY = 60.0  # moves, time constant of the weights
FEWEST = 2  # fewest moves for a classification
# largest standard deviation of a reported wear, from the moves alone, relative to WEAR
SEEN = 0.2
LEFT = 0.25  # smallest number of degrees of freedom of a residual, per row
UNEVEN = 0.08  # standard deviation of the wear within a zone, relative to its range over the zones
LOOSE = -1  # index of the widest prior of friction over speed
PASSES = 3  # iterations for the variance
FIRST = 16  # number of first moves; the classification is updated after each of them
RECENT = 8  # moves between later updates; number of last moves that are searched for a change


@dataclass(frozen=True)
class WearClassification:
    """Kind of wear, and the wear by direction and zone.

    - kind: most likely kind; all other values assume this kind
    - evidence: log evidence of each kind minus the log evidence of `none`
    - wear: mean wear of both directions and all observed zones
    - forward, backward: wear in a direction; None if the direction was not observed
    - inertia: inertia divided by the model's inertia
    - added: increase of the friction [N m | N], for kind additive
    - zones: wear in each observed zone, for kind zones
    """

    kind: Kind
    evidence: dict[Kind, float]
    wear: EstimateRange
    forward: EstimateRange | None
    backward: EstimateRange | None
    inertia: EstimateRange
    added: EstimateRange | None = None
    zones: tuple[WearZone, ...] = ()


class WearClassifier:
    """Classifier of wear, updated by each move, with a few Gram matrices in memory."""

    def __init__(self, model: Model, layout: WeakFormLayout, confidence: float = 0.95) -> None:
        self.layout = layout
        self._quantile = float(scipy.special.ndtri(0.5 + 0.5 * confidence))
        dry = dry_columns(layout)
        bases = [
            restriction(
                model, layout, {"offset": offset_of(model, layout, OFFSET)}, dry, unmodelled
            )
            for unmodelled in UNMODELLED
        ]
        means = np.stack([base.fixed + base.matrix @ base.mean for base in bases])
        known = np.stack(
            [
                (base.matrix * base.deviation**2) @ base.matrix.T + ROUGH**2 * np.diag(dry)
                for base in bases
            ]
        )
        self._set_beliefs(
            means,
            {kind: known + _spread(layout, kind) for kind in KINDS},
            WEAR**2 * np.diag(dry),
            relative_deviation(model),
        )
        self._change = _spread(layout, "directional") / np.outer(self._unit, self._unit)
        # number of overlapping rows that are as precise as one independent row
        self._inflation = 1.0 / (layout.every * float(np.sum(layout.phi**2)))
        self._dry = np.flatnonzero(dry)
        self._falls = np.isin(layout.names, layout.fall_names)
        self._inertia = (np.array(layout.names) == "inertia") / model.parameters.inertia.value
        self._sides = {side: dry_columns(layout, side) / self._unit for side in SIDES}
        self._zones = [dry_columns(layout, zone=zone) / self._unit for zone in range(layout.zones)]
        self._shares: dict[tuple[tuple[int, ...], str | None], Vector] = {}
        self._floor = (1e-6 * layout.friction) ** 2
        size = self._mean.size
        self._nothing: Vector = np.zeros((size + 1, size + 1))
        self._old = self._nothing
        self._old_rows = 0.0
        self._recent = list[tuple[Vector, float]]()
        self._count = 0
        self._variance = np.inf
        self._repeats = MoveRepeats()
        self.classification: WearClassification | None = None

    def _set_beliefs(
        self, means: Vector, beliefs: dict[Kind, Vector], free: Vector, scale: float
    ) -> None:
        """Set the prior of each kind of wear.

        The unit of each coefficient is the standard deviation of its widest prior, so that the sums
        do not lose precision. `_unit` (p,) contains these units; `_row` (p + 1,) also contains the
        unit of the effort, 1.
        """
        loose = sum((belief[LOOSE] for belief in beliefs.values()), free)
        deviations = np.sqrt(np.diag(loose))
        self._unit = np.where(deviations > 0.0, deviations, 1.0)
        self._row = np.append(self._unit, 1.0)
        both = np.outer(self._unit, self._unit)
        self._means = means / self._unit
        self._loose = loose / both
        self._beliefs = {kind: belief / both for kind, belief in beliefs.items()}
        alike = scale**2 * self._means[:, :, None] * self._means[:, None, :]
        self._scaled = np.concatenate([self._beliefs[kind] + alike for kind in KINDS])
        self._mean = self._means[LOOSE]

    def take(self, move: Move) -> WearClassification | None:
        """Add a move; return the current classification, or None if there are too few moves.

        The classification is updated after each of the first FIRST moves, then after every RECENT
        moves.
        """
        scaled = move.gram * np.outer(self._row, self._row)
        self._repeats.take(move.gram[np.ix_(self._dry, self._dry)])
        self._recent.append((scaled, float(move.rows)))
        if len(self._recent) > RECENT:
            kept, (gram, rows) = 1.0 - 1.0 / MEMORY, self._recent.pop(0)
            self._old, self._old_rows = kept * self._old + gram, kept * self._old_rows + rows
        self._count += 1
        if self._count >= FEWEST and (self._count <= FIRST or self._count % RECENT == 0):
            self.classification = self._classify()
        return self.classification

    def _classify(self) -> WearClassification:
        last = sum((gram for gram, _ in self._recent), self._nothing)
        rows = sum(rows for _, rows in self._recent)
        gram, right = self._information(self._old + last, self._old_rows + rows)
        since = self._changed(gram, right) if self._old_rows > 0.0 else 0
        if since:
            self._recent = self._recent[-since:]
            last = sum((gram for gram, _ in self._recent), self._nothing)
            rows = sum(rows for _, rows in self._recent)
            self._old = self._nothing
            self._old_rows = 0.0
            self._count = since
            gram, right = self._information(last, rows)
        best = best_fit(gram, right)
        means = np.tile(self._means, (len(KINDS), 1))
        every = evidences(gram, best, means, self._scaled)
        every = every + self._weights(gram, right, means, self._scaled)
        evidence = scipy.special.logsumexp(every.reshape(len(KINDS), -1), axis=1)
        over: dict[Kind, float] = {
            kind: float(value - evidence[0]) for kind, value in zip(KINDS, evidence, strict=True)
        }
        highest = max(over.values())
        likely = (
            [kind for kind in KINDS if over[kind] >= highest - ALIKE]
            if highest >= CERTAIN
            else list(KINDS)
        )
        return self._values(likely[0], over, gram, right, best)

    def _changed(self, gram: Vector, right: Vector) -> int:
        """Return the number of moves since the friction changed, 0 to RECENT (0: no change).

        All other parameters are assumed to be unchanged. Moves before and after a change would
        together look like wear of zones.
        """
        last = self._nothing
        since = 0
        most = CERTAIN
        for count, (move, _) in enumerate(reversed(self._recent), 1):
            last = last + move
            last_gram, own_right = self._weighted(last, self._variance)
            known, spread = posterior(gram - last_gram, right - own_right, self._mean, self._loose)
            beliefs = np.stack([spread, spread + self._change])
            same, changed = evidences(
                last_gram, best_fit(last_gram, own_right), np.stack([known, known]), beliefs
            )
            if changed - same > most:
                since = count
                most = float(changed - same)
        return since

    def _information(self, sums: Vector, rows: float) -> tuple[Vector, Vector]:
        """Return G = C' C (p, p) and b = C' effort (p,), divided by the rows' error variance.

        The variance is estimated from the residual under the widest prior.
        """
        size = self._mean.size
        gram = sums[:size, :size]
        right = sums[:size, size]
        squares = float(sums[size, size])
        variance = min(max(squares / rows, self._floor), self._variance)
        for _ in range(PASSES):
            weight = 1.0 / (variance * self._inflation)
            theta, spread = posterior(weight * gram, weight * right, self._mean, self._loose)
            left = squares - 2.0 * float(theta @ right) + float(theta @ gram @ theta)
            # degrees of freedom that the parameters take, in rows
            spent = self._inflation * weight * float(np.sum(spread * gram))
            variance = max(left / max(rows - spent, LEFT * rows), self._floor)
        self._variance = variance
        return self._weighted(sums, variance)

    def _weighted(self, sums: Vector, variance: float) -> tuple[Vector, Vector]:
        size = self._mean.size
        weight = 1.0 / (variance * self._inflation)
        return weight * sums[:size, :size], weight * sums[:size, size]

    def _values(
        self, kind: Kind, over: dict[Kind, float], gram: Vector, right: Vector, best: Vector
    ) -> WearClassification:
        conditional = self._under(kind, gram, right, best)
        sides = (
            conditional
            if kind in ("additive", "directional")
            else self._under("directional", gram, right, best)
        )
        layout = self.layout
        zones = tuple(zone for zone, columns in enumerate(self._zones) if _shows(columns, gram))
        forward, backward = (
            self._range(self._share(zones, side), *sides, FLOOR)
            if _shows(self._sides[side], gram)
            else None
            for side in ("forward", "backward")
        )
        added = (
            self._range(level_columns(layout, 0.5, 0.5), *conditional, FLOOR * layout.friction)
            if kind == "additive"
            else None
        )
        return WearClassification(
            kind,
            over,
            self._range(self._share(zones), *conditional, FLOOR),
            forward,
            backward,
            self._range(self._inertia, *conditional),
            added,
            self._worn(zones, *conditional) if kind == "zones" else (),
        )

    def _under(
        self, kind: Kind, gram: Vector, right: Vector, best: Vector
    ) -> tuple[Vector, Vector]:
        beliefs = self._beliefs[kind]
        weights = self._weights(gram, right, self._means, beliefs)
        return mixture(gram, right, best, self._means, beliefs, weights)

    def _weights(self, gram: Vector, right: Vector, means: Vector, beliefs: Vector) -> Vector:
        """Return log weights (m,) of m priors: small if a fall of friction is negative."""
        falls = self._falls
        fitted = posterior_means(gram, right, means, beliefs)
        deviations = np.sqrt(np.diagonal(beliefs, axis1=1, axis2=2))
        rising = rising_penalty(fitted[:, falls], means[:, falls], deviations[:, falls])
        return np.resize(BEFOREHAND, rising.size) + rising

    def _worn(self, zones: tuple[int, ...], theta: Vector, spread: Vector) -> tuple[WearZone, ...]:
        """Return the wear in each zone.

        A worn part of the travel may begin or end inside a zone. The interval therefore includes
        part of the differences between zones. Similar moves repeat their errors, so that the
        covariance is multiplied by the number of similar moves.
        """
        weights = [zone_mean(self.layout, zone) for zone in zones]
        edges = zone_edges(self.layout)
        values = [float(weight * self._unit @ theta) for weight in weights]
        uneven = UNEVEN * (max(values, default=0.0) - min(values, default=0.0))
        return tuple(
            WearZone(
                edges[zone],
                edges[zone + 1],
                self._range(
                    weight, theta, self._repeats.each * spread, float(np.hypot(FLOOR, uneven))
                ),
            )
            for zone, weight in zip(zones, weights, strict=True)
        )

    def _share(self, zones: tuple[int, ...], side: str | None = None) -> Vector:
        key = (zones, side)
        if key not in self._shares:
            self._shares[key] = friction_share(self.layout, zones, side)
        return self._shares[key]

    def _range(
        self, weights: Vector, theta: Vector, spread: Vector, extra: float = 0.0
    ) -> EstimateRange:
        """Return the weighted sum of the parameters, with its interval.

        `extra` is a standard deviation whose square is added to the variance of the sum.
        """
        scaled = weights * self._unit
        value = float(scaled @ theta)
        deviation = float(np.sqrt(scaled @ spread @ scaled + extra**2))
        return EstimateRange(
            value, value - self._quantile * deviation, value + self._quantile * deviation
        )


def _shows(columns: Vector, gram: Vector) -> bool:
    return bool(columns @ gram @ columns * (SEEN * WEAR) ** 2 > 1.0)


def _spread(layout: WeakFormLayout, kind: Kind) -> Vector:
    """Return the covariance (p, p) that a kind of wear adds to the prior of the coefficients."""
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
