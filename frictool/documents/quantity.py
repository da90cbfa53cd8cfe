"""Physical quantities with units, converted to SI when a document is read.

A quantity is written `{value: 50, unit: A}`, or with an interval `{value: 13.4, low: 12.8, high:
14.0, unit: mN m/A}`. Every `Quantity` in memory is in SI. The SI unit depends on the dimension, and
for mechanical dimensions on the axis: rotary (N m, rad) or linear (N, m).
"""

from __future__ import annotations

import math
import re
import sys
from functools import lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, TypeVar, get_args

import msgspec

if TYPE_CHECKING:
    import pint

    from frictool.typing import Vector

Axis = Literal["rotary", "linear"]
FROM_LOGS = (
    "identified",
    "log and bench",
)  # sources of estimates that the logs determine or narrow
Number = TypeVar("Number", float, "Vector")

# dimension -> SI unit of a rotary axis, SI unit of a linear axis
SI_UNITS: dict[str, tuple[str, str]] = {
    "position": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "acceleration": ("rad/s^2", "m/s^2"),
    "jerk": ("rad/s^3", "m/s^3"),
    "inertia": ("kg m^2", "kg"),
    "effort": ("N m", "N"),
    "viscous": ("N m s/rad", "N s/m"),
    "stiffness": ("N m/rad", "N/m"),
    "effort per ampere": ("N m/A", "N/A"),
    "effort per volt": ("N m/V", "N/V"),
    "current": ("A", "A"),
    "voltage": ("V", "V"),
    "time": ("s", "s"),
    "resistance": ("ohm", "ohm"),
    "inductance": ("H", "H"),
    "temperature": ("degC", "degC"),
    "change per kelvin": ("1/K", "1/K"),
    "change per square kelvin": ("1/K^2", "1/K^2"),
    "number": ("1", "1"),
    "voltage per speed": ("V s/rad", "V s/m"),
    # dimensions of a mechanism, whose blocks can be rotary or linear
    "rotary inertia": ("kg m^2", "kg m^2"),
    "mass": ("kg", "kg"),
    "angle": ("rad", "rad"),
    "length": ("m", "m"),
    "area": ("m^2", "m^2"),
}
# symbol -> powers of kg, m, s, A and K
POWERS = {
    "kg": (1, 0, 0, 0, 0),
    "m": (0, 1, 0, 0, 0),
    "s": (0, 0, 1, 0, 0),
    "A": (0, 0, 0, 1, 0),
    "K": (0, 0, 0, 0, 1),
    "degC": (0, 0, 0, 0, 1),
    "rad": (0, 0, 0, 0, 0),
    "N": (1, 1, -2, 0, 0),
    "V": (1, 2, -3, -1, 0),
    "ohm": (1, 2, -3, -2, 0),
    "H": (1, 2, -2, -2, 0),
    "1": (0, 0, 0, 0, 0),
}
POWER = re.compile(r"([A-Za-z]+|1)(?:\^([0-9]))?")
# units of an angular motion must name an angle: 1/s could count turns or radians
ANGLE_NAME = re.compile(r"rad|deg|°|arc|rev|rpm|rps|turn|cycle|circle|gon", re.IGNORECASE)
# Grad is a degree in German, but a giga-radian or a gradian in pint; no angle is in mega-radians
AMBIGUOUS_ANGLE = re.compile(r"\b(?:[Gg]rads?|GRAD|[MTPEZY]rad)\b")
OTHER_UNITS = {"temperature": ", K or degF"}  # if the SI unit has no multiples: other units
# dimensions and kinds of axis, which are tried one after the other if the unit decides
CHOICES: dict[str, tuple[tuple[str, Axis], ...]] = {
    **{
        f"{name} of either axis": ((name, "rotary"), (name, "linear"))
        for name in ("position", "velocity", "stiffness", "viscous", "effort")
    },
    "constant of either axis": tuple(
        (f"effort per {drive}", axis) for drive in ("ampere", "volt") for axis in get_args(Axis)
    ),
    "any drive": (
        ("current", "rotary"),
        ("voltage", "rotary"),
        ("effort", "rotary"),
        ("effort", "linear"),
    ),
    "any mechanical": (("position", "rotary"), ("effort", "rotary"), ("effort", "linear")),
}

