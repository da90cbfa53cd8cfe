"""Estimator of the wear from successive moves, with a fast reaction to sudden changes.

    MotionBlock ──log_moves.py──▶ Move ──filter_bank.py──▶ wear, inertia, viscous friction, offset
                                   └─wear_kinds.py───▶ kind of wear, by direction and zone
    both ──▶ WearEstimate after each move

Wear, alpha of thesis (6.13), is modelled as a random walk with the standard deviation WALK per
move. If one or several moves show a larger change (change_detection.py), the wear has grown faster,
or has jumped (thesis 6.3.2). The random step is then enlarged until it explains these moves.

The interval has five parts, whose squares are added:

- interval of the filters
- lag behind a growing wear
- FLOOR times the wear: a relative error that more moves do not reduce, because the rows, and the
  model's friction over position and speed, are approximations
- FALL_SHAPE times the fall of friction over speed that the model does not contain
- error of the dry friction at the mean temperature of the moves; 0 if the model's friction does not
  depend on the temperature

The inertia shows only in the acceleration that the other parameters do not explain. An unknown
effort that follows this acceleration looks like inertia. The inertia's interval therefore includes
an effort of ROUGH times the dry friction, and the rounding of the encoder. If this interval becomes
wider than the prior, the moves do not determine the inertia.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from dataclasses import replace

import numpy as np
import scipy

from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.constant_error import scale_of
from frictool.observe.wear.filter_bank import UNMODELLED, FilterBank
from frictool.observe.wear.log_moves import Move, MoveCollector
from frictool.observe.wear.parameter_restriction import multiplicative
from frictool.observe.wear.weak_form_layout import WeakFormLayout, layout_of
from frictool.observe.wear.wear_kinds import ROUGH, WearClassification, WearClassifier
from frictool.observe.wear_estimate import EstimateRange, UnmodelledFall, WearEstimate

# standard deviation of the wear from the unknown shape of a fall that the model does not contain,
# relative to this fall
FALL_SHAPE = 0.05
LEAST_FALL = 0.02  # smallest fall that is reported, relative to the dry friction
WALK = 1e-4  # standard deviation of the wear's random step in a move
FLOOR = 0.0003  # relative standard deviation of the wear that remains after many moves
# relative standard deviation of the inertia, from its correlation with the wear
INERTIA_FLOOR = 0.003
# tests for wear that keeps growing (`_going`): moves per step, number of steps in one direction,
# lag of the filters in moves
GOING_ON = ((1, 3, 1.0), (4, 2, 3.0))
# fraction of a row's variance that does not cancel in the sum of successive rows; the rest is
# rounding, which cancels
ADDS_UP = 0.9
FIRST_NOISE = 0.01  # prior standard deviation of a row's residual, relative to the dry friction
CONFIDENCE = 0.95
ALIKE = ("none", "multiplicative")
# numbers of moves: wear of zones is not reported STEADY to SETTLING moves after a change that
# followed at least AGREED moves without a change
STEADY, SETTLING, AGREED = 2, 4, 8


class WearEstimator:
    """Estimator of wear from the moves of a log."""

    def __init__(
        self, model: Model, period: float | None = None, confidence: float = CONFIDENCE
    ) -> None:
        """Create the estimator; raise FrictoolError for a model without dry friction.

        `period` is the sample period of the log [s]; None selects the period in bench.yaml.
        """
        self.model = model
        self.layout = layout_of(model, period)
        self.confidence = confidence
        self.bank = multiplicative_bank(model, self.layout)
        self.moves = MoveCollector(self.layout)
        self._count = 0
        self._rows = 0
        self._gram = np.zeros((len(self.layout.names) + 1,) * 2)
        self._quantile = float(scipy.special.ndtri(0.5 + 0.5 * confidence))
        self._slope_deviation = _slope_deviation(model)
        self._excess = 0.0  # mean over the moves, K
        # wear after each of the last moves
        self._lately: deque[float] = deque(
            maxlen=1 + max(moves * count for moves, count, _ in GOING_ON)
        )
        # moves since the last change of the wear, and between the last two changes
        self._since, self._before = 0, 0
        self._zoned = 0  # successive moves whose classification is wear of zones
        self.kinds = WearClassifier(model, self.layout, confidence)
        self._scale = scale_of(model)
        self.estimate = WearEstimate(0.0, 0, prior(model), scale=self._scale)

    def take(self, piece: MotionBlock) -> list[WearEstimate]:
        """Process a block; return an estimate for each move that ended since the last block."""
        return [self.learn(move) for move in self.moves.take(piece)]

    def finish(self) -> list[WearEstimate]:
        """End the last move; return [its estimate], or [] if no move is unfinished."""
        return [self.learn(move) for move in self.moves.end()]

    def learn(self, move: Move) -> WearEstimate:
        """Add a move, and return the new estimate."""
        self._count += 1
        self._excess += (move.excess - self._excess) / self._count
        if self.bank.take(move):
            self._since, self._before = 0, self._since
        else:
            self._since += 1
        self._lately.append(self.bank.value("wear")[0])
        unmodelled = self._inertia_deviation(move)
        nominal = self.model.parameters.inertia.value
        others = {"inertia": self._range("inertia", 1.0 / nominal, INERTIA_FLOOR, unmodelled)}
        undetermined = ("inertia",) if unmodelled >= self.bank.prior_deviation("inertia") else ()
        falls, covariance = self.bank.moments(*self.layout.fall_names)
        fall = float(np.sum(falls))
        shape = FALL_SHAPE * fall / self.layout.friction
        surely = fall - self._quantile * math.sqrt(float(np.sum(covariance)))
        falling = surely > LEAST_FALL * self.layout.friction
        floor = math.hypot(FLOOR, self._slope_deviation * self._excess, shape)
        wear = self._range("wear", 1.0, floor, self._going)
        alike = WearEstimate(
            move.time,
            self._count,
            wear,
            scale=self._scale,
            others=others,
            undetermined=undetermined,
            warnings=(_fall_warning(self.model, fall),) if falling else (),
            fall=UnmodelledFall(
                tuple(self.layout.falls.tolist()),
                tuple(falls.tolist()),
                tuple(tuple(row) for row in covariance.tolist()),
            ),
        )
        verdict = self.kinds.take(move)
        zoned = verdict is not None and verdict.kind == "zones"
        self._zoned = self._zoned + 1 if zoned else 0
        if (
            verdict is not None
            and zoned
            and self._one_change
            and self._zoned <= self._since + 1
            and apart(alike.wear, verdict.wear)
        ):
            # moves from both sides of the change look like wear of zones, which is new
            verdict = None
        if verdict is not None:
            inertia = verdict.inertia.wider(self._quantile * unmodelled / nominal)
            alike = with_kind(alike, replace(verdict, inertia=inertia))
        self.estimate = alike
        return self.estimate

    def _inertia_deviation(self, move: Move) -> float:
        """Add a move; return the inertia's deviation due to unmodelled efforts [kg m^2 | kg].

        The efforts are the error of the model's friction and the effort of the encoder's rounding.
        More moves do not reduce this deviation, because similar moves repeat both errors.
        """
        self._gram = self._gram + move.gram
        self._rows += move.rows
        acceleration = self.bank.unexplained("inertia", self._gram, self._rows)
        noise = self.model.parameters.inertia.value * self.layout.acceleration_noise
        effort = math.hypot(ROUGH * self.layout.friction, noise)
        return effort / acceleration if acceleration > 0.0 else math.inf

    @property
    def _one_change(self) -> bool:
        """Return True if the last change of the wear was recent and followed a long constant time.

        "Recent" means STEADY to SETTLING moves ago, "long" at least AGREED moves.
        """
        return self._before >= AGREED and STEADY <= self._since <= SETTLING

    @property
    def _going(self) -> float:
        """Return the lag of the estimate behind a wear that keeps growing.

        Each test in GOING_ON uses the last changes of the estimate. If all these changes have the
        same sign, the lag is the smallest change per move times the number of moves by which the
        filters lag. Otherwise, the lag is 0. The largest lag of all tests is returned.
        """
        changes = [0.0]
        lately = list(self._lately)
        for moves, count, behind in GOING_ON:
            lengths = lately[-1 - moves * count :: moves] if len(lately) > moves * count else []
            steps = [after - before for before, after in itertools.pairwise(lengths)]
            if steps and (min(steps) > 0.0 or max(steps) < 0.0):
                changes.append(behind / moves * min(abs(step) for step in steps))
        return max(changes)

    def _range(self, name: str, scale: float, floor: float, extra: float = 0.0) -> EstimateRange:
        """Return a parameter times `scale`, with its interval.

        `floor` (relative to the value) and `extra` [SI] are standard deviations of independent
        errors that widen the interval.
        """
        value, _ = self.bank.value(name)
        low, high = self.bank.interval(name, self.confidence)
        known = EstimateRange(value, min(low, value), max(high, value))
        wide = known.wider(self._quantile * math.hypot(floor * value, extra))
        return EstimateRange(scale * wide.value, scale * wide.low, scale * wide.high)


def _fall_warning(model: Model, fall: float) -> str:
    """Return the warning about friction that falls with speed and is not in the model."""
    unit = si_unit("effort", model.axis)
    return (
        f"with rising speed, friction falls by {fall:.3g} {unit} more than in the model: the "
        "model's coulomb may be wrong; identify with speed tests (--method stribeck-curve), or use "
        "--commissioning"
    )


def _slope_deviation(model: Model) -> float:
    """Return the standard deviation of the dry friction's temperature coefficient [1/K]."""
    law = model.laws.temperature if model.laws is not None else None
    if law is None or law.coulomb is None:
        return 0.0
    low, high = law.coulomb.slope.interval
    return 0.5 * (high - low) / float(scipy.special.ndtri(0.5 + 0.5 * model.confidence))


