"""Wear as moves come: filters over them that remember long, and let go at once where friction has
changed.

    Piece ──moves.py──▶ Move ──filter_bank.py───▶ wear, inertia, viscous friction, offset ──▶
    Estimate, one after each move
                          └────wear_kinds.py──▶ kind of wear, by direction and zone ──────────▲

Wear, the alpha of (6.13), walks by WALK a move. Where moves, one or some together, tell of more
(change_detection.py), it is let walk as far as explains them: it has worn faster, or changed at
once (thesis 6.3.2: times 1.5 at 5 s).

The interval is the filters'. Beside it in quadrature: what the wear goes on by a move, where it
does; and FLOOR of the wear, which the model's shape over position and speed, and the rows' own
approximations, leave however many moves there are. It was set on plants that no acceptance check
uses (docs/theory/wear.md).
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from dataclasses import replace

from scipy.special import ndtri

from frictool.documents.model import Model
from frictool.observe.estimate import EstimateRange, WearEstimate
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.constant_error import scale_of
from frictool.observe.wear.filter_bank import UNMODELLED, FilterBank
from frictool.observe.wear.moves import Move, MoveCollector
from frictool.observe.wear.restriction import multiplicative
from frictool.observe.wear.weak_form_layout import WeakFormLayout, layout_of
from frictool.observe.wear.wear_kinds import WearClassification, WearClassifier

WALK = 1e-4  # of wear, a move
FLOOR = 0.0003  # of the wear, a deviation
INERTIA_FLOOR = 0.003  # of the inertia: what changes of the wear are mixed up with
GOING_ON = (
    (1, 3, 1.0),
    (4, 2, 3.0),
)  # steps of so many moves, so many of them one way, and how many moves the filters are behind then
# of a row's variance; the rest is of counts, whose errors in rows that follow each other cancel
ADDS_UP = 0.9
FIRST_NOISE = 0.01  # of the dry friction: a row's residual before any was seen
CONFIDENCE = 0.95
ALIKE = ("none", "multiplicative")
STEADY, SETTLING, AGREED = (
    2,
    4,
    8,
)  # moves after a change, from when and until when it is looked for; moves before it


class WearEstimator:
    """Wear of all dry friction alike, from the moves of a log."""

    def __init__(
        self, model: Model, period: float | None = None, confidence: float = CONFIDENCE
    ) -> None:
        """`period` [s] of the log where it is not the bench's. Raises FrictoolError for a model
        without dry friction."""
        self.model, self.layout, self.confidence = model, layout_of(model, period), confidence
        self.bank = multiplicative_bank(model, self.layout)
        self.moves, self._count, self._quantile = (
            MoveCollector(self.layout),
            0,
            float(ndtri(0.5 + 0.5 * confidence)),
        )
        self._lately: deque[float] = deque(
            maxlen=1 + max(moves * count for moves, count, _ in GOING_ON)
        )  # the wear after each of the last moves
        self._since, self._before = (
            0,
            0,
        )  # moves since the wear changed, and those that had agreed before it did
        self.kinds, self._scale = WearClassifier(model, self.layout, confidence), scale_of(model)
        self.estimate = WearEstimate(0.0, 0, prior(model), scale=self._scale)

    def take(self, piece: MotionBlock) -> list[WearEstimate]:
        """One estimate for each move that ended in this piece, or that a gap before it has
        ended."""
        return [self.learn(move) for move in self.moves.take(piece)]

    def finish(self) -> list[WearEstimate]:
        """The log ends here: the move that is still going on."""
        return [self.learn(move) for move in self.moves.end()]

    def learn(self, move: Move) -> WearEstimate:
        """What is known with a move more; for moves that were taken elsewhere."""
        self._count += 1
        if self.bank.take(move):
            self._since, self._before = 0, self._since
        else:
            self._since += 1
        self._lately.append(self.bank.value("wear")[0])
        others = {
            "inertia": self._range(
                "inertia", 1.0 / self.model.parameters.inertia.value, INERTIA_FLOOR
            )
        }
        wear = self._range("wear", 1.0, FLOOR, self._going)
        alike = WearEstimate(move.time, self._count, wear, scale=self._scale, others=others)
        told = self.kinds.take(move)
        if (
            told is not None
            and told.kind == "zones"
            and self._one_change
            and apart(alike.wear, told.wear)
        ):
            told = None  # moves of either side of the change look like zones
        self.estimate = alike if told is None else with_kind(alike, told)
        return self.estimate

    @property
    def _one_change(self) -> bool:
        """Whether the wear has changed once, lately, between moves that agree."""
        return self._before >= AGREED and STEADY <= self._since <= SETTLING

    @property
    def _going(self) -> float:
        """By how much the filters are behind wear that goes on: where it has gone one way in all of
        the last steps of GOING_ON, the moves that they take to believe it, each as much as the
        smallest of the steps says.

        Single moves show a fast drift, and a slow one takes longer to be believed.
        """
        found, lately = [0.0], list(self._lately)
        for moves, count, behind in GOING_ON:
            places = lately[-1 - moves * count :: moves] if len(lately) > moves * count else []
            steps = [after - before for before, after in itertools.pairwise(places)]
            if steps and (min(steps) > 0.0 or max(steps) < 0.0):
                found.append(behind / moves * min(abs(step) for step in steps))
        return max(found)

    def _range(self, name: str, scale: float, floor: float, beside: float = 0.0) -> EstimateRange:
        """A parameter times `scale` with its interval; in quadrature a deviation of `floor` of its
        value, and one `beside` [SI]."""
        value, deviation = self.bank.value(name)
        half = self._quantile * math.hypot(deviation, floor * value, beside)
        return EstimateRange(scale * value, scale * (value - half), scale * (value + half))


def apart(one: EstimateRange, other: EstimateRange) -> bool:
    """Whether no value is in both."""
    return one.low > other.high or other.low > one.high


def with_kind(alike: WearEstimate, told: WearClassification) -> WearEstimate:
    """The estimate of friction that has worn alike everywhere, and what kind of wear it is; of a
    kind that is not alike, the mean wear and the inertia are its own."""
    if told.kind not in ALIKE:
        sided = replace(alike, kind=told.kind, forward=told.forward, backward=told.backward)
        return replace(
            sided,
            wear=told.wear,
            added=told.added,
            zones=told.zones,
            others={**alike.others, "inertia": told.inertia},
        )
    sides = [side.value for side in (told.forward, told.backward) if side is not None]
    # kinds are told from the moves of a while: wear that goes on has left their values behind, and
    # not what directions differ by
    ahead = len(sides) * alike.wear.value / sum(sides) if sides else 1.0
    return replace(
        alike,
        kind=told.kind,
        forward=_times(ahead, told.forward),
        backward=_times(ahead, told.backward),
    )


def _times(factor: float, side: EstimateRange | None) -> EstimateRange | None:
    return (
        None
        if side is None
        else EstimateRange(factor * side.value, factor * side.low, factor * side.high)
    )


def multiplicative_bank(model: Model, layout: WeakFormLayout) -> FilterBank:
    """That has seen no move. White noise of the effort makes 1/(every sum phi^2) overlapping rows
    as good as one."""
    inflation = max(1.0, ADDS_UP / (layout.every * float(layout.phi @ layout.phi)))
    kinds = [multiplicative(model, layout, beside) for beside in UNMODELLED]
    return FilterBank(kinds, (FIRST_NOISE * layout.friction) ** 2, inflation, "wear", WALK)


def prior(model: Model) -> EstimateRange:
    """Wear before any move: 1, within the bench's range of the Coulomb friction over life, or where
    it has none the model's interval.

    The model's is of the day on which it was identified; how far friction has worn since, it does
    not know.
    """
    for known in (model.bench.mechanics.coulomb, model.parameters.coulomb):
        low, high = known.interval
        if low < high:
            return EstimateRange(
                1.0,
                low / known.value if known.value else 0.0,
                high / known.value if known.value else math.inf,
            )
    return EstimateRange(1.0, 0.0, math.inf)
