"""Comparison of a simulated model with the measured axis.

In an open loop, the measured effort drives the model. In a closed loop, the bench's controller
drives the model along the measured reference, and the effort of the simulated controller is
compared with the measured effort, too. If the bench has a servo, the servo's firmware drives the
model along the logged goal.

If the model is valid on one side of a position only (`valid_side`), the part of the log on this
side is compared. Each simulation starts where the log enters this side, with the measured speed.

If the friction of the model depends on temperature and the log contains a temperature, the friction
is computed for the mean temperature of each simulated part of the log.

The error of a signal is the norm of measured minus simulated values divided by the norm of the
measured values, without the first `skip` samples. Velocity and acceleration are differences over
time of the measured and of the simulated position, after the low-pass of the published pipeline
(`inverse_dynamic`). The force error has the definition of `identify` (`force_error.py`): the part
of the measured effort that the model does not explain for the measured motion, over the samples
that certainly slip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy

from frictool.adapters.axis_dynamic_law import dynamic_law_of
from frictool.adapters.axis_model import axis_of, load_of
from frictool.adapters.servo_firmware import firmware_law
from frictool.adapters.temperature_factors import factors_at
from frictool.documents.model import Model
from frictool.documents.quantity import Axis, si_unit
from frictool.engine.bench_position_loop import PositionServo, follow_reference
from frictool.engine.disturbances_and_faults import with_friction
from frictool.engine.dynamic_law_axis import with_contact, with_dynamic_law
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.engine.status_codes import MESSAGES, NOT_FINITE, OK
from frictool.errors import LogError, NoSolutionError
from frictool.identify.estimators.servo_simulation import ZERO, servo_quantities, simulated_position
from frictool.identify.fit_result import CURVE, PARAMETERS
from frictool.identify.force_error import SlipRows, slip_rows
from frictool.identify.motion_record import MotionRecord, record_of
from frictool.identify.rows.load_terms import load_values
from frictool.identify.rows.segments import RecordSegment, gap_free_segments
from frictool.identify.validate.judgement import (
    LEAST_VALID,
    Judgement,
    SimulatedMotion,
    judged_force,
    judged_on_side,
    judged_positions,
)
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import Log
from frictool.plant.axis import VELOCITY
from frictool.runtime.object_view import ResultView
from frictool.typing import Vector

OPEN, CLOSED, SERVO = "open", "closed", "servo"
FILTER_ORDER = 4
FIELDS = (*PARAMETERS, *CURVE)  # fields of a model's parameters
LARGEST_SQUARED = 1e-6 * float(np.finfo(float).max) ** 0.5  # sums of squares stay finite
HIGHEST_CUTOFF = 0.4  # highest cut-off frequency of the low-pass, relative to the sampling rate


@dataclass(frozen=True)
class ValidationRequest:
    """Options of a validation.

    Attributes
    ----------
    skip : int
        Number of samples left out at the start of each gap-free part of the log.
    cutoff_hz : float
        Cut-off frequency of the low-pass for velocity and acceleration, Hz.
    servo : PositionServo or None
        Controller from position to effort, for a closed loop along the measured reference. If None,
        the measured effort drives the model (open loop).
    moving : bool
        True to start the simulation at the measured speed, False to start at rest.
    """

    skip: int = 20
    cutoff_hz: float = 100.0
    servo: PositionServo | None = None
    moving: bool = False


USUAL = ValidationRequest()


@dataclass(frozen=True, eq=False, repr=False)
class Validation(ResultView):
    """Measured and simulated signals of an axis, and the errors of the simulation.

    - loop: `open`, `closed` or `servo`
    - skip: number of samples left out at the start of each gap-free part of the log
    - time: time of each sample, (n,), s
    - measured, simulated: signals (n,) by name, SI units; the force is NaN at samples where it is
      unknown
    - position_rmse: rms position error, rad | m
    - largest: largest position error, rad | m
    - errors: relative error of each signal, by name; None if undefined
    - judgement: whether the model reproduces the log
    - reference: reference of a closed loop, (n,), rad | m, or None
    """

    axis: Axis
    loop: str
    skip: int
    time: Vector
    measured: dict[str, Vector]
    simulated: dict[str, Vector]
    position_rmse: float
    largest: float
    errors: dict[str, float | None]
    judgement: Judgement
    reference: Vector | None = None

    def as_json(self) -> dict[str, Any]:
        """Return loop, number of samples, errors and judgement as a JSON object."""
        unit = si_unit("position", self.axis)
        return {
            "loop": self.loop,
            "samples": int(self.time.size),
            "skip_samples": self.skip,
            f"position_rmse_{unit}": self.position_rmse,
            f"position_error_largest_{unit}": self.largest,
            **{f"{name}_error_rel": error for name, error in self.errors.items()},
            "judged_error_rel": self.judgement.error,
            "judged_error_limit_rel": self.judgement.limit,
            "reproduces": self.judgement.holds,
            "warnings": [] if self.judgement.warning is None else [self.judgement.warning],
        }

    def position_text(self) -> str:
        """Return the position errors as text, with a note if they exceed the measured range.

        If the rms error exceeds this range, most of the error is drift, because no feedback holds
        the position.
        """
        unit = si_unit("position", self.axis)
        errors = f"{self.position_rmse:.4g} {unit} rms, {self.largest:.4g} {unit} at most"
        extent = float(np.ptp(self.measured["position"]))
        if self.position_rmse <= extent:
            return errors
        return f"{errors}: the simulation leaves the measured range of {extent:.3g} {unit} by far"

    def lines(self) -> list[str]:
        """Return loop, number of samples, errors and judgement as lines of text."""
        how = {
            OPEN: "the measured effort drives the model",
            CLOSED: "controller and model follow the measured reference",
            SERVO: "the servo's firmware drives the model along the logged goal",
        }
        return [
            f"{self.loop} loop: {how[self.loop]}; {self.time.size} samples, without the first "
            f"{self.skip}",
            f"position error   {self.position_text()}",
            *(f"{name:<16} {_shown(error)}" for name, error in self.errors.items()),
            self.judgement.line,
        ]


def _shown(error: float | None) -> str:
    return (
        "unknown: no sample certainly slips"
        if error is None
        else f"{100.0 * error:.4g} % of the measured signal"
    )


def validate(model: Model, log: Log, request: ValidationRequest = USUAL) -> Validation:
    """Simulate a model with the signals of a log, and return the errors.

    Parameters
    ----------
    model
        Model to validate.
    log
        Log with the measured position, and with the effort or the drive.
    request
        Loop, start and filter of the simulation.

    Returns
    -------
    Validation
        Measured and simulated signals (n,) in SI units, and their errors.

    Raises
    ------
    LogError
        If the log has no motion, if no gap-free part is longer than the skipped samples, if a
        closed loop is requested although the log has no reference or the bench has a servo, or if
        the log does not fit the bench of the model.
    NoSolutionError
        If the simulation fails.
    """
    skip = request.skip
    record = record_of(match_bench(log, model.bench), model.bench)
    if record.servo is not None and request.servo is not None:
        raise LogError(
            record.name,
            "the bench has a servo, whose firmware is the controller; leave the gains out",
        )
    _check(record, request)
    side = model.valid_side
    inside = None
    if side is not None:
        valid = side.sign * (record.position - side.bound) > 0.0
        inside = float(np.mean(valid))
        part = record.inside(valid)
        if LEAST_VALID <= inside < 1.0 and part is not None:
            record = part
            request = replace(request, moving=True)
    pieces = _pieces(record, skip)
    cutoff = min(request.cutoff_hz, HIGHEST_CUTOFF / record.period)
    rows = slip_rows(record, model.bench)
    force = _force(model, record, rows)
    runs = [
        _run(model, piece, request, cutoff)
        | {"force": (force[0][piece.first : piece.last], force[1][piece.first : piece.last])}
        for piece in pieces
    ]
    signals = {
        name: tuple(np.concatenate([run[name][side][skip:] for run in runs]) for side in (0, 1))
        for name in runs[0]
    }
    goal = _reference(pieces, skip)
    if record.servo is None or goal is None:
        duration = record.period * max(piece.last - piece.first for piece in pieces)
        measured, simulated = signals["position"]
        motion = SimulatedMotion(measured, simulated, duration, request.servo is not None)
        error = _relative(*signals["force"])
        judgement = judged_force(model, parameter_values(model), record, rows, error, motion)
    else:
        judgement = judged_positions(record, goal, *signals["position"])
    if side is not None and inside is not None:
        judgement = judged_on_side(judgement, side.place(model.axis), inside)
    return _compared(model.axis, request, signals, pieces, judgement)


def _check(record: MotionRecord, request: ValidationRequest) -> None:
    if record.velocity is not None:
        raise LogError(
            record.name,
            "has a velocity and no position; a validation compares positions; log the position",
        )
    if float(np.ptp(record.position)) <= 2.0 * record.resolution:
        raise LogError(
            record.name, "the position does not change; validate the model on a log of motion"
        )
    duration = float(record.time[-1] - record.time[0])
    if request.cutoff_hz * duration < 1.0:
        raise LogError(
            record.name,
            f"lasts {duration:.3g} s; needed: at least one period of the cut-off, "
            f"{1.0 / request.cutoff_hz:.3g} s; raise --cutoff-hz",
        )
    if request.servo is not None and record.reference is None:
        raise LogError(
            record.name,
            "has no channel `reference`, which a closed loop follows; leave the gains out to "
            "validate the open loop",
        )


def _pieces(record: MotionRecord, skip: int) -> list[RecordSegment]:
    pieces = [
        piece
        for piece in gap_free_segments([record])
        if piece.last - piece.first > skip + 3 * FILTER_ORDER
    ]
    if not pieces:
        raise LogError(
            record.name,
            f"has no gap-free part longer than the {skip} samples to skip; skip fewer",
        )
    return pieces


def _compared(
    axis: Axis,
    request: ValidationRequest,
    signals: dict[str, tuple[Vector, ...]],
    pieces: list[RecordSegment],
    judgement: Judgement,
) -> Validation:
    skip, closed = request.skip, request.servo is not None
    gap = signals["position"][0] - signals["position"][1]
    loop = SERVO if pieces[0].record.servo is not None else CLOSED if closed else OPEN
    return Validation(
        axis,
        loop,
        skip,
        np.concatenate([piece.record.time[piece.first + skip : piece.last] for piece in pieces]),
        {name: pair[0] for name, pair in signals.items()},
        {name: pair[1] for name, pair in signals.items()},
        float(np.sqrt(np.mean(gap**2))),
        float(np.max(np.abs(gap))),
        {name: _relative(pair[0], pair[1]) for name, pair in signals.items()},
        judgement,
        _reference(pieces, skip) if loop != OPEN else None,
    )


def _reference(pieces: list[RecordSegment], skip: int) -> Vector | None:
    references = [piece.reference[skip:] for piece in pieces if piece.reference is not None]
    return np.concatenate(references) if references else None


def _relative(measured: Vector, simulated: Vector) -> float | None:
    known = np.isfinite(measured) & np.isfinite(simulated)
    size = float(np.linalg.norm(measured[known]))
    return float(np.linalg.norm((measured - simulated)[known])) / size if size > 0.0 else None


def parameter_values(model: Model) -> dict[str, float]:
    """Return the values of the model's parameters by name, in SI units."""
    return {
        name: estimate.value
        for name in FIELDS
        if (estimate := getattr(model.parameters, name)) is not None
    }


