"""Scales, from a rig and a specification, that make a candidate's parameters dimensionless.

dead time     T (1 + delay) + lag     the zero-order hold and the difference of two positions
                                      (the speed) add T/2 each
loop gain     K/J, largest and smallest
braking       (K limit + F)/J         deceleration of the slowest plant
time          response_time_95_s
length        longest step of the test
band          largest error at rest: static_error (if missing, STATIC_ERROR times the length), but
              at least one encoder step
release       True if the drive may be switched off at rest

T is the sample period, `delay` the delay in samples, and `lag` the time constant of the drive.
`limit` is the smaller of the drive's limit and the specified peak. K is the effort per unit of the
drive, J the inertia, and F the Coulomb friction.
"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.adapters.model_polytope import polytope
from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.documents.spec import Spec
from frictool.errors import NoSolutionError
from frictool.synth.load_disturbance import disturbance

STATIC_ERROR = 0.04  # width of the band without static_error, as a share of the step


@dataclass(frozen=True)
class DesignScales:
    """Scales of one bench and specification, in SI units.

    - response, step: specified response time [s], and length of the longest step [rad | m]
    - dead_time: dead time of the loop without the speed filter [s]
    - gain: smallest and largest acceleration per unit of the drive, K/J
    - braking: deceleration of the slowest plant at the largest drive [rad/s^2 | m/s^2]
    - friction: deceleration by Coulomb friction, F/J of the model [rad/s^2 | m/s^2]
    - band: largest position error at rest [rad | m]
    - releases: True if the drive may be switched off at rest (`may_release`)
    """

    bench: Bench
    response: float
    step: float
    dead_time: float
    gain: tuple[float, float]
    braking: float
    friction: float
    band: float
    releases: bool

    @property
    def period(self) -> float:
        """Return the sample period [s]."""
        return self.bench.sample_period_s

    @property
    def count(self) -> float:
        """Return the encoder step [rad | m]."""
        return self.bench.encoder.resolution


def design_scales(model: Model, spec: Spec, step: float, response: float) -> DesignScales:
    """Return the scales of a model and a specification.

    `step` [rad | m] is the longest step of the test, `response` [s] its allowed response time.
    Raises NoSolutionError if the specified static error is less than an encoder step, or if no
    controller can hold the load (`disturbance`).
    """
    bench = model.bench
    count = bench.encoder.resolution
    if spec.static_error is not None and spec.static_error.value < count:
        unit = si_unit("position", bench.axis)
        raise NoSolutionError(
            f"static_error: found {spec.static_error.value:.4g} {unit}; allowed: at least the "
            f"encoder's step, {count:.4g} {unit}, the smallest measurable error"
        ).at("spec", "static_error")
    drive = bench.actuator.limit.value
    if spec.drive_peak is not None:
        drive = min(drive, spec.drive_peak.value)
    vertices = polytope(model).vertices
    gains = [point.constant / point.inertia for point in vertices]
    today = model.parameters
    band = STATIC_ERROR * step if spec.static_error is None else spec.static_error.value
    return DesignScales(
        bench=bench,
        response=response,
        step=step,
        dead_time=bench.sample_period_s * (1 + bench.delay_samples)
        + bench.actuator.loop_time_constant_s,
        gain=(min(gains), max(gains)),
        braking=min((point.constant * drive + point.coulomb) / point.inertia for point in vertices),
        friction=today.coulomb.value / today.inertia.value,
        band=max(band, count),
        releases=may_release(model, spec),
    )


def may_release(model: Model, spec: Spec) -> bool:
    """Return True if the drive may be switched off at rest.

    The breakaway friction of every plant must hold the load. If `rest` of the specification limits
    the drive at rest to less than the load needs, the drive must be switched off in any case.
    """
    load = disturbance(model)
    held = load.total == 0.0 or load.total < load.breakaway
    constant = model.bench.actuator.constant.interval[0]
    return held or (spec.rest is not None and constant * spec.rest.drive < load.total)
