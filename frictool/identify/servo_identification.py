"""Identification of a smart servo from goals and positions, without a measured current or torque.

The parameters are fitted by output error in closed loop: a simulation of the bench's firmware and
axis follows the logged goal, and the simulated position is compared with the measured position. The
result contains the parameters of the axis, and a bench with the identified constants of the servo.
The viscous friction is that of the axis with the torque enabled; it includes the back-EMF. Errors
of neighbouring samples are dependent. Intervals therefore come from a jackknife over whole logs or,
if there are few logs, over strokes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from msgspec.structs import replace as with_fields

from frictool.adapters.servo_firmware import firmware_law, pendulum_load
from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.axis_logs import SLIDING_LOG
from frictool.identify.breakaway_parameters import NO_RAMPS
from frictool.identify.duplicate_logs import refuse_duplicates
from frictool.identify.estimators.output_error import OUTPUT_ERROR, cluster_numbers
from frictool.identify.estimators.segment_simulation import SimulationFit
from frictool.identify.estimators.servo_simulation import (
    COSINE,
    LOOSE,
    SINE,
    ZERO,
    ServoSimulation,
    driven_viscous,
    fitted,
    servo_quantities,
)
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, UnusableLogs
from frictool.identify.identification import Identification
from frictool.identify.methods import DEFAULT, IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.outcome import accept
from frictool.identify.regression.clusters import FEWEST_CLUSTERS
from frictool.identify.regression.regression import LeastSquaresSolution, solve
from frictool.identify.rows.load_terms import laws_of
from frictool.identify.rows.segments import gap_free_segments
from frictool.typing import IntVector, Matrix, Vector

LARGEST_ERROR = 0.5  # largest rms position error of a fit, relative to the rms motion
# least concentration of the positions about multiples of the encoder step, 0 to 1
CONCENTRATED = 0.5
# least change of the simulated position, in counts, over the bench's range of a parameter
VISIBLE = 1.0
# distance from an end of the bench's range, relative to the range, within which a value is at it
AT_END = 1e-3
METHODS = (DEFAULT, OUTPUT_ERROR)
NO_OFFSET = "a constant effort cannot be separated from the zero angle of the pendulum"


@dataclass(frozen=True)
class ServoIdentification:
    """Identification of a servo, and the bench with the identified constants of the servo."""

    result: Identification
    bench: Bench


def identify_servo(
    records: Sequence[MotionRecord], bench: Bench, method: str, settings: IdentificationSettings
) -> ServoIdentification:
    """Identify the servo of a bench from records of goals and positions.

    Raises
    ------
    UnusableLogs
        If the method does not suit a servo, if the logs show no motion with the torque enabled, or
        if the simulation along the goal does not explain the measured position.
    LogError
        If a log occurs twice.
    """
    if method not in METHODS:
        raise UnusableLogs(
            f"--method {method} needs a measured effort, which a bench with actuator.servo lacks; "
            f"allowed: {', '.join(METHODS)}"
        )
    refuse_duplicates(records)
    _refuse_unusable(records)
    start = _start(records, bench)
    free = _free(records, bench, start)
    segments = gap_free_segments(records)
    if not segments:
        raise UnusableLogs(
            "no gap-free part of the logs is long enough to simulate; log without gaps"
        )
    fixed = {name: value for name, value in start.items() if name not in free}
    simulated = ServoSimulation(segments, bench, free, fixed)
    unseen = _unseen(simulated, start)
    if unseen:
        free = tuple(name for name in free if name not in unseen)
        fixed = {name: value for name, value in start.items() if name not in free}
        simulated = ServoSimulation(segments, bench, free, fixed)
    fit = fitted(simulated, start)
    _refuse_unexplained(simulated, fit)
    without = _without_effect(simulated, fit)
    if without:
        kept = [name not in without for name in simulated.names]
        names = tuple(name for name in simulated.names if name not in without)
        simulated = replace(simulated, names=names)
        fit = replace(fit, jacobian=fit.jacobian[:, kept])
    return _identified(simulated, fit, {**unseen, **without}, settings)


def _refuse_unusable(records: Sequence[MotionRecord]) -> None:
    moving = False
    for record in records:
        assert record.servo is not None
        on = record.servo.drive.enabled > 0.5
        if np.any(on) and np.ptp(record.position[on]) > 2.0 * record.resolution:
            moving = True
    if not moving:
        raise UnusableLogs(
            "no log moves by more than two encoder counts with its torque enabled; record moves "
            "along a goal, and check columns.torque_enabled"
        )
    known = [record.servo is not None and record.servo.pendulum is not None for record in records]
    if any(known) and not all(known):
        raise UnusableLogs(
            f"{Path(records[known.index(False)].name).name} states no pendulum, and "
            f"{Path(records[known.index(True)].name).name} states one; map columns.pendulum_mass "
            "and pendulum_length in all logs, or write `pendulum` in the bench"
        )


def _has_pendulum(records: Sequence[MotionRecord]) -> bool:
    return all(record.servo is not None and record.servo.pendulum is not None for record in records)


def _was_off(records: Sequence[MotionRecord]) -> bool:
    for record in records:
        assert record.servo is not None
        off = record.servo.drive.enabled <= 0.5
        if np.any(off) and np.ptp(record.position[off]) > 2.0 * record.resolution:
            return True
    return False


def _start(records: Sequence[MotionRecord], bench: Bench) -> dict[str, float]:
    start = {name: getattr(bench.mechanics, name).value for name in ("inertia", "coulomb")}
    start |= {name: one.value for name, one in servo_quantities(bench).items()}
    viscous = bench.mechanics.viscous.value
    electrical = start["constant"] * start["back_emf"]
    if _was_off(records):
        start[LOOSE] = max(viscous - electrical, 0.05 * electrical)
    else:
        start["viscous"] = max(viscous, 0.05 * electrical)
    if not _has_pendulum(records) and (bench.load is None or "gravity" in bench.load.terms):
        start |= {SINE: 0.0, COSINE: 0.0}
    return start


def _free(
    records: Sequence[MotionRecord], bench: Bench, start: Mapping[str, float]
) -> tuple[str, ...]:
    """Return the parameters to fit.

    A constant of the servo is fitted if the bench states a range for it, and not an exact value.
    The drive constant is fitted only if the pendulum is known, and the back-EMF constant only if a
    log moves without torque.
    """
    known = servo_quantities(bench)
    exact = {name for name, one in known.items() if one.interval[0] == one.interval[1]}
    if not _has_pendulum(records):
        exact |= {"constant", ZERO}
    if LOOSE not in start:
        exact.add("back_emf")
    return tuple(name for name in start if name not in exact)


def _unseen(simulated: ServoSimulation, start: Mapping[str, float]) -> dict[str, str]:
    """Return a reason for each servo constant that does not affect the simulation with `start`."""
    known = servo_quantities(simulated.bench)
    count = simulated.bench.encoder.resolution
    out: dict[str, str] = {}
    for name in ("goal_speed", "delay"):
        if name not in simulated.names:
            continue
        low, high = (simulated.residual({**start, name: end}) for end in known[name].interval)
        if float(np.max(np.abs(high - low))) < VISIBLE * count:
            out[name] = (
                "no value in the bench's range changes the simulated position; record faster goals"
            )
    return out


def _without_effect(simulated: ServoSimulation, fit: SimulationFit) -> dict[str, str]:
    """Return a reason for each servo constant that does not affect the simulation of the fit."""
    count = simulated.bench.encoder.resolution
    known = servo_quantities(simulated.bench)
    out: dict[str, str] = {}
    for name, column in zip(simulated.names, fit.jacobian.T, strict=True):
        if name in known:
            low, high = known[name].interval
            if float(np.max(np.abs(column))) * (high - low) < VISIBLE * count:
                out[name] = "this constant does not change the fitted position; record faster goals"
    return out


def _refuse_unexplained(simulated: ServoSimulation, fit: SimulationFit) -> None:
    motion = np.concatenate(
        [segment.position - np.mean(segment.position) for segment in simulated.segments]
    )
    error = float(np.sqrt(np.mean(fit.residual**2) / np.mean(motion**2)))
    if error > LARGEST_ERROR:
        raise UnusableLogs(
            f"the simulated position misses {100.0 * error:.3g} % of the motion (allowed: at most "
            f"{100.0 * LARGEST_ERROR:g} %); check columns.reference (goal, direction of the "
            "position) and columns.gain (as in the firmware)"
        )


def _solution(simulated: ServoSimulation, fit: SimulationFit) -> LeastSquaresSolution:
    columns = -_of_driven_viscous(simulated.names, fit)
    values = np.array([_reported(fit.values, name) for name in simulated.names])
    ones = np.ones(fit.residual.size)
    return solve(columns, fit.residual + columns @ values, ones, _clusters(simulated))


def _rounding(simulated: ServoSimulation, fit: SimulationFit) -> Vector:
    """Return the standard deviation (p,) of the parameters due to errors that last for a whole log.

    The position that the firmware rounds is wrong by up to half an encoder count, and the clock of
    the firmware is shifted by up to half a period against the log. Both errors are uniformly
    distributed, constant during a log, and independent between logs.
    """
    inverse = np.linalg.pinv(_of_driven_viscous(simulated.names, fit))
    edges = np.cumsum([one.last - one.first for one in simulated.segments])[:-1]
    law = firmware_law(simulated.bench)
    count = simulated.bench.encoder.resolution
    variance = np.zeros(len(simulated.names))
    for segment, part in zip(simulated.segments, np.split(inverse, edges, axis=1), strict=True):
        moved = law.loop_period * np.gradient(segment.position, segment.record.period)
        for error in (np.full(moved.size, count), moved):
            variance += (part @ error) ** 2 / 12.0
    return np.asarray(np.sqrt(variance))


def _reported(values: Mapping[str, float], name: str) -> float:
    return driven_viscous(values) if name == LOOSE else values[name]


def _of_driven_viscous(names: Sequence[str], fit: SimulationFit) -> Matrix:
    """Return the Jacobian (n, p) with respect to the viscous friction with the torque enabled.

    The Jacobian of `fit` refers to the viscous friction with the torque disabled. That friction is
    smaller by the product of drive constant and back-EMF constant.
    """
    out = fit.jacobian.copy()
    if LOOSE in names:
        loose = out[:, names.index(LOOSE)]
        for name, other in (("constant", "back_emf"), ("back_emf", "constant")):
            if name in names:
                out[:, names.index(name)] -= fit.values[other] * loose
    return out


def _clusters(simulated: ServoSimulation) -> IntVector:
    """Return the cluster (n,) of each sample: the log, or the stroke if there are few logs."""
    segments = simulated.segments
    if len(segments) >= FEWEST_CLUSTERS:
        return np.repeat(np.arange(len(segments)), [one.last - one.first for one in segments])
    return np.concatenate(cluster_numbers(segments))


def _identified(
    simulated: ServoSimulation,
    fit: SimulationFit,
    unseen: Mapping[str, str],
    settings: IdentificationSettings,
) -> ServoIdentification:
    bench = simulated.bench
    solution = _solution(simulated, fit)
    names = ["viscous" if name == LOOSE else name for name in simulated.names]
    rounding = _rounding(simulated, fit)
    wider = replace(solution, deviation=np.hypot(solution.deviation, rounding))
    half = wider.half_width(settings.confidence)
    intervals = {
        name: Interval.around(value, width)
        for name, value, width in zip(names, solution.value.tolist(), half.tolist(), strict=True)
    }
    records = list(dict.fromkeys(segment.record for segment in simulated.segments))
    gravity = _gravity(intervals, bench)
    reasons = {"offset": NO_OFFSET, "breakaway": NO_RAMPS, **_constant_reasons(records, bench)}
    reasons |= unseen
    offered = {name: intervals[name] for name in SLIDING if name in intervals}
    outcome = accept(offered, bench, reasons)
    constants, warnings = _constants(intervals, bench)
    laws = laws_of(gravity, bench)
    rms = float(np.sqrt(np.mean(fit.residual**2)))
    sliding = SlidingFit(
        offered,
        {},
        rms,
        None,
        solution.condition,
        fit.residual.size,
        {
            "segments": len(simulated.segments),
            "position_error_rms": rms,
            "position_error_mean": float(np.mean(np.abs(fit.residual))),
        },
        laws,
        method=OUTPUT_ERROR,
        why="the bench has a servo, whose firmware drives the simulation along the logged goal",
        constants=constants,
    )
    result = Identification(
        outcome.identified,
        outcome.refused,
        sliding,
        laws=laws,
        narrowed=outcome.narrowed,
        method=OUTPUT_ERROR,
        confidence=settings.confidence,
        kinds={record.name: SLIDING_LOG for record in records},
        warnings=(*warnings, *_between_counts(records)),
    )
    return ServoIdentification(result, _with_constants(bench, constants))


def _gravity(intervals: Mapping[str, Interval], bench: Bench) -> dict[str, Interval]:
    """Return the gravity torque (sine, cosine) of a known pendulum or of the fit; else {}."""
    if SINE in intervals:
        return {name: intervals[name] for name in (SINE, COSINE)}
    nominal = pendulum_load(bench.pendulum)
    if nominal is None:
        return {}
    known = servo_quantities(bench)[ZERO]
    angle = intervals.get(ZERO, Interval(known.value, *known.interval))
    torque = nominal.torque
    return {
        SINE: Interval.around(torque * np.cos(angle.value), torque * angle.half_width**2),
        COSINE: Interval.around(torque * np.sin(angle.value), torque * angle.half_width),
    }


def _constant_reasons(records: Sequence[MotionRecord], bench: Bench) -> dict[str, str]:
    known = servo_quantities(bench)
    out = {}
    if not _has_pendulum(records) and known["constant"].low is not None:
        out["constant"] = "only a log with a known pendulum determines the drive constant"
    if not _was_off(records) and known["back_emf"].low is not None:
        out["back_emf"] = "no log moves with its torque disabled; record a free swing"
    return out


def _constants(
    intervals: Mapping[str, Interval], bench: Bench
) -> tuple[dict[str, Quantity], list[str]]:
    """Return the identified servo constants, and a warning for each value at an end of its range.

    The interval of each constant is limited to the range in bench.yaml.
    """
    out, warnings = {}, []
    for name, known in servo_quantities(bench).items():
        if name not in intervals:
            continue
        low, high = known.interval
        one = intervals[name]
        near = AT_END * (high - low)
        if one.value - low < near or high - one.value < near:
            end = low if one.value - low < near else high
            warnings.append(
                f"{name}: the fit reaches an end of the bench's range, {end:.4g} {known.unit}; "
                "widen this range if it is not certain"
            )
        out[name] = Quantity(
            one.value, max(one.low, low), min(max(one.high, one.value), high), known.unit
        )
    return out, warnings


def _with_constants(bench: Bench, constants: Mapping[str, Quantity]) -> Bench:
    servo = bench.actuator.servo
    assert servo is not None
    of_servo = {name: one for name, one in constants.items() if name != "constant"}
    actuator = with_fields(
        bench.actuator,
        servo=with_fields(servo, **of_servo),
        constant=constants.get("constant", bench.actuator.constant),
    )
    return with_fields(bench, actuator=actuator)


def _between_counts(records: Sequence[MotionRecord]) -> list[str]:
    count = 0
    for record in records:
        phase = np.exp(2j * np.pi * record.position / record.resolution)
        moving = np.flatnonzero(np.diff(record.position) != 0.0)
        if moving.size and abs(np.mean(phase[moving])) < CONCENTRATED:
            count += 1
    if count == 0:
        return []
    return [
        f"{count} of {len(records)} logs have positions between the encoder's counts (interpolated "
        "or filtered); the intervals come from whole logs or strokes, not from samples"
    ]
