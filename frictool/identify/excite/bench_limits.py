"""Worst-case limits of a bench over its a-priori intervals: travel, speed and effort.

The effort is computed for the weakest actuator on the heaviest axis. Every axis within the
intervals can therefore follow a reference within these limits (thesis 4.2.3):

    inertia_high |a| + viscous_high |v| + coulomb_high + |offset| + load.most <= constant_low limit

a is the acceleration, v the velocity, constant the drive constant, and limit the drive's limit.
The suffixes _low and _high denote the ends of an a-priori interval.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictool.documents.bench import DRIVE_NOISE_SHARE, Bench
from frictool.documents.load_terms import OVER_POSITION
from frictool.documents.quantity import Axis, si_unit
from frictool.errors import NoSolutionError
from frictool.identify.excite.cramer_rao import DeclaredLoads, PriorAxis, SensorPrecision
from frictool.identify.rows.load_terms import HARMONICS, declared_terms, wave_number
from frictool.typing import Vector

MARGIN = 0.05  # share of the travel that a test does not use at either end
ROUNDING = 1e-9


@dataclass(frozen=True)
class BenchLimits:
    """Worst-case limits of a bench in SI units.

    - low, high: ends of the travel, reduced by a margin at either end; infinite if the bench
      declares no travel
    - speed: top speed
    - effort: effort of the weakest actuator at the drive's limit
    - inertia, viscous, coulomb, offset: largest a-priori values
    - drive, drive_limit: name of the drive signal, and its limit, A | V
    - load: largest effort of the declared loads over the travel
    """

    axis: Axis
    low: float
    high: float
    speed: float
    effort: float
    inertia: float
    viscous: float
    coulomb: float
    offset: float
    drive: str
    drive_limit: float
    load: float = 0.0

    @property
    def steady(self) -> float:
        """Return the sum of Coulomb friction, offset and load, N m | N."""
        return self.coulomb + self.offset + self.load

    @property
    def travel(self) -> float:
        """Return the usable travel, rad | m."""
        return self.high - self.low

    @property
    def unit(self) -> str:
        """Return the unit of the position."""
        return "rad" if self.axis == "rotary" else "m"

    def acceleration(self, speed: float) -> float:
        """Return the largest acceleration at `speed`, rad/s^2 | m/s^2.

        The result is 0 or negative if friction and load need all of the effort.
        """
        return (self.effort - self.viscous * speed - self.steady) / self.inertia


def limits_of(bench: Bench) -> BenchLimits:
    """Return the worst-case limits of a bench.

    Raises
    ------
    NoSolutionError
        If the drive does not overcome the friction, or if nothing limits the speed.
    """
    known, actuator = bench.mechanics, bench.actuator
    effort = actuator.constant.interval[0] * actuator.limit.value
    coulomb, viscous = known.coulomb.interval[1], known.viscous.interval[1]
    offset = max(map(abs, known.offset.interval)) if known.offset else 0.0
    load = known_load(bench)
    left = effort - coulomb - offset - load
    if left <= 0.0:
        also = " and load need" if load else " needs"
        unit = si_unit("effort", bench.axis)
        raise NoSolutionError(
            f"{bench.name}: friction{also} up to {coulomb + offset + load:.3g} {unit}; allowed: "
            f"below {effort:.3g}, the least effort at the drive's limit; raise "
            "actuator.limit, or narrow `mechanics`"
        )
    if known.top_speed is None and viscous <= 0.0:
        raise NoSolutionError(f"{bench.name}: no value limits the speed; state mechanics.top_speed")
    speed = known.top_speed.value if known.top_speed else left / viscous
    low, high = (known.travel.low, known.travel.high) if known.travel else (-math.inf, math.inf)
    margin = MARGIN * (high - low) if known.travel else 0.0
    inertia = known.inertia.interval[1]
    return BenchLimits(
        bench.axis,
        low + margin,
        high - margin,
        speed,
        effort,
        inertia,
        viscous,
        coulomb,
        offset,
        actuator.drive,
        actuator.limit.value,
        load,
    )


def known_load(bench: Bench) -> float:
    """Return the largest effort of the declared loads, N m | N; 0 if `load.most` is not stated."""
    return (
        max(bench.load.most.interval)
        if bench.load is not None and bench.load.most is not None
        else 0.0
    )


def missing_load_limit(bench: Bench) -> str | None:
    """Return a warning if the bench declares a load over position but no `load.most`, else None."""
    named = [term for term in OVER_POSITION if bench.load is not None and term in bench.load.terms]
    if not named or (bench.load is not None and bench.load.most is not None):
        return None
    names = ", ".join(named)
    return (
        f"load.terms contains {names}, but load.most is missing: no part of the "
        "drive's limit is reserved for this load"
    )


def axis_known(bench: Bench) -> PriorAxis:
    """Return an axis with the nominal inertia and friction of the bench, and its largest backlash.

    A friction of 0 is replaced by the upper end of its interval.
    """
    known = bench.mechanics
    backlash = max(known.backlash.interval) if known.backlash else 0.0
    viscous, coulomb = (one.value or one.interval[1] for one in (known.viscous, known.coulomb))
    middle = 0.5 * (known.travel.low + known.travel.high) if known.travel else 0.0
    return PriorAxis(known.inertia.value, viscous, coulomb, backlash, declared_loads(bench), middle)


def declared_loads(bench: Bench) -> DeclaredLoads:
    """Return the loads that the bench declares; the default is a constant offset of the effort."""
    if bench.load is None:
        return DeclaredLoads()
    terms = bench.load.terms
    waves = tuple(
        (term, wave_number(term, bench) if term in HARMONICS else 0.0)
        for term in declared_terms(bench)
    )
    return DeclaredLoads(
        "offset" in terms or "coulomb_by_direction" in terms, waves, terms == ("offset",)
    )


def sensing_of(bench: Bench, noise: float | None = None) -> SensorPrecision:
    """Return sample period, encoder step and effort noise of a bench.

    `noise` is the standard deviation of the noise on the measured drive, A | V; the default is
    0.2 % of the drive's limit.
    """
    drive = bench.actuator
    measured = DRIVE_NOISE_SHARE * drive.limit.value if noise is None else noise
    return SensorPrecision(
        bench.sample_period_s, bench.encoder.resolution, measured * drive.constant.value
    )


def check_reference(
    limits: BenchLimits, position: Vector, velocity: Vector, acceleration: Vector
) -> None:
    """Raise NoSolutionError if a reference (n,) exceeds a limit; the message names the limit."""
    unit = limits.unit
    drive = "A" if limits.drive == "current" else "V"
    rounding = ROUNDING * (abs(limits.low) + abs(limits.high))
    if position.min() < limits.low - rounding or position.max() > limits.high + rounding:
        raise NoSolutionError(
            f"travel: the test goes from {position.min():.4g} to {position.max():.4g} {unit}; "
            f"allowed ({100 * MARGIN:g} % inside either end): {limits.low:.4g} to "
            f"{limits.high:.4g}; lower the amplitude or raise the frequency"
        )
    fastest = float(np.abs(velocity).max())
    if fastest > limits.speed * (1.0 + ROUNDING):
        raise NoSolutionError(
            f"speed: the test reaches {fastest:.4g} {unit}/s; allowed: at most "
            f"{limits.speed:.4g} (mechanics.top_speed); lower the speed, the amplitude or the "
            "frequency"
        )
    inertial = limits.inertia * acceleration + limits.viscous * velocity
    needed = float(np.abs(inertial + np.sign(velocity) * limits.steady).max())
    if needed > limits.effort * (1.0 + ROUNDING):
        hardest = float(np.abs(acceleration).max())
        raise NoSolutionError(
            f"drive: the test needs {limits.drive_limit * needed / limits.effort:.3g} {drive} "
            f"on the heaviest axis at {hardest:.4g} {unit}/s^2; "
            f"allowed: at most {limits.drive_limit:.3g} (actuator.limit); lower the frequency "
            "or the speed"
        )
