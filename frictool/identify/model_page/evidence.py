"""Data for the figures of a model: slipping samples with residuals, and predicted strokes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
import scipy

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.provenance import provenance_of_call
from frictool.errors import NoSolutionError
from frictool.identify.axis_logs import RAMP_LOG
from frictool.identify.estimators.structure_selection import halves
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.force_error import friction_in_slip, motion_rows
from frictool.identify.from_logs import IdentifiedModel
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationRequest
from frictool.identify.model_document import model_of
from frictool.identify.motion_record import MotionRecord
from frictool.identify.rows.segments import gap_free_segments
from frictool.identify.validate.validation import parameter_values, replayed_position
from frictool.typing import Vector

CELLS = 720  # number of cells of the travel; the residual is averaged in each cell
SPECTRUM_POINTS = 600
FEWEST_CELLS = 16  # least number of cells with samples that give a spectrum


@dataclass(frozen=True)
class SlipSamples:
    """Smoothed samples (n,) of all logs at which the axis certainly slips, SI (`force_error.py`).

    - time: time, with all logs placed one after the other, s
    - position, velocity: smoothed motion, rad and rad/s | m and m/s
    - residual: measured effort minus the effort of the model, N m | N
    - friction: residual times direction, plus the mean friction of the model over the travel,
      N m | N
    """

    time: Vector
    position: Vector
    velocity: Vector
    residual: Vector
    friction: Vector


def friction_over_speed(model: Model, speed: Vector, direction: float) -> Vector:
    """Return the mean friction in slip (n,) [N m | N] at speeds (n,) >= 0.

    `direction` is +1 or -1. The mean is taken over the position.
    """
    laws = model.laws and msgspec.structs.replace(model.laws, position=None)
    velocity = direction * np.maximum(speed, np.finfo(float).tiny)
    values = parameter_values(model)
    return direction * friction_in_slip(values, laws, np.zeros(speed.size), velocity)


def slip_samples(model: Model, records: Sequence[MotionRecord]) -> SlipSamples | None:
    """Return the slipping samples of all records; None if no sample certainly slips."""
    values = parameter_values(model)
    times = []
    rows = []
    begin = 0.0
    for record in records:
        first, last = float(record.time[0]), float(record.time[-1])
        for one in motion_rows([record], model.bench):
            rows.append(one)
            times.append(one.time - first + begin)
        begin += last - first + record.period
    if not rows:
        return None
    velocity = np.concatenate([one.velocity for one in rows])
    residual = np.concatenate(
        [one.effort - one.modelled_effort(values, model.laws) for one in rows]
    )
    friction = np.empty(velocity.size)
    for side, chosen in ((1.0, velocity >= 0.0), (-1.0, velocity < 0.0)):
        friction[chosen] = (
            friction_over_speed(model, np.abs(velocity[chosen]), side) + side * residual[chosen]
        )
    return SlipSamples(
        np.concatenate(times),
        np.concatenate([one.position for one in rows]),
        velocity,
        residual,
        friction,
    )


def mean_over_position(samples: SlipSamples, sign: float) -> tuple[Vector, Vector]:
    """Return cell centres (m,) [rad | m] over the travel, and mean residuals (m,) [N m | N].

    The travel is divided into CELLS cells of equal length. `sign` is the direction of motion, +1 or
    -1, or 0 for both directions. Cells without samples are left out.
    """
    chosen = samples.velocity * sign >= 0.0
    position, residual = samples.position[chosen], samples.residual[chosen]
    if position.size == 0:
        return np.empty(0), np.empty(0)
    low, high = float(samples.position.min()), float(samples.position.max())
    width = (high - low) / CELLS or 1.0
    cell = np.minimum(((position - low) / width).astype(np.int64), CELLS - 1)
    count = np.bincount(cell, minlength=CELLS)
    total = np.bincount(cell, residual, CELLS)
    passed = count > 0
    centre = np.asarray(low + width * (np.arange(CELLS) + 0.5), dtype=np.float64)
    return centre[passed], total[passed] / count[passed]


def position_spectrum(samples: SlipSamples) -> tuple[Vector, Vector] | None:
    """Return wave numbers (p,), 1/rad | 1/m, and amplitudes (p,), N m | N, of the mean residual.

    The spectrum is the Lomb-Scargle periodogram of the mean residual in each cell, from one cycle
    per travel to one cycle per four cells. The result is None if too few cells contain samples.
    """
    centre, mean = mean_over_position(samples, 0.0)
    if centre.size < FEWEST_CELLS:
        return None
    travel = float(np.ptp(centre))
    span = np.linspace(1.0, CELLS / 4.0, SPECTRUM_POINTS)
    numbers = np.asarray(span / travel, dtype=np.float64)
    centred = mean - mean.mean()
    power = scipy.signal.lombscargle(centre - centre[0], centred, 2.0 * np.pi * numbers)
    return numbers, np.sqrt(4.0 * np.maximum(power, 0.0) / centre.size)


@dataclass(frozen=True)
class PositionPrediction:
    """Measured and simulated position (n,), rad | m, of a segment of a log over time (n,), s."""

    log: str
    time: Vector
    measured: Vector
    simulated: Vector


@dataclass(frozen=True)
class HeldOutPositions:
    """Positions of each half of the logs, predicted by a model identified from the other half.

    - held_out: False if the logs are too short for halves, or if one half does not determine a
      model; the model then predicts the logs from which it was identified
    - segments: predictions, one for each gap-free part of the records
    """

    held_out: bool
    segments: tuple[PositionPrediction, ...]

    @property
    def fit(self) -> float:
        """Return the fit in per cent: 100 (1 - |measured - simulated|/|measured - mean|)."""
        error = sum(float(np.sum((one.measured - one.simulated) ** 2)) for one in self.segments)
        size = sum(
            float(np.sum((one.measured - one.measured.mean()) ** 2)) for one in self.segments
        )
        return 100.0 * (1.0 - float(np.sqrt(error / size))) if size > 0.0 else float("nan")


def sliding_records(outcome: IdentifiedModel) -> list[MotionRecord]:
    """Return the records of motion; breakaway ramps are left out."""
    kinds = outcome.result.kinds
    return [record for record in outcome.records if kinds.get(record.name) != RAMP_LOG]


def held_out_positions(
    outcome: IdentifiedModel, request: IdentificationRequest
) -> HeldOutPositions | None:
    """Predict the positions of each half of the logs with a model identified from the other half.

    The result is None if no log has a measured position, or if the simulation fails.
    """
    records = [one for one in sliding_records(outcome) if one.velocity is None]
    if not records:
        return None
    bench = outcome.model.bench
    sides = halves(records)
    ramps = [
        *outcome.ramps,
        *(one for one in outcome.records if outcome.result.kinds.get(one.name) == RAMP_LOG),
    ]
    try:
        if sides is not None:
            models = [_half_model(side, ramps, bench, request) for side in sides]
            pairs = zip(models[::-1], sides, strict=True)
            segments = [one for model, side in pairs for one in _predicted(model, side)]
            return HeldOutPositions(True, tuple(sorted(segments, key=lambda one: one.log)))
    except (UnusableLogs, NoSolutionError):
        pass  # a half does not determine a model
    try:
        return HeldOutPositions(False, tuple(_predicted(outcome.model, records)))
    except NoSolutionError:
        return None


def _half_model(
    side: list[MotionRecord],
    ramps: list[MotionRecord],
    bench: Bench,
    request: IdentificationRequest,
) -> Model:
    half = identify_records(side, ramps, bench, request.method, request.settings)
    return model_of(half, bench, provenance_of_call("frictool.identify.identify", bench=bench))


def _predicted(model: Model, records: Sequence[MotionRecord]) -> list[PositionPrediction]:
    return [
        PositionPrediction(
            segment.record.name,
            segment.record.time[segment.first : segment.last],
            segment.position,
            replayed_position(model, segment),
        )
        for segment in gap_free_segments(records)
    ]
