"""Table of effects on real machines that disturb the fit of the sliding parameters.

    effort = inertia a + viscous v + coulomb s + offset + load(x) + effect

The columns of a declared effect (`load.terms`) are added to the regression, so that other
parameters do not absorb the effect. The model document contains the fitted effect of the measured
temperature, but no other effect. In the table, x is the position, v the velocity, a the
acceleration, s the direction of the motion, u the effort, t the time, and h the temperature minus
the reference temperature. P_k are Legendre polynomials over the log's time or the record's travel.
The mean of each P_k over the samples used is subtracted, so that the sliding parameters are means
over these samples.

    drift                   P_k(t), k = 1 to 4                  an offset that changes slowly
    warming                 s P_1, s P_2, v P_1, v P_2 of t     friction that changes along the log
    temperature             v h I(p), s h I(q h), v h^2 I(p)    friction over temperature
    eccentricity            (sin x)'', (cos x)'', (sin x)', (cos x)'    eccentric encoder
    stribeck                s exp(-(v / w)^2)                   w = 5, 10, 20 % of the top speed
    wide_stribeck           s exp(-(v / w)^2)                   w = 20, 40 % of the top speed
    friction_over_position  s P_k(x), k = 1 to 3                over the record's travel
    load_over_position      P_k(x), k = 1 to 3                  part of a long ripple
    inertial_friction       s |a|                               friction under the inertial load
    delay                   -du/dt                              late current, or current-loop lag
    resonance               a''                                 one elastic link, to first order

With I(p) = (e^p - 1)/p and p = r h + k h^2, the columns of `temperature` fit a viscous friction
proportional to e^p, and a Coulomb friction proportional to e^(q h); `temperature_shape.py`
estimates r, k and q. `eccentricity` is the first-order effect of a small e if the true position is
x + e sin(x + phase). `delay` and `resonance` are first terms of Taylor series: `delay` of a series
in the delay, `resonance` of a series in the square of the resonance's period.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander
from numpy.typing import NDArray

from frictool.documents.bench import Bench
from frictool.documents.load_terms import Term
from frictool.identify.fit_result import UnusableLogs
from frictool.identify.motion_record import MotionRecord
from frictool.typing import IntVector, Vector

DRIFT_ORDER, WARMING_ORDER, TRAVEL_ORDER = 4, 2, 3
WARMING: Term = "warming"
DELAY: Term = "delay"
TEMPERATURE: Term = "temperature"
# parameters of `temperature`: change of viscous and of Coulomb friction per kelvin, and change of
# viscous friction per square kelvin
TEMPERATURE_NAMES = ("viscous_temperature", "coulomb_temperature", "viscous_curvature")
# physical names of the loads and effects in all messages
WHAT: dict[Term, str] = {
    "spring": "a spring",
    "gravity": "gravity",
    "viscous_by_direction": "viscous friction by direction",
    "drift": "a drift of the offset",
    "warming": "friction that changes along the log",
    "temperature": "friction that changes with the measured temperature",
    "eccentricity": "an eccentric encoder",
    "stribeck": "friction that falls with speed",
    "wide_stribeck": "friction that still falls at high speed",
    "friction_over_position": "friction over position",
    "load_over_position": "a load over the position",
    "inertial_friction": "friction proportional to the inertial load",
    "delay": "a delay or lag between effort and position",
    "resonance": "a resonance",
}
# effects whose columns describe a fall of the friction with speed, if their effort is positive
FALLS: tuple[Term, ...] = ("stribeck", "wide_stribeck")
RISING = "friction that rises less than in proportion to speed"
RISING_SETTLE = "record a motion at the speeds of use only, which viscous and Coulomb friction fit"
# speeds w of the columns `stribeck` and `wide_stribeck`, relative to the top speed
SLOW_SHARES, WIDE_SHARES = ((0.05, 0.1, 0.2), (0.2, 0.4))


@dataclass(frozen=True)
class SmoothedMotion:
    """Smoothed signals (n,) of a record in SI units, with NaN at the ends of the record.

    - window: length of the smoothing window, samples
    - sign: direction of the stroke, +1, -1, or 0 without motion
    - used: True for the samples in the regression
    - every: True if columns are computed at all samples; False if only at the samples in the
      regression
    """

    record: MotionRecord
    window: int
    acceleration: Vector
    velocity: Vector
    effort: Vector
    sign: Vector
    used: NDArray[np.bool_]
    every: bool = False

    @cached_property
    def rows(self) -> IntVector:
        """Return the indices (m,) of the samples at which columns are computed."""
        return np.flatnonzero(self.used | self.every)

    def at_rows(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the `values` (n,) at the samples of the columns, (m,)."""
        return np.asarray(values[self.rows])

    def shapes(self, values: Vector, order: int) -> tuple[Vector, ...]:
        """Return Legendre polynomials (m,) of degree 1 to `order` in `values` (n,).

        The range of `values` is scaled to [-1, 1]. Over the samples used, each polynomial has the
        mean 0.
        """
        low = float(values.min())
        high = float(values.max())
        scaled = 2.0 * (self.at_rows(values) - low) / max(high - low, 1e-300) - 1.0
        columns = legvander(scaled, order)[:, 1:]
        if columns.size:
            used = self.at_rows(self.used) if self.used.any() else slice(None)
            columns = columns - np.mean(columns[used], axis=0)
        return tuple(columns.T)


