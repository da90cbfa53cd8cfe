"""Output error: fit of a simulated motion to the measured motion ("simulation error", thesis 4).

No signal is differentiated or filtered. The search starts from the estimates of the power balance.

In open loop, the measured effort drives the simulated axis. An error of the effort shifts the
simulated position for a long time, so that the position residuals do not show the uncertainty of a
parameter. The interval is computed from errors of the effort instead. An observer makes the
simulation follow the measured position; the effort that the observer adds for this purpose is the
effort error. The effort errors of one cluster of strokes (`clusters`) at a time are added to the
simulation, and the resulting change of each parameter is computed. The variance of a parameter is
the sum of the squared changes over all clusters. The effort errors are computed with the parameters
of the power balance, because the parameters of the simulation would make the errors too small. In
closed loop, the simulated controller drives the axis, and the residuals themselves are errors of
the effort.

The inertia is fixed at the estimate of the power balance if the interval of this estimate is less
than half as wide as the interval of the simulation. The simulation then gives the other parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.identify.estimators.power_balance import power_balance
from frictool.identify.estimators.segment_simulation import (
    STEP,
    SegmentSimulation,
    SimulationFit,
    estimate,
    observer_rate,
)
from frictool.identify.estimators.structure_selection import choose_terms
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit, UnusableLogs
from frictool.identify.measurement_faults import refuse_self_explained
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.regression.clusters import clusters
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.identify.rows.effects import declared_effects
from frictool.identify.rows.load_terms import (
    GRAVITY,
    SPRING,
    bench_with_terms,
    laws_of,
    load_values,
)
from frictool.identify.rows.segments import RecordSegment, gap_free_segments, of_each_record
from frictool.identify.rows.slip_fit import WITH_BENCH_INERTIA, known_inertia
from frictool.identify.rows.strokes import find_strokes
from frictool.typing import Matrix, Vector

if TYPE_CHECKING:
    from frictool.engine.bench_position_loop import PositionServo

OUTPUT_ERROR = "output-error"
# the inertia by regression is used if its interval, relative to the interval by simulation, is at
# most this wide
KNOWN_BETTER = 0.5
# largest number of clusters, since each cluster costs a simulation; more clusters are joined
MOST_CLUSTERS = 60


def influences(
    simulated: SegmentSimulation, fitted: SimulationFit, regressed: Mapping[str, float]
) -> Matrix:
    """Return the shift (c, p) of p parameters due to the effort errors of each of c clusters.

    A cluster consists of one or several strokes (`cluster_numbers`). `regressed` are the estimates
    of the power balance, with which the effort errors are computed.
    """
    errors = simulated.missing_effort({**fitted.values, **regressed})
    numbers = cluster_numbers(simulated.segments)
    count = 1 + max(int(number.max()) for number in numbers)
    inverse = np.linalg.pinv(fitted.jacobian)
    out = np.zeros((count, fitted.jacobian.shape[1]))
    first = 0
    for segment, number, error in zip(simulated.segments, numbers, errors, strict=True):
        part = slice(first, first + error.size)
        for c in np.unique(number):
            moved = (
                simulated.of_segment(segment, fitted.values, np.where(number == c, error, 0.0))
                - fitted.residual[part]
            )
            out[c] += inverse[:, part] @ moved
        first += error.size
    return out


def cluster_numbers(segments: Sequence[RecordSegment]) -> list[NDArray[np.int64]]:
    """Return, for each segment, the cluster number of each of its m samples, (m,).

    Successive clusters are joined if there would be more than MOST_CLUSTERS.
    """
    numbers = []
    above = 0
    known = of_each_record(segments, lambda record: (find_strokes(record), observer_rate(record)))
    for segment, (strokes, rate) in zip(segments, known, strict=True):
        part = slice(segment.first, segment.last)
        counts = np.abs(np.gradient(segment.position)) / segment.record.resolution
        shortest = round(1.0 / (rate * segment.record.period))
        number = clusters(strokes.number[part], strokes.sign[part], counts, shortest)
        numbers.append(number + above)
        above += int(number.max()) + 1
    joined = -(-above // MOST_CLUSTERS)
    return [number // joined for number in numbers]


def _open_loop_deviation(
    simulated: SegmentSimulation, fitted: SimulationFit, regressed: Mapping[str, float]
) -> tuple[Vector, Vector]:
    """Return standard deviations (p,) and degrees of freedom (p,) of the parameters in open loop.

    The deviations include the effort errors (`influences`) and the encoder's noise. Early strokes
    influence the simulation for longer than late strokes; Satterthwaite's degrees of freedom
    account for this.
    """
    squares = influences(simulated, fitted, regressed) ** 2
    spread = np.sum(squares, axis=0)
    freedom = np.maximum(spread**2 / np.maximum(np.sum(squares**2, axis=0), 1e-300), 1.0)
    step = max(segment.record.resolution for segment in simulated.segments)
    encoder = step**2 / 12.0 * np.diag(np.linalg.pinv(fitted.jacobian.T @ fitted.jacobian))
    return np.sqrt(spread + encoder), freedom


def _closed_loop_deviation(
    simulated: SegmentSimulation, fitted: SimulationFit
) -> tuple[Vector, Vector]:
    numbers = np.concatenate(cluster_numbers(simulated.segments))
    values = np.array(list(fitted.values.values()))
    columns = -fitted.jacobian
    try:
        solution = solve(
            columns, fitted.residual + columns @ values, np.ones(numbers.size), numbers
        )
    except SingularRegressors as error:
        raise UnusableLogs(
            f"the simulation in closed loop does not determine the parameters: {error}"
        ) from None
    return solution.deviation, solution.freedom


def simulation_error(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    terms: tuple[str, ...],
    servo: PositionServo | None = None,
) -> SlidingFit:
    """Return the fit of an axis with the load terms `terms` by output error.

    The measured effort drives the simulated axis (open loop). With `servo`, the simulated
    controller drives the axis along the logged reference (closed loop). Raises UnusableLogs if the
    logs do not determine Coulomb friction and every load, if no gap-free part is long enough, if
    the search does not converge, or if the reference of a closed loop was not logged.
    """
    start = power_balance(records, bench_with_terms(bench, terms), settings)
    if "coulomb" in start.refused:
        raise UnusableLogs(start.refused["coulomb"])
    undetermined = next(
        (f"{name}: {reason}" for name, reason in start.refused.items() if name not in SLIDING), None
    )
    if undetermined is not None:
        raise UnusableLogs(
            "output-error needs logs that determine every load; a load is not determined "
            f"({undetermined}); use least-squares"
        )
    hidden = start.refused.get("inertia", "")
    if hidden.endswith(WITH_BENCH_INERTIA):
        settings = replace(settings, fixed={**settings.fixed, "inertia": known_inertia(bench)})
    fixed = {name: interval.value for name, interval in settings.fixed.items()}
    simulated = SegmentSimulation(gap_free_segments(records), bench, terms, servo, fixed)
    if not simulated.segments:
        raise UnusableLogs(
            "no gap-free part of the logs is long enough to simulate; use least-squares"
        )
    if servo is not None and any(segment.reference is None for segment in simulated.segments):
        raise UnusableLogs(
            "a closed loop needs the controller's reference in the log (channel reference); "
            "log it, or leave the controller out"
        )
    known = {**start_values(start, bench), **fixed}
    result = estimate(simulated, known)
    half = _widened(
        simulated,
        result,
        _half_widths(simulated, result, known, settings.confidence),
        settings.fixed,
    )
    intervals = {name: Interval.around(result.values[name], w) for name, w in half.items()}
    inertia = start.parameters.get("inertia")
    if (
        servo is None
        and inertia is not None
        and inertia.low > 0.0
        and inertia.half_width < KNOWN_BETTER * half["inertia"]
    ):
        simulated, result, intervals = _with_inertia(simulated, result, known, inertia, settings)
    fit = _fit(simulated, result, intervals)
    return replace(fit, refused={"inertia": hidden}) if hidden.endswith(WITH_BENCH_INERTIA) else fit


def _half_widths(
    simulated: SegmentSimulation,
    fitted: SimulationFit,
    regressed: Mapping[str, float],
    confidence: float,
) -> dict[str, float]:
    if simulated.servo is None:
        deviation, freedom = _open_loop_deviation(simulated, fitted, regressed)
    else:
        deviation, freedom = _closed_loop_deviation(simulated, fitted)
    half = deviation * scipy.special.stdtrit(freedom, 0.5 + 0.5 * confidence)
    return dict(zip(simulated.names, half.tolist(), strict=True))


def _widened(
    simulated: SegmentSimulation,
    fitted: SimulationFit,
    half: dict[str, float],
    fixed: Mapping[str, Interval],
) -> dict[str, float]:
    squares = np.array(list(half.values())) ** 2
    for name, interval in fixed.items():
        reach = max(interval.high - interval.value, interval.value - interval.low)
        step = STEP * max(abs(interval.value), reach, 1e-300)
        changed = replace(simulated, fixed={**simulated.fixed, name: interval.value + step})
        column = (
            changed.residual({**fitted.values, name: interval.value + step}) - fitted.residual
        ) / step
        squares += (np.linalg.lstsq(fitted.jacobian, column, rcond=None)[0] * reach) ** 2
    return dict(zip(half, np.sqrt(squares).tolist(), strict=True))


def _with_inertia(
    simulated: SegmentSimulation,
    fitted: SimulationFit,
    regressed: Mapping[str, float],
    inertia: Interval,
    settings: IdentificationSettings,
) -> tuple[SegmentSimulation, SimulationFit, dict[str, Interval]]:
    """Return simulation, fit and intervals with the inertia fixed at the estimate `inertia`."""
    index = simulated.names.index("inertia")
    others = np.delete(fitted.jacobian, index, axis=1)
    slope = np.linalg.lstsq(others, fitted.jacobian[:, index], rcond=None)[0]
    simulated = replace(simulated, fixed={**simulated.fixed, "inertia": inertia.value})
    again = estimate(simulated, fitted.values)
    half = _widened(
        simulated,
        again,
        _half_widths(simulated, again, regressed, settings.confidence),
        settings.fixed,
    )
    intervals = {"inertia": inertia}
    for (name, half_width), change in zip(half.items(), slope.tolist(), strict=True):
        width = float(np.hypot(half_width, change * inertia.half_width))
        intervals[name] = Interval.around(again.values[name], width)
    return simulated, again, intervals


def start_values(start: SlidingFit, bench: Bench) -> dict[str, float]:
    """Return the values at which the search starts, by parameter name, SI.

    Plausible estimates of the regression `start` are used. The other values come from bench.yaml.
    """
    known = load_values(start.laws)
    for name in SLIDING:
        prior = getattr(bench.mechanics, name)
        interval = start.parameters.get(name)
        known[name] = (
            prior.value
            if interval is None and prior is not None
            else 0.0
            if interval is None
            else interval.value
        )
        if name != "offset" and known[name] <= 0.0:
            known[name] = prior.value
    return known


def _fit(
    simulated: SegmentSimulation, fitted: SimulationFit, intervals: dict[str, Interval]
) -> SlidingFit:
    effort = np.concatenate([segment.effort for segment in simulated.segments])
    size = float(np.sqrt(np.mean(effort**2)))
    error = (
        fitted.residual
        if simulated.servo
        else np.concatenate(simulated.missing_effort(fitted.values))
    )
    norms = np.linalg.norm(fitted.jacobian, axis=0)
    singular = np.linalg.svd(fitted.jacobian / np.where(norms > 0.0, norms, 1.0), compute_uv=False)
    details: dict[str, float | int] = {
        "segments": len(simulated.segments),
        "residual_rms": float(np.sqrt(np.mean(fitted.residual**2))),
    }
    if "inertia" in simulated.names:
        details["inertia_motion_rms"] = _motion_by_parameter(simulated, fitted, "inertia")
    return SlidingFit(
        {name: intervals[name] for name in SLIDING if name in intervals},
        {},
        float(np.sqrt(np.mean(error**2))) / size,
        None,
        float(singular[0] / max(singular[-1], 1e-300)),
        effort.size,
        details,
        laws_of(intervals, simulated.bench),
    )


def _motion_by_parameter(simulated: SegmentSimulation, fitted: SimulationFit, name: str) -> float:
    """Return the rms part of the motion [rad | m] that only the parameter `name` can explain."""
    index = simulated.names.index(name)
    column, others = fitted.jacobian[:, index], np.delete(fitted.jacobian, index, axis=1)
    alone = column - others @ np.linalg.lstsq(others, column, rcond=None)[0]
    return float(np.sqrt(np.mean(alone**2))) * abs(fitted.values[name])


def _insignificant_loads(fit: SlidingFit, terms: tuple[str, ...]) -> tuple[str, ...]:
    """Return spring or gravity in `terms` if the intervals of all their parameters contain 0."""
    load = None if fit.laws is None else fit.laws.load
    gravity = (
        None if load is None or load.gravity is None else (load.gravity.sine, load.gravity.cosine)
    )
    spring = None if load is None or load.stiffness is None else (load.stiffness,)
    estimates = {SPRING: spring, GRAVITY: gravity}
    return tuple(
        term
        for term in terms
        if (values := estimates.get(term)) is not None
        and all(one.interval[0] <= 0.0 <= one.interval[1] for one in values)
    )


def output_error(
    records: list[MotionRecord], bench: Bench, settings: IdentificationSettings
) -> SlidingFit:
    """Return the fit by output error in open loop, with the load terms that predict best.

    Raises UnusableLogs if the records do not determine the parameters, or if the bench declares
    Coulomb friction by direction or an effect that cannot be simulated.
    """
    if bench.load is not None and "coulomb_by_direction" in bench.load.terms:
        raise UnusableLogs(
            "output-error cannot fit coulomb_by_direction; replace it by offset in load.terms"
        )
    effects = declared_effects(bench)
    if effects:
        names = ", ".join(effect.term for effect in effects)
        raise UnusableLogs(f"output-error cannot simulate {names} of load.terms; use least-squares")
    start = power_balance(records, bench, settings)
    refuse_self_explained(start, records)
    terms, errors = choose_terms(records, bench, start_values(start, bench), settings.confidence)
    return simulated_fit(records, bench, settings, terms, errors)


def simulated_fit(
    records: list[MotionRecord],
    bench: Bench,
    settings: IdentificationSettings,
    terms: tuple[str, ...],
    errors: Mapping[str, float],
) -> SlidingFit:
    """Return the fit by output error, without loads that may be 0.

    The first fit has the load terms `terms`. If the bench declares no loads, the fit is repeated
    without the position-dependent loads whose intervals contain 0. The entries of `errors`,
    prediction errors by name, are added to the details of the fit.
    """
    fit = simulation_error(records, bench, settings, terms)
    while bench.load is None and (needless := _insignificant_loads(fit, terms)):
        terms = tuple(term for term in terms if term not in needless)
        fit = simulation_error(records, bench, settings, terms)
    return replace(
        fit,
        details={**fit.details, **{f"held_out_{name}": error for name, error in errors.items()}},
    )
