"""Judgement whether a model reproduces a log.

An error is compared with two limits, relative to the rms of the measured signal:

    limit^2 = (DOUBTFUL_FORCE_ERROR share)^2 + noise^2
    widest^2 = limit^2 + intervals^2

The error is the force error. `share` is the rms of the effort minus the model's offset, relative
to the rms of the effort, and at most 1: an offset such as the weight on a vertical axis says
nothing about friction. `noise` is the rms effort that noise of the encoder causes through the
acceleration. `intervals` is the rms change of the model's effort if each sliding parameter moves to
the farther end of its interval; these changes are regarded as independent. `identify` doubts a
model with a force error above DOUBTFUL_FORCE_ERROR.

A model reproduces a log only if the error is within `limit`, which does not increase with the
model's intervals. An error above `widest` contradicts the model. Between the two limits, other
values within the intervals may fit the log, but the model's values do not.

The force error says nothing about samples at rest, and an unstable model may have a small force
error. A model whose simulated position strays therefore does not reproduce the log, either:

- The range contains the travel of the bench and all measured positions. The simulated position must
  stay in the range, extended by `limit` times its length, if the bench states the travel and if
  something holds the position. This is either a controller, or a spring or gravity that changes
  over the range by more than Coulomb friction and effort error together.
- In all other cases, the simulated position drifts, because the axis integrates errors of the
  effort. An rms error e moves a sliding axis of inertia J and viscous friction b by at most e T
  min(1/b, T/J) during the time T. A model with a controller, a spring or gravity is unstable if it
  drifts further than this bound.

If the axis rests although the effort, minus offset and load of the model, exceeds the breakaway by
more than `limit`, a force that the model lacks holds the axis (`rest_balance.py`). The answer is
then not yes, either.

The effort of a servo is computed from the few counts between goal and position. The error of a
servo is therefore the rms position error, relative to the rms distance between goal and position,
and `intervals` is 0.

A model with only an offset has a force error of `share`. If the limit exceeds `share`, an error
within the limit therefore decides nothing. Breakaway ramps contain hardly more than the first
moments of slip, in which friction falls from the breakaway to the Coulomb friction. In a log of
ramps, an error above the limit therefore decides nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from frictool.adapters.axis_model import load_law
from frictool.documents.laws import Load
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.identify.breakaway.onset_detection import is_ramp
from frictool.identify.fit_result import SLIDING
from frictool.identify.fit_warnings import DOUBTFUL_FORCE_ERROR
from frictool.identify.force_error import SlipRows, Values
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rest_balance import held_rest
from frictool.identify.rows.smoothing import (
    acceleration_response,
    measurement_noise,
    position_noise,
)
from frictool.typing import Vector

LEAST_VALID = 0.5  # least share of a log on the valid side of the model
EXPLAINS_NOTHING = 1.0  # force error of a model without any effort
MOSTLY_OFFSET = 0.5  # share of the effort without offset, below which the answer explains its limit
GRID_POINTS = 1001  # positions at which the load over the travel is evaluated


@dataclass(frozen=True)
class Judgement:
    """Answer to the question whether a model reproduces a log.

    - holds: True if the error is within the limit, False if not, None if undecided
    - error, limit: judged error and its limit, relative to the measured signal; None if unknown
    - line: the answer in one sentence
    - advice: what to do if the answer is no or undecided, or what to know if the answer is yes
    """

    holds: bool | None
    error: float | None
    limit: float | None
    line: str
    advice: str = ""

    @property
    def warning(self) -> str | None:
        """Return answer and advice as text, but only the advice (or None) if the answer is yes."""
        return (self.advice or None) if self.holds else f"{self.line}; {self.advice}"


@dataclass(frozen=True)
class SimulatedMotion:
    """Measured position of an axis, and simulated position of its model, (n,), rad | m.

    - duration: longest time of simulation without a restart, s
    - held: True if a controller holds the simulated position
    """

    measured: Vector
    simulated: Vector
    duration: float
    held: bool = False


def judged_force(
    model: Model,
    values: Values,
    record: MotionRecord,
    rows: SlipRows | None,
    error: float | None,
    motion: SimulatedMotion,
) -> Judgement:
    """Return whether a model reproduces the effort of a log.

    Parameters
    ----------
    model
        Model with the intervals of its parameters.
    values
        Values of the model's parameters by name, SI units.
    record
        Record of the log.
    rows
        Slipping samples of the record; None if no sample slips.
    error
        Relative force error of the model; None if no sample slips.
    motion
        Measured and simulated position.
    """
    if rows is None or error is None:
        line = "undecided: no sample certainly slips"
        return Judgement(None, None, None, line, "validate on longer strokes")
    left = float(np.sqrt(np.mean((rows.effort - values["offset"]) ** 2)))
    share = min(left / rows.rms_effort, 1.0)
    doubtful = DOUBTFUL_FORCE_ERROR * share
    limit = math.hypot(doubtful, _noise(values, record, rows))
    intervals = _intervals(model, values, rows)
    shown = f"force error {100.0 * error:.3g} %, limit {100.0 * limit:.3g} %"
    if share < MOSTLY_OFFSET:
        shown += f" ({100.0 * DOUBTFUL_FORCE_ERROR:.3g} % of the effort minus its offset)"
    if error > limit and is_ramp(record, model.bench):
        line = f"undecided: {shown}; breakaway ramps show too little sliding"
        return Judgement(None, error, limit, line, "validate on strokes or steps")
    if error > math.hypot(limit, intervals):
        advice = "look at --page for a resonance, load or friction that the model lacks"
        return Judgement(False, error, limit, f"this log contradicts the model: {shown}", advice)
    stray = _stray(model, values, motion, limit, rows)
    if stray is not None:
        line = f"undecided: {shown}; {stray}"
        return Judgement(None, error, limit, line, "look at --page, and check the model's load")
    held = held_rest(model, record, limit * rows.rms_effort)
    if held is not None:
        line = f"undecided: {shown}; {held.words(model)}"
        return Judgement(None, error, limit, line, "look for a contact, end stop or brake")
    if error > limit:
        line = f"undecided: {shown}; only the model's wide intervals explain the error"
        return Judgement(None, error, limit, line, "identify again with this log added")
    if error > doubtful and limit >= share:
        line = f"undecided: {shown}; encoder noise hides errors"
        return Judgement(None, error, limit, line, "validate on faster motion")
    doubt = (
        "this result says little: the model's intervals are so wide that they allow a force error "
        f"of {100.0 * intervals:.3g} %; identify with more logs"
    )
    wide = doubt if intervals >= EXPLAINS_NOTHING else ""
    return Judgement(True, error, limit, f"the model reproduces this log: {shown}", wide)


def judged_positions(
    record: MotionRecord, goal: Vector, measured: Vector, simulated: Vector
) -> Judgement:
    """Return whether a model reproduces the positions of a servo that follows its goal.

    Parameters
    ----------
    record
        Record of the log.
    goal, measured, simulated
        Goal, measured and simulated position (n,) without the skipped samples, rad | m.
    """
    distance = float(np.sqrt(np.mean((goal - measured) ** 2)))
    if distance == 0.0:
        line = "undecided: the position never leaves the goal"
        return Judgement(None, None, None, line, "validate on faster goals")
    error = float(np.sqrt(np.mean((measured - simulated) ** 2))) / distance
    limit = math.hypot(DOUBTFUL_FORCE_ERROR, position_noise(record) / distance)
    shown = (
        f"position error {100.0 * error:.3g} % of the distance from the goal, limit "
        f"{100.0 * limit:.3g} %"
    )
    if error > limit:
        advice = "look at --page, and identify again with this log added"
        return Judgement(False, error, limit, f"this log contradicts the model: {shown}", advice)
    return Judgement(True, error, limit, f"the model reproduces this log: {shown}")


def judged_on_side(judgement: Judgement, place: str, inside: float) -> Judgement:
    """Return the judgement of a model that is valid on one side of a position only.

    Parameters
    ----------
    judgement
        Judgement of the part of the log on this side.
    place
        Valid positions in words.
    inside
        Share of the log on this side, 0 to 1. Below LEAST_VALID, the answer is undecided.
    """
    share = f"{100.0 * inside:.3g} % of the log"
    if inside == 1.0:
        return judgement
    if inside < LEAST_VALID:
        line = f"undecided: only {share} is {place}, where the model is valid"
        return replace(judgement, holds=None, line=line, advice="validate on a log of this side")
    return replace(judgement, line=f"{judgement.line}; judged {place} only, {share}")


def _noise(values: Values, record: MotionRecord, rows: SlipRows) -> float:
    """Return the rms effort of the encoder's noise, relative to the measured effort."""
    gain = float(np.linalg.norm(acceleration_response(record, rows.window)))
    return values["inertia"] * measurement_noise(record) * gain / rows.rms_effort