@dataclass(frozen=True)
class Hypothesis:
    """Load or effect that may act in addition to inertia, viscous and Coulomb friction, and offset.

    - term: load term, as in `load_terms.TERMS`, or name in `load.terms` of the bench
    - names: parameters, one for each column of the regression
    - what: physical name, as text
    - settle: text with a test, or a change of bench.yaml, that shows whether the effect acts
    - is_load: True if the effect is a load in the model document
    - needs_position: True if the columns depend on the absolute position
    - differentiates: True if the columns are derivatives of the smoothed position
    - needs_temperature: True if the columns depend on the temperature. The model document then
      contains a law of the effect.
    - only_widens: True if the hypothesis widens intervals, but is not reported as an explanation of
      the effort, because more specific hypotheses explain the same effort
    - positive: True if a negative parameter is physically impossible
    """

    term: str
    names: tuple[str, ...]
    what: str
    settle: str
    is_load: bool = False
    needs_position: bool = False
    differentiates: bool = False
    needs_temperature: bool = False
    only_widens: bool = False
    positive: bool = False


@dataclass(frozen=True)
class Effect(Hypothesis):
    """Hypothesis of an effect that disturbs the fit.

    - columns: function of the smoothed motion that returns the columns, each (m,), in the order of
      `names`; the column of the last name may be missing
    """

    columns: Callable[[SmoothedMotion], tuple[Vector, ...]] = field(kw_only=True)


def _drift(motion: SmoothedMotion) -> tuple[Vector, ...]:
    return motion.shapes(motion.record.time, DRIFT_ORDER)


def _warming(motion: SmoothedMotion) -> tuple[Vector, ...]:
    shapes = motion.shapes(motion.record.time, WARMING_ORDER)
    sign, velocity = motion.at_rows(motion.sign), motion.at_rows(motion.velocity)
    return (*(sign * one for one in shapes), *(velocity * one for one in shapes))


def _temperature(motion: SmoothedMotion) -> tuple[Vector, ...]:
    """Return the columns for friction that changes with the temperature.

    At h kelvin above the reference temperature, a friction F becomes F exp(p) with p = r h + k h^2.
    r [1/K] is the relative change of F per kelvin at h = 0, and k [1/K^2] is the coefficient of h^2
    in p. With I = (exp(p) - 1)/p, this is F exp(p) = F + F r h I + F k h^2 I. The last two terms
    give the columns. The column of k is left out if the record has k = 0 (`viscous_curvature`).
    """
    warm = motion.record.temperature
    if warm is None:
        raise UnusableLogs(missing_temperature(motion.record))
    h, k = motion.at_rows(warm.excess), warm.viscous_curvature
    velocity = motion.at_rows(motion.velocity)
    viscous = h * _mean_exponential(warm.viscous_rate * h + k * h**2)
    columns = (
        velocity * viscous,
        motion.at_rows(motion.sign) * h * _mean_exponential(warm.coulomb_rate * h),
    )
    return columns if k == 0.0 else (*columns, velocity * h * viscous)


def _mean_exponential(exponent: Vector) -> Vector:
    safe = np.where(exponent == 0.0, 1.0, exponent)
    return np.where(exponent == 0.0, 1.0, np.expm1(safe) / safe)


def missing_temperature(record: MotionRecord) -> str:
    """Return the message for a record without the temperature that `load.terms` requires."""
    return (
        f"{Path(record.name).name} has no temperature, which load.terms of the bench requires; "
        "name its column under columns.temperature of the bench"
    )


def _eccentricity(motion: SmoothedMotion) -> tuple[Vector, ...]:
    x, v, a = map(motion.at_rows, (motion.record.position, motion.velocity, motion.acceleration))
    sine = np.sin(x)
    cosine = np.cos(x)
    return a * cosine - v**2 * sine, -a * sine - v**2 * cosine, v * cosine, -v * sine


def _falls(motion: SmoothedMotion, shares: tuple[float, ...]) -> tuple[Vector, ...]:
    top = float(np.nanmax(np.abs(motion.velocity), initial=0.0)) or 1.0
    sign, velocity = motion.at_rows(motion.sign), motion.at_rows(motion.velocity)
    return tuple(sign * np.exp(-((velocity / (share * top)) ** 2)) for share in shares)


def _stribeck(motion: SmoothedMotion) -> tuple[Vector, ...]:
    return _falls(motion, SLOW_SHARES)


def _wide_stribeck(motion: SmoothedMotion) -> tuple[Vector, ...]:
    return _falls(motion, WIDE_SHARES)


def _friction_over_position(motion: SmoothedMotion) -> tuple[Vector, ...]:
    shapes = motion.shapes(motion.record.position, TRAVEL_ORDER)
    return tuple(motion.at_rows(motion.sign) * one for one in shapes)