def _force(model: Model, record: MotionRecord, rows: SlipRows | None) -> tuple[Vector, Vector]:
    measured, modelled = np.full((2, record.position.size), np.nan)
    if rows is not None:
        values = parameter_values(model)
        measured[rows.index] = rows.effort
        modelled[rows.index] = rows.modelled_effort(values, model.laws)
    return measured, modelled


def _run(
    model: Model, piece: RecordSegment, request: ValidationRequest, cutoff: float
) -> dict[str, tuple[Vector, Vector]]:
    record, servo = piece.record, request.servo
    if record.servo is not None:
        return _compared_positions(piece, _servo_position(model, piece), cutoff)
    p, state = _free_axis(model, piece)
    load = load_of(model).as_array()
    n = piece.last - piece.first
    period = piece.record.period
    if not request.moving:
        state[VELOCITY] = 0.0
    x = np.empty(n)
    v = np.empty(n)
    u = np.empty(n)
    effort = piece.effort
    simulated_effort: dict[str, tuple[Vector, Vector]] = {}
    if servo is not None:
        assert piece.reference is not None
        status = follow_reference(
            p, load, state, np.array(servo), piece.reference, float(effort[0]), period, x, v, u
        )
        simulated_effort["effort"] = (effort, u)
    else:
        status = replay(p, load, state, effort, piece.position, FREE, period, x, v)
    if status == OK and not float(np.max(np.abs(x))) < LARGEST_SQUARED * period**2:
        status = NOT_FINITE
    if status != OK:
        raise NoSolutionError(f"{record.name}: {MESSAGES[status]}; check the model's parameters")
    return _compared_positions(piece, x, cutoff) | simulated_effort