def _intervals(model: Model, values: Values, rows: SlipRows) -> float:
    """Return the rms change of effort within the model's intervals, relative to the rms effort."""
    modelled = rows.modelled_effort(values, model.laws)
    square = 0.0
    for name in SLIDING:
        low, high = getattr(model.parameters, name).interval
        end = low if values[name] - low > high - values[name] else high
        moved = rows.modelled_effort({**values, name: end}, model.laws)
        square += float(np.mean((moved - modelled) ** 2))
    return math.sqrt(square) / rows.rms_effort


def _stray(
    model: Model, values: Values, motion: SimulatedMotion, limit: float, rows: SlipRows
) -> str | None:
    """Return a text that states how far the simulated position strays; None if it does not."""
    load = None if model.laws is None else model.laws.load
    loaded = load is not None and (load.stiffness is not None or load.gravity is not None)
    if not (loaded or motion.held):
        return None  # without a load or a controller, drift is normal
    travel = model.bench.mechanics.travel
    low, high = float(np.min(motion.measured)), float(np.max(motion.measured))
    if travel is not None:
        low, high = min(low, travel.low), max(high, travel.high)
    effort = limit * rows.rms_effort
    if travel is not None and (
        motion.held or _load_range(load, low, high) > values["coulomb"] + effort
    ):
        reach, where = limit * (high - low), "leaves the travel"
    else:
        mobility = motion.duration / values["inertia"]
        if values["viscous"] > 0.0:
            mobility = min(mobility, 1.0 / values["viscous"])
        reach, where = effort * motion.duration * mobility, "diverges"
    simulated = motion.simulated
    beyond = np.maximum(low - simulated, simulated - high)
    worst = int(np.argmax(beyond))
    if beyond[worst] <= reach:
        return None
    unit = si_unit("position", model.axis)
    return f"the simulated position {where}, to {simulated[worst]:.3g} {unit}"


def _load_range(load: Load | None, low: float, high: float) -> float:
    """Return the change [N m | N] of a load, without its ripples, between positions [rad | m]."""
    if load is None:
        return 0.0
    smooth = msgspec.structs.replace(load, ripple=None, harmonics=())
    return float(np.ptp(load_law(smooth).at(np.linspace(low, high, GRID_POINTS))))