# dimension of each log channel
CHANNEL_DIMENSIONS: dict[str, str] = {
    "position": "position",
    "reference": "position",
    "velocity": "velocity",
    "current": "current",
    "current_command": "current",
    "voltage": "voltage",
    "effort": "effort",
    "temperature": "temperature",
    "gain": "number",
    "supply": "voltage",
    "torque_enabled": "number",
    "pendulum_mass": "mass",
    "pendulum_length": "length",
}

# channels of a servo's log, which no name or unit of a column shows reliably
SERVO_CHANNELS = ("gain", "supply", "torque_enabled", "pendulum_mass", "pendulum_length")


class Quantity(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Value in SI with an optional interval that contains it; `unit` is the SI unit.

    - `value`: Number in `unit`.
    - `low`, `high`: Ends of the interval that contains the value. Without these keys, the value is
      exact.
    - `unit`: Unit of `value`, `low` and `high`. A document may use any multiple of the SI unit.
    """

    value: float
    low: float | None = None
    high: float | None = None
    unit: str = ""

    @property
    def interval(self) -> tuple[float, float]:
        """Return (low, high), both equal to the value if no interval is known."""
        return (
            self.value if self.low is None else self.low,
            self.value if self.high is None else self.high,
        )


class Estimate(Quantity, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """Parameter with its source: identified from a log, taken from the bench, or assumed.

    - `value`: Number in `unit`.
    - `low`, `high`: Ends of the interval; if `source` is `identified`, a confidence interval.
    - `unit`: Unit of `value`, `low` and `high`. A document may use any multiple of the SI unit.
    - `source`: `identified`: the logs determine the value. `log and bench`: the interval from the
      logs is too wide to be used alone; `low` and `high` are the ends of its intersection with the
      range in bench.yaml. `bench`: the logs do not narrow the range in bench.yaml, and the bench's
      value and range are used. `assumed`: neither logs nor bench contain a value, and a default is
      used.
    """

    source: Literal["identified", "log and bench", "bench", "assumed"]


class Span(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Range in SI with low < high.

    - `unit`: Unit of both ends.
    """

    low: float
    high: float
    unit: str


class Series(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Values in SI, in the order of the document.

    - `values`: Numbers in `unit`.
    - `unit`: Unit of all values.
    """

    values: tuple[float, ...]
    unit: str


def _of(dimension: str, minimum: float | None = None, exclusive: bool = False) -> msgspec.Meta:
    return msgspec.Meta(extra={"dimension": dimension, "minimum": minimum, "exclusive": exclusive})


# quantities of the documents: dimension and admissible range
Position = Annotated[Quantity, _of("position")]
PositiveLength = Annotated[Quantity, _of("position", 0.0, exclusive=True)]
NonNegativeLength = Annotated[Quantity, _of("position", 0.0)]
PositionSpan = Annotated[Span, _of("position")]
PositiveVelocity = Annotated[Quantity, _of("velocity", 0.0, exclusive=True)]
PositiveAcceleration = Annotated[Quantity, _of("acceleration", 0.0, exclusive=True)]
PositiveJerk = Annotated[Quantity, _of("jerk", 0.0, exclusive=True)]
Time = Annotated[Quantity, _of("time")]
PositiveTime = Annotated[Quantity, _of("time", 0.0, exclusive=True)]
NonNegativeTime = Annotated[Quantity, _of("time", 0.0)]
NonNegativeMass = Annotated[Quantity, _of("mass", 0.0)]
ArmLength = Annotated[Quantity, _of("length", 0.0, exclusive=True)]
BackEmf = Annotated[Quantity, _of("voltage per speed", 0.0, exclusive=True)]
Inertia = Annotated[Quantity, _of("inertia", 0.0, exclusive=True)]
Effort = Annotated[Quantity, _of("effort")]
NonNegativeEffort = Annotated[Quantity, _of("effort", 0.0)]
PositiveEffort = Annotated[Quantity, _of("effort", 0.0, exclusive=True)]
Stiffness = Annotated[Quantity, _of("stiffness", 0.0, exclusive=True)]
Viscous = Annotated[Quantity, _of("viscous", 0.0)]
ViscousGain = Annotated[Quantity, _of("viscous", 0.0, exclusive=True)]
DriveConstant = Annotated[Quantity, _of("effort per drive", 0.0, exclusive=True)]
DriveLimit = Annotated[Quantity, _of("drive", 0.0, exclusive=True)]
InertiaEstimate = Annotated[Estimate, _of("inertia", 0.0, exclusive=True)]
ViscousEstimate = Annotated[Estimate, _of("viscous", 0.0)]
EffortEstimate = Annotated[Estimate, _of("effort")]
StiffnessEstimate = Annotated[Estimate, _of("stiffness")]
PositiveLengthEstimate = Annotated[Estimate, _of("position", 0.0, exclusive=True)]
PositiveVelocityEstimate = Annotated[Estimate, _of("velocity", 0.0, exclusive=True)]
NonNegativeLengthEstimate = Annotated[Estimate, _of("position", 0.0)]
TimeEstimate = Annotated[Estimate, _of("time")]
NonNegativeTimeEstimate = Annotated[Estimate, _of("time", 0.0)]
PositiveResistanceEstimate = Annotated[Estimate, _of("resistance", 0.0, exclusive=True)]
PositiveInductanceEstimate = Annotated[Estimate, _of("inductance", 0.0, exclusive=True)]
Temperature = Annotated[Quantity, _of("temperature")]
TemperatureSpan = Annotated[Span, _of("temperature")]
ChangePerKelvin = Annotated[Estimate, _of("change per kelvin")]
ChangePerSquareKelvin = Annotated[Estimate, _of("change per square kelvin")]
PositiveConstantEstimate = Annotated[Estimate, _of("effort per ampere", 0.0, exclusive=True)]
NonNegativeEffortEstimate = Annotated[Estimate, _of("effort", 0.0)]
AnyQuantity = Annotated[Quantity, _of("any")]


def positive(dimension: str) -> Any:
    """Return the type of a positive quantity; `dimension` is "drive" or a key of SI_UNITS.

    Raises ValueError for another dimension.
    """
    if dimension not in {"drive", *SI_UNITS}:
        raise ValueError(f"dimension {dimension!r}; allowed: drive, {', '.join(SI_UNITS)}")
    return Annotated[Quantity, _of(dimension, 0.0, exclusive=True)]


@lru_cache(maxsize=1)
def unit_registry() -> pint.UnitRegistry[float]:
    """Return pint's registry of units."""
    made: pint.UnitRegistry[float] = _pint().UnitRegistry()
    made.define("@alias turn = rev")
    return made


def _pint() -> ModuleType:
    """Return pint, imported without dask.

    If dask is installed, pint imports dask. This import is slow, and frictool uses no dask arrays.
    """
    hidden = "dask" not in sys.modules
    if hidden:
        sys.modules["dask"] = None  # type: ignore[assignment]  # the import system then reports a missing module
    try:
        import pint
    finally:
        if hidden:
            del sys.modules["dask"]
    return pint


def si_unit(dimension: str, axis: Axis) -> str:
    """Return the SI unit of a dimension for this kind of axis.

    >>> si_unit("effort", "linear")
    'N'
    """
    return SI_UNITS[dimension][0 if axis == "rotary" else 1]


def drive_dimension(drive: Literal["current", "voltage"], *, constant: bool) -> str:
    """Return the dimension of the drive, or the dimension of the effort per unit of the drive.

    constant: True for the effort per unit of the drive.
    """
    if constant:
        return "effort per ampere" if drive == "current" else "effort per volt"
    return drive


def chosen_dimension(unit: str, dimension: str) -> tuple[str, Axis]:
    """Return the dimension among CHOICES[dimension] that a unit measures, and the kind of axis.

    Raises ValueError if the unit measures none of them.
    """
    for name, axis in CHOICES[dimension]:
        try:
            factor_to_si(unit, name, axis)
        except ValueError:
            continue
        return name, axis
    allowed = ", ".join(dict.fromkeys(si_unit(name, axis) for name, axis in CHOICES[dimension]))
    raise ValueError(f"unit {unit!r}; allowed: {allowed} and their multiples")


class UnitScale(NamedTuple):
    """Conversion of a number from a unit to SI: SI value = factor * number + zero."""

    factor: float
    zero: float = 0.0

    def si(self, number: Number) -> Number:
        """Convert a number or an array of numbers to SI."""
        return self.factor * number + self.zero


def factor_to_si(unit: str, dimension: str, axis: Axis) -> float:
    """Return the factor that converts a number in `unit` to SI.

    Raises ValueError if the unit is unknown, has an offset, or is of another dimension. The message
    is meant for users.
    """
    scale = unit_scale(unit, dimension, axis)
    if scale.zero != 0.0:
        wanted = si_unit(dimension, axis)
        raise ValueError(f"unit {unit!r} has another zero point than {wanted}; write {wanted}")
    return scale.factor


def unit_scale(unit: str, dimension: str, axis: Axis) -> UnitScale:
    """Return the conversion of numbers in `unit` to SI.

    Only units of temperature have an offset. Raises ValueError if the unit is unknown or of another
    dimension, or if the unit of an angular motion contains no angle. The message is meant for
    users.
    """
    target = si_unit(dimension, axis)
    if unit == target:
        return UnitScale(1.0)
    others = OTHER_UNITS.get(dimension)
    refusal = (
        f"unit {unit!r} does not measure {_measured(dimension, axis)}; allowed: "
        f"{target}{others or ' and its multiples'}"
    )
    if target.startswith("rad") and AMBIGUOUS_ANGLE.search(unit):
        raise ValueError(
            f"unit {unit!r} may mean degrees, gradians or a multiple of rad; write deg, gon or rad "
            "for the angle"
        )
    powers = _powers(unit)
    if powers is not None and powers != _powers(target):
        raise ValueError(refusal)
    units = unit_registry()
    errors = _pint().errors
    try:
        zero, one = (
            float(units.Quantity(number, _spelling(unit)).to(_spelling(target)).magnitude)
            for number in (0.0, 1.0)
        )
    except errors.DimensionalityError:
        raise ValueError(refusal) from None
    except Exception:
        raise ValueError(
            f"unknown unit {unit!r}; for {_measured(dimension, axis)} write {target}"
            f"{others or ' or a multiple of it'}"
        ) from None
    if target.startswith("rad") and not ANGLE_NAME.search(unit):
        raise ValueError(
            f"unit {unit!r} names no angle, and may mean turns or radians; write "
            f"unit: {target.replace('rad', 'rev')} for turns, or unit: {target}"
        )
    if not math.isfinite(one) or one <= zero:
        raise ValueError(f"unit {unit!r} has no positive finite factor to {target}; write {target}")
    return UnitScale(one - zero, zero)


def _powers(unit: str) -> tuple[int, ...] | None:
    """Return the powers of kg, m, s, A and K in a unit; None if a symbol is not in `POWERS`.

    Such a unit needs pint, whose import takes several times longer than the import of numpy.
    """
    total = [0] * len(POWERS["1"])
    for index, part in enumerate(unit.split("/")):
        for word in part.split():
            match = POWER.fullmatch(word)
            if match is None or match[1] not in POWERS:
                return None
            sign = -1 if index else 1
            for at, power in enumerate(POWERS[match[1]]):
                total[at] += sign * power * int(match[2] or 1)
    return tuple(total)


def _measured(dimension: str, axis: Axis) -> str:
    rotary, linear = SI_UNITS[dimension]
    return dimension if rotary == linear else f"{dimension} of a {axis} axis"


@lru_cache(maxsize=1024)  # campaign trials repeat the same units
def factor_between(unit: str, target: str) -> float:
    """Return the factor that converts a number in `unit` to `target`.

    The units "" and "1" stand for a number without dimension.

    Raises ValueError if the unit is unknown or of another dimension. The message is meant for
    users.
    """
    if unit == target:
        return 1.0
    try:
        factor = float(
            unit_registry().Quantity(1.0, _spelling(unit)).to(_spelling(target)).magnitude
        )
    except Exception:
        factor = math.nan
    if not math.isfinite(factor) or factor <= 0.0:
        raise ValueError(f"unit {unit!r}; allowed: {target or '1'} and its multiples")
    return factor


def dimension_of(unit: str) -> Any:
    """Return the dimension of a unit, as powers of the registry's base dimensions.

    Raises ValueError if the unit is unknown.
    """
    try:
        return unit_registry().Quantity(1.0, _spelling(unit)).dimensionality
    except Exception:
        raise ValueError(f"unknown unit {unit!r}") from None


def _spelling(unit: str) -> str:
    out: list[str] = []
    for part in unit.replace("·", " ").replace("²", "^2").split("/"):
        words = part.replace("*", " ").split()
        out.append("*".join(words) if words else "1")
    return "/".join(f"({word})" if index else word for index, word in enumerate(out))
