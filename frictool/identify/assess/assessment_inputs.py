"""Inputs of an assessment: encoder, sample period, limits, a-priori parameters, proposed test."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.excite.bench_limits import axis_known, limits_of, sensing_of
from frictool.identify.excite.breakaway_ramps import SEGMENTS, breakaway_range, effort_rate
from frictool.identify.excite.cramer_rao import PlannedStroke, PriorAxis, SensorPrecision
from frictool.identify.excite.sines import plan

# largest ratio of the longest to the shortest a-priori time constant for which a filter is tuned
KNOWN_DYNAMICS = 10.0
PRESLIDING = {"linear": 1e-5, "rotary": 1e-3}  # m (table 3.1); rad (10 um at a radius of 10 mm)


@dataclass(frozen=True)
class AssessmentInputs:
    """Inputs of the assessment, in SI units.

    - axis: a-priori inertia, friction, backlash and loads of the axis
    - sensing: sample period, encoder step, noise of the effort
    - speed, effort: largest speed, rad/s | m/s, and largest effort, N m | N
    - strokes: strokes of the proposed sines
    - fastest, slowest: bounds of the a-priori time constant inertia/viscous, s
    - known: relative half width of the a-priori interval of each parameter
    - inertia: lower end, value and upper end of the a-priori interval, kg m^2 | kg
    - breakaway: expected breakaway, N m | N
    - rate: slope of the proposed ramps, N m/s | N/s
    - onsets: number of breakaways in the proposed ramps (slow rises of the drive)
    - presliding: expected presliding distance, rad | m

    For recorded motion, the last four fields (breakaway to presliding) are 0.
    """

    axis: PriorAxis
    sensing: SensorPrecision
    speed: float
    effort: float
    strokes: tuple[PlannedStroke, ...]
    fastest: float
    slowest: float
    known: dict[str, float]
    inertia: tuple[float, float, float]
    breakaway: float = 0.0
    rate: float = 0.0
    onsets: float = 0.0
    presliding: float = 0.0

    @property
    def dynamics_known(self) -> bool:
        """Return True if inertia/viscous is known within the factor KNOWN_DYNAMICS."""
        return math.isfinite(self.slowest) and self.slowest <= KNOWN_DYNAMICS * self.fastest

    def with_step(self, step: float) -> AssessmentInputs:
        """Return a copy of the inputs with the encoder step `step`, rad | m."""
        return replace(self, sensing=replace(self.sensing, step=step))

    def value(self, parameter: str) -> float:
        """Return the a-priori value of a parameter in SI units."""
        return {"breakaway": self.breakaway, "presliding": self.presliding}.get(parameter) or float(
            getattr(self.axis, parameter)
        )


@dataclass(frozen=True)
class AssessmentRequest:
    """Options of an assessment.

    Attributes
    ----------
    wanted : mapping of str to float
        Requested half width of each parameter, relative to the value of the parameter; 0.05 for a
        parameter that is not a key.
    duration : float
        Duration of the proposed sines, s.
    noise : float or None
        Standard deviation of the noise on the measured drive, A | V; None for 0.2 % of the drive's
        limit.
    effort : float or None
        Largest effort of the test, N m | N; None for the largest effort of the bench.
    presliding : float or None
        Expected presliding distance z_max, rad | m; None for 1e-3 rad or 1e-5 m.
    step : float or None
        Distance of a position step, rad | m, for which the shortest response time is computed; None
        for the travel.
    """

    wanted: Mapping[str, float] = field(default_factory=dict)
    duration: float = 30.0
    noise: float | None = None
    effort: float | None = None
    presliding: float | None = None
    step: float | None = None


def facts_of(bench: Bench, request: AssessmentRequest) -> AssessmentInputs:
    """Return the inputs of the assessment of a bench and a proposed test.

    Raises NoSolutionError if the drive does not overcome the friction, or if nothing limits the
    speed.
    """
    known = bench.mechanics
    limits = limits_of(bench)
    low, high = known.inertia.interval
    fastest, slowest = time_constants(bench)
    return AssessmentInputs(
        axis=axis_known(bench),
        sensing=sensing_of(bench, request.noise),
        speed=limits.speed,
        effort=request.effort or bench.actuator.constant.value * bench.actuator.limit.value,
        strokes=tuple(plan(limits, request.duration)),
        fastest=fastest,
        slowest=slowest,
        known=known_widths(bench),
        inertia=(low, known.inertia.value, high),
        breakaway=breakaway_range(bench)[1],
        rate=effort_rate(bench),
        onsets=2.0 * SEGMENTS,
        presliding=request.presliding or PRESLIDING[bench.axis],
    )


def time_constants(bench: Bench) -> tuple[float, float]:
    """Return the shortest and the longest a-priori time constant inertia/viscous, s."""
    low, high = bench.mechanics.inertia.interval
    least, most = bench.mechanics.viscous.interval
    return low / most if most > 0.0 else math.inf, high / least if least > 0.0 else math.inf


def known_widths(bench: Bench) -> dict[str, float]:
    """Return the relative half widths of the a-priori intervals, by the name of the parameter."""
    names = ("inertia", "viscous", "coulomb", "breakaway")
    return {
        name: width for name in names if (width := _width(getattr(bench.mechanics, name))) > 0.0
    }


def _width(quantity: Quantity | None) -> float:
    if quantity is None or quantity.value <= 0.0:
        return 0.0
    low, high = quantity.interval
    return 0.5 * (high - low) / quantity.value