def _compared_positions(
    piece: RecordSegment, simulated: Vector, cutoff: float
) -> dict[str, tuple[Vector, Vector]]:
    pair = (piece.position, simulated)
    rates = [_rates(position, piece.record.period, cutoff) for position in pair]
    return {
        "position": pair,
        "velocity": (rates[0][0], rates[1][0]),
        "acceleration": (rates[0][1], rates[1][1]),
    }


def _servo_position(model: Model, piece: RecordSegment) -> Vector:
    zero = servo_quantities(model.bench)[ZERO].value
    values = {**parameter_values(model), **load_values(model.laws), ZERO: zero}
    status, position = simulated_position(piece, model.bench, values, firmware_law(model.bench))
    if status != OK or not np.all(np.isfinite(position)):
        raise NoSolutionError(f"{piece.record.name}: {MESSAGES[status]}")
    return position


def _free_axis(model: Model, piece: RecordSegment) -> tuple[Vector, Vector]:
    """Return the parameters of the axis without end stops, and the state at the start of `piece`.

    Friction over temperature is computed for the mean measured temperature of this segment. Raises
    NoSolutionError if the model's presliding law does not support the axis.
    """
    axis = axis_of(model)
    try:
        dynamic = dynamic_law_of(model, axis)
    except ValueError as error:
        raise NoSolutionError(f"{model.name}: presliding: {error}") from None
    p = replay_parameters(
        axis._replace(
            laws=axis.laws._replace(stops=(-math.inf, math.inf)), lag=piece.record.effort_lag
        )
    )
    state = piece.start()
    if dynamic is not None:
        p, state = with_dynamic_law(p, dynamic), with_contact(state, dynamic)
    law = model.laws.temperature if model.laws is not None else None
    warm = piece.record.temperature
    if law is None or warm is None:
        return p, state
    factors = factors_at(law, float(np.mean(warm.values[piece.first : piece.last])))
    return with_friction(p, factors["viscous"], factors["coulomb"]), state


def replayed_position(model: Model, piece: RecordSegment) -> Vector:
    """Return the position (n,) [rad | m] of a model that is driven by the measured effort.

    The simulation covers one segment of a record, and starts at the measured position and speed.
    Raises NoSolutionError if the simulation fails.
    """
    n = piece.last - piece.first
    position, velocity = np.empty(n), np.empty(n)
    p, state = _free_axis(model, piece)
    status = replay(
        p,
        load_of(model).as_array(),
        state,
        piece.effort,
        piece.position,
        FREE,
        piece.record.period,
        position,
        velocity,
    )
    if status != OK or not np.all(np.isfinite(position)):
        raise NoSolutionError(f"{piece.record.name}: {MESSAGES[status]}")
    return position


def _rates(position: Vector, period: float, cutoff: float) -> tuple[Vector, Vector]:
    b, a = scipy.signal.butter(FILTER_ORDER, 2.0 * cutoff * period)
    velocity = np.gradient(scipy.signal.filtfilt(b, a, position - position[0]), period)
    return velocity, np.gradient(velocity, period)