def _load_over_position(motion: SmoothedMotion) -> tuple[Vector, ...]:
    return motion.shapes(motion.record.position, TRAVEL_ORDER)


def _inertial_friction(motion: SmoothedMotion) -> tuple[Vector, ...]:
    return (motion.at_rows(motion.sign) * np.abs(motion.at_rows(motion.acceleration)),)


def _delay(motion: SmoothedMotion) -> tuple[Vector, ...]:
    return (-motion.at_rows(np.gradient(motion.effort)) / motion.record.period,)


def _resonance(motion: SmoothedMotion) -> tuple[Vector, ...]:
    """Return the second difference of the acceleration over a quarter of the window."""
    a = motion.acceleration
    step = max((motion.window - 1) // 4, 1)
    out = np.full(a.size, np.nan)
    if a.size > 2 * step:
        out[step:-step] = (a[2 * step :] - 2.0 * a[step:-step] + a[: -2 * step]) / (
            step * motion.record.period
        ) ** 2
    return (motion.at_rows(out),)


def _numbered(name: str, count: int) -> tuple[str, ...]:
    return tuple(f"{name}_{k}" for k in range(1, count + 1))


EFFECTS = (
    Effect(
        "drift",
        _numbered("drift", DRIFT_ORDER),
        WHAT["drift"],
        "record the current at rest before and after the test, or declare load.terms: [offset, "
        "drift]",
        columns=_drift,
    ),
    Effect(
        WARMING,
        (
            *_numbered("warming_coulomb", WARMING_ORDER),
            *_numbered("warming_viscous", WARMING_ORDER),
        ),
        WHAT[WARMING],
        "record after a warm-up of the same motion, log the temperature (columns.temperature), or "
        "declare load.terms: [offset, warming]",
        columns=_warming,
    ),
    Effect(
        TEMPERATURE,
        TEMPERATURE_NAMES,
        WHAT[TEMPERATURE],
        "record logs at other temperatures, too, or declare load.terms: [offset, temperature]",
        columns=_temperature,
        needs_temperature=True,
    ),
    Effect(
        "eccentricity",
        (
            *("eccentricity_inertia_sine", "eccentricity_inertia_cosine"),
            *("eccentricity_viscous_sine", "eccentricity_viscous_cosine"),
        ),
        WHAT["eccentricity"],
        "compare the encoder with a second encoder over a slow turn, or declare load.terms: "
        "[offset, eccentricity]",
        columns=_eccentricity,
        needs_position=True,
    ),
    Effect(
        "stribeck",
        _numbered("stribeck", len(SLOW_SHARES)),
        WHAT["stribeck"],
        "record runs at constant speeds, including slow speeds, for --method stribeck-curve, or "
        "declare load.terms: [offset, stribeck]",
        columns=_stribeck,
    ),
    Effect(
        "wide_stribeck",
        _numbered("wide_stribeck", len(WIDE_SHARES)),
        WHAT["wide_stribeck"],
        "record runs at constant speeds, including fast speeds, for --method stribeck-curve, or "
        "declare load.terms: [offset, wide_stribeck]",
        columns=_wide_stribeck,
        only_widens=True,
    ),
    Effect(
        "friction_over_position",
        _numbered("friction_over_position", TRAVEL_ORDER),
        WHAT["friction_over_position"],
        "record breakaway ramps over the travel, or declare load.terms: [offset, "
        "friction_over_position]",
        columns=_friction_over_position,
        needs_position=True,
    ),
    Effect(
        "load_over_position",
        _numbered("load_over_position", TRAVEL_ORDER),
        WHAT["load_over_position"],
        "record strokes over the whole travel, or declare load.terms: [offset, load_over_position]",
        columns=_load_over_position,
        needs_position=True,
        only_widens=True,
    ),
    Effect(
        "inertial_friction",
        ("inertial_friction",),
        WHAT["inertial_friction"],
        "repeat the motion with another load, or declare load.terms: [offset, inertial_friction]",
        columns=_inertial_friction,
        positive=True,
    ),
    Effect(
        "delay",
        ("delay",),
        WHAT["delay"],
        "correct the time stamps, record a current step for --measurement, state the lag in "
        "actuator.loop_time_constant_s or encoder.time_constant_s, or declare load.terms: "
        "[offset, delay]",
        columns=_delay,
    ),
    Effect(
        "resonance",
        ("resonance",),
        WHAT["resonance"],
        "record a chirp to higher frequencies, or declare load.terms: [offset, resonance]",
        columns=_resonance,
        differentiates=True,
    ),
)


def declared_effects(bench: Bench) -> tuple[Effect, ...]:
    """Return the disturbing effects that the bench declares in `load.terms`."""
    named = () if bench.load is None else bench.load.terms
    return tuple(effect for effect in EFFECTS if effect.term in named)


def effect_names() -> frozenset[str]:
    """Return the names of the parameters of all effects."""
    return frozenset(name for effect in EFFECTS for name in effect.names)
