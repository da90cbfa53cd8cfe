"""Judgement whether a model reproduces a log.

An error is compared with a limit, both relative to the rms of the measured signal:

    limit^2 = DOUBTFUL_FORCE_ERROR^2 + noise^2 + intervals^2

The error is the force error. `noise` is the rms effort that noise of the encoder causes through the
acceleration. `intervals` is the rms change of the model's effort if each sliding parameter moves to
the farther end of its interval; these changes are regarded as independent. `identify` doubts a
model with a force error above DOUBTFUL_FORCE_ERROR.

The effort of a servo is computed from the few counts between goal and position. The error of a
servo is therefore the rms position error, relative to the rms distance between goal and position,
and `intervals` is 0.

A force error of 100 % means that the model explains nothing. An error within a limit above 100 %
therefore decides nothing. Breakaway ramps contain hardly more than the first moments of slip, in
which friction falls from the breakaway to the Coulomb friction. An error above the limit then
decides nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictool.documents.model import Model
from frictool.identify.breakaway.onset_detection import is_ramp
from frictool.identify.fit_result import SLIDING
from frictool.identify.fit_warnings import DOUBTFUL_FORCE_ERROR
from frictool.identify.force_error import SlipRows, Values
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.smoothing import (
    acceleration_response,
    measurement_noise,
    position_noise,
)
from frictool.typing import Vector

EXPLAINS_NOTHING = 1.0  # force error of a model without any effort


@dataclass(frozen=True)
class Judgement:
    """Answer to the question whether a model reproduces a log.

    - holds: True if the error is within the limit, False if not, None if undecided
    - error, limit: judged error and its limit, relative to the measured signal; None if unknown
    - line: the answer in one sentence
    - advice: what to do if the answer is no or undecided
    """

    holds: bool | None
    error: float | None
    limit: float | None
    line: str
    advice: str = ""

    @property
    def warning(self) -> str | None:
        """Return answer and advice if the answer is no or undecided, else None."""
        return None if self.holds else f"{self.line}; {self.advice}"


def judged_force(
    model: Model, values: Values, record: MotionRecord, rows: SlipRows | None, error: float | None
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
    """
    if rows is None or error is None:
        line = "undecided: no sample certainly slips"
        return Judgement(None, None, None, line, "validate on longer strokes")
    limit = _force_limit(model, values, record, rows)
    shown = f"force error {100.0 * error:.3g} %, limit {100.0 * limit:.3g} %"
    if error > limit and is_ramp(record, model.bench):
        line = f"undecided: {shown}; breakaway ramps show too little sliding"
        return Judgement(None, error, limit, line, "validate on strokes or steps")
    if error > limit:
        advice = "look at --page for a resonance, load or friction that the model lacks"
        return Judgement(False, error, limit, f"this log contradicts the model: {shown}", advice)
    if error > DOUBTFUL_FORCE_ERROR and limit >= EXPLAINS_NOTHING:
        line = f"undecided: {shown}; encoder noise or wide intervals hide errors"
        return Judgement(None, error, limit, line, "validate on faster motion")
    return Judgement(True, error, limit, f"the model reproduces this log: {shown}")


def judged_positions(
    record: MotionRecord, goal: Vector, measured: Vector, simulated: Vector
) -> Judgement:
    """Return whether a model reproduces the positions of a servo along its goal.

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
        advice = "look at --page, and add this log to identify"
        return Judgement(False, error, limit, f"this log contradicts the model: {shown}", advice)
    return Judgement(True, error, limit, f"the model reproduces this log: {shown}")


def _force_limit(model: Model, values: Values, record: MotionRecord, rows: SlipRows) -> float:
    size = float(np.sqrt(np.mean(rows.effort**2)))
    gain = float(np.linalg.norm(acceleration_response(record, rows.window)))
    squares = (DOUBTFUL_FORCE_ERROR * size) ** 2
    squares += (values["inertia"] * measurement_noise(record) * gain) ** 2
    modelled = rows.modelled_effort(values, model.laws)
    for name in SLIDING:
        low, high = getattr(model.parameters, name).interval
        end = low if values[name] - low > high - values[name] else high
        moved = rows.modelled_effort({**values, name: end}, model.laws)
        squares += float(np.mean((moved - modelled) ** 2))
    return math.sqrt(squares) / size if size > 0.0 else math.inf
