"""What the decision starts from: delta_x, T_s, v_max, u_max, a-priori values and the test that is
proposed, for any step of the encoder."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from frictool.documents.bench import Bench
from frictool.documents.quantity import Quantity
from frictool.identify.excite.bench_limits import axis_known, limits_of, sensing_of
from frictool.identify.excite.breakaway import SEGMENTS, breakaway_range, effort_rate
from frictool.identify.excite.cramer_rao import PlannedStroke, PriorAxis, SensorPrecision
from frictool.identify.excite.sines import plan

# the a-priori time constant inertia/viscous has to be known to this factor for a filter to be tuned
# by it
KNOWN_DYNAMICS = 10.0
PRESLIDING = {"linear": 1e-5, "rotary": 1e-3}  # m, of table 3.1; rad, the same at a radius of 10 mm


@dataclass(frozen=True)
class AssessmentInputs:
    """SI. axis: its a-priori values; sensing: period, step, noise of the effort. speed, effort: the
    largest.

    strokes: the sines proposed. fastest, slowest: a-priori time constants inertia/viscous, s.
    known: parameter -> half width of the a-priori interval over its value, for those that have one.
    Of a test that is yet to come besides: breakaway, rate: expected, and of the ramps [N m/s |
    N/s]; presliding: distance z_max expected, rad | m.
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
        return math.isfinite(self.slowest) and self.slowest <= KNOWN_DYNAMICS * self.fastest

    def with_step(self, step: float) -> AssessmentInputs:
        """The same bench with another encoder."""
        return replace(self, sensing=replace(self.sensing, step=step))

    def value(self, parameter: str) -> float:
        """A-priori, SI."""
        return {"breakaway": self.breakaway, "presliding": self.presliding}.get(parameter) or float(
            getattr(self.axis, parameter)
        )


def facts_of(
    bench: Bench,
    duration: float,
    noise: float | None,
    effort: float | None,
    presliding: float | None,
) -> AssessmentInputs:
    """duration [s] of the sines; noise [A | V]; effort [N m | N] and presliding [rad | m] where the
    bench's own are not meant.

    Raises NoSolutionError where the drive does not overcome the friction.
    """
    known, limits = bench.mechanics, limits_of(bench)
    low, high = known.inertia.interval
    fastest, slowest = time_constants(bench)
    return AssessmentInputs(
        axis=axis_known(bench),
        sensing=sensing_of(bench, noise),
        speed=limits.speed,
        effort=effort or bench.actuator.constant.value * bench.actuator.limit.value,
        strokes=tuple(plan(limits, duration)),
        fastest=fastest,
        slowest=slowest,
        known=known_widths(bench),
        inertia=(low, known.inertia.value, high),
        breakaway=breakaway_range(bench)[1],
        rate=effort_rate(bench),
        onsets=2.0 * SEGMENTS,
        presliding=presliding or PRESLIDING[bench.axis],
    )


def time_constants(bench: Bench) -> tuple[float, float]:
    """The shortest and the longest a-priori inertia/viscous, s."""
    low, high = bench.mechanics.inertia.interval
    least, most = bench.mechanics.viscous.interval
    return low / most if most > 0.0 else math.inf, high / least if least > 0.0 else math.inf


def known_widths(bench: Bench) -> dict[str, float]:
    """Parameter -> half width of its a-priori interval over its value, for those that have one."""
    names = ("inertia", "viscous", "coulomb", "breakaway")
    return {
        name: width for name in names if (width := _width(getattr(bench.mechanics, name))) > 0.0
    }


def _width(quantity: Quantity | None) -> float:
    """Half width of the interval over the value; 0 where there is none."""
    if quantity is None or quantity.value <= 0.0:
        return 0.0
    low, high = quantity.interval
    return 0.5 * (high - low) / quantity.value