def apart(one: EstimateRange, other: EstimateRange) -> bool:
    """Return True if the intervals of two estimates do not overlap."""
    return one.low > other.high or other.low > one.high


def with_kind(alike: WearEstimate, verdict: WearClassification) -> WearEstimate:
    """Return a copy of `alike` with values of the classification `verdict`.

    - alike: estimate that assumes uniform wear
    - verdict: classification of the wear. Its kind and its wear by direction are always used; mean
      wear, added effort, zones and inertia only if the kind is not in ALIKE. For the kinds in
      ALIKE, the wear by direction is scaled to the mean wear of `alike`.
    """
    if verdict.kind not in ALIKE:
        sided = replace(
            alike, kind=verdict.kind, forward=verdict.forward, backward=verdict.backward
        )
        return replace(
            sided,
            wear=verdict.wear,
            added=verdict.added,
            zones=verdict.zones,
            others={**alike.others, "inertia": verdict.inertia},
        )
    sides = [side.value for side in (verdict.forward, verdict.backward) if side is not None]
    # the classification averages over more moves than the filters; scale its directions so that
    # their mean is the present wear
    ahead = len(sides) * alike.wear.value / sum(sides) if sides else 1.0
    return replace(
        alike,
        kind=verdict.kind,
        forward=_times(ahead, verdict.forward),
        backward=_times(ahead, verdict.backward),
    )


def _times(factor: float, side: EstimateRange | None) -> EstimateRange | None:
    return (
        None
        if side is None
        else EstimateRange(factor * side.value, factor * side.low, factor * side.high)
    )


def multiplicative_bank(model: Model, layout: WeakFormLayout) -> FilterBank:
    """Return the filter bank for uniform wear before any move.

    If the noise of the effort is white, 1/(every sum phi^2) overlapping rows are as precise as one
    independent row; `every` and `phi` are fields of the layout.
    """
    inflation = max(1.0, ADDS_UP / (layout.every * float(layout.phi @ layout.phi)))
    kinds = [multiplicative(model, layout, unmodelled) for unmodelled in UNMODELLED]
    return FilterBank(kinds, (FIRST_NOISE * layout.friction) ** 2, inflation, "wear", WALK)


def prior(model: Model) -> EstimateRange:
    """Return the prior of the wear: 1, with an interval.

    The interval is the range of the Coulomb friction in bench.yaml, divided by the nominal value.
    This range covers the product's life. Without a range, the interval of the model is used; it
    does not include wear after the identification.
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
