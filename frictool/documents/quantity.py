"""Physical quantities at the edge of the program.

A quantity is written `{value: 50, unit: A}`, or with an interval `{value: 13.4, low: 12.8, high:
14.0, unit: mN m/A}`. Its unit is converted here, once: every `Quantity` in memory is in SI. Which
unit is SI depends on the dimension, and for mechanical dimensions on whether the axis is rotary (N
m, rad) or linear (N, m).
"""

from __future__ import annotations

import math
import sys
from functools import lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import msgspec

if TYPE_CHECKING:
    import pint

Axis = Literal["rotary", "linear"]

# dimension -> SI unit of a rotary axis, SI unit of a linear axis
SI_UNITS: dict[str, tuple[str, str]] = {
    "position": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "inertia": ("kg m^2", "kg"),
    "effort": ("N m", "N"),
    "viscous": ("N m s/rad", "N s/m"),
    "stiffness": ("N m/rad", "N/m"),
    "effort per ampere": ("N m/A", "N/A"),
    "effort per volt": ("N m/V", "N/V"),
    "current": ("A", "A"),
    "voltage": ("V", "V"),
    "time": ("s", "s"),
    # of a mechanism, whose blocks are of both kinds
    "rotary inertia": ("kg m^2", "kg m^2"),
    "mass": ("kg", "kg"),
    "angle": ("rad", "rad"),
    "length": ("m", "m"),
    "area": ("m^2", "m^2"),
}
# what is tried in turn where the unit tells what is meant: dimensions and kinds of axis
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

# log channels and the dimension of each
CHANNEL_DIMENSIONS: dict[str, str] = {
    "position": "position",
    "reference": "position",
    "velocity": "velocity",
    "current": "current",
    "current_command": "current",
    "voltage": "voltage",
    "effort": "effort",
}


class Quantity(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A value in SI with an optional interval that holds it; `unit` names the SI unit."""

    value: float
    low: float | None = None
    high: float | None = None
    unit: str = ""

    @property
    def interval(self) -> tuple[float, float]:
        """(low, high), both equal to the value where no interval is known."""
        return (
            self.value if self.low is None else self.low,
            self.value if self.high is None else self.high,
        )


class Estimate(Quantity, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """A parameter: `source` says whether a log gave it, or else the bench; `assumed` where neither
    did."""

    source: Literal["identified", "bench", "assumed"]


class Span(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A range in SI, low < high."""

    low: float
    high: float
    unit: str


class Series(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Values in SI, in the order given."""

    values: tuple[float, ...]
    unit: str


def _of(dimension: str, minimum: float | None = None, exclusive: bool = False) -> msgspec.Meta:
    return msgspec.Meta(extra={"dimension": dimension, "minimum": minimum, "exclusive": exclusive})


# the quantities that documents are made of: dimension and admissible range
Position = Annotated[Quantity, _of("position")]
PositiveLength = Annotated[Quantity, _of("position", 0.0, exclusive=True)]
NonNegativeLength = Annotated[Quantity, _of("position", 0.0)]
PositionSpan = Annotated[Span, _of("position")]
PositiveVelocity = Annotated[Quantity, _of("velocity", 0.0, exclusive=True)]
Time = Annotated[Quantity, _of("time")]
PositiveTime = Annotated[Quantity, _of("time", 0.0, exclusive=True)]
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
NonNegativeEffortEstimate = Annotated[Estimate, _of("effort", 0.0)]
AnyQuantity = Annotated[Quantity, _of("any")]


@lru_cache(maxsize=1)
def unit_registry() -> pint.UnitRegistry[float]:
    """The unit registry, built on first use: it takes about 0.1 s."""
    made: pint.UnitRegistry[float] = _pint().UnitRegistry()
    return made


def _pint() -> ModuleType:
    """pint, without dask, which it loads where that is installed, for arrays that nobody here has:
    half as long again, and jinja2."""
    hidden = "dask" not in sys.modules
    if hidden:
        sys.modules["dask"] = None  # type: ignore[assignment]  # what the import system takes for a module that is not there
    try:
        import pint
    finally:
        if hidden:
            del sys.modules["dask"]
    return pint


def si_unit(dimension: str, axis: Axis) -> str:
    """The SI unit of a dimension for this kind of axis.

    >>> si_unit("effort", "linear")
    'N'
    """
    return SI_UNITS[dimension][0 if axis == "rotary" else 1]


def drive_dimension(drive: Literal["current", "voltage"], *, constant: bool) -> str:
    """The dimension of what drives the actuator, or of the effort it gives per unit of it."""
    if constant:
        return "effort per ampere" if drive == "current" else "effort per volt"
    return drive


def chosen_dimension(unit: str, dimension: str) -> tuple[str, Axis]:
    """Of a dimension of CHOICES, the one that the unit measures and its kind of axis. Raises
    ValueError where it measures none."""
    for name, axis in CHOICES[dimension]:
        try:
            factor_to_si(unit, name, axis)
        except ValueError:
            continue
        return name, axis
    allowed = ", ".join(dict.fromkeys(si_unit(name, axis) for name, axis in CHOICES[dimension]))
    raise ValueError(f"unit {unit!r}; allowed: {allowed} and their multiples")


def factor_to_si(unit: str, dimension: str, axis: Axis) -> float:
    """What a number in `unit` is multiplied by to be in SI.

    Raises ValueError with a message for people where the unit is unknown, has an offset, or is of
    another dimension.
    """
    target = si_unit(dimension, axis)
    if unit == target:
        return 1.0
    units, errors = unit_registry(), _pint().errors
    try:
        factor = float(units.Quantity(1.0, _spelling(unit)).to(_spelling(target)).magnitude)
    except errors.DimensionalityError:
        raise ValueError(
            f"unit {unit!r} does not measure {_measured(dimension, axis)}; allowed: {target} and its multiples"
        ) from None
    except Exception:
        raise ValueError(
            f"unknown unit {unit!r}; for {_measured(dimension, axis)} write {target} or a multiple of it"
        ) from None
    if not math.isfinite(factor) or factor <= 0.0:
        raise ValueError(f"unit {unit!r} cannot be used as a scale; write {target}")
    return factor


def _measured(dimension: str, axis: Axis) -> str:
    """The dimension, with the kind of axis where its unit depends on that."""
    rotary, linear = SI_UNITS[dimension]
    return dimension if rotary == linear else f"{dimension} of a {axis} axis"


@lru_cache(maxsize=1024)  # trials ask again and again
def factor_between(unit: str, target: str) -> float:
    """What a number in `unit` is multiplied by to be in `target`, both as people write them; "" and
    "1" have no dimension.

    Raises ValueError with a message for people where the unit is unknown or of another dimension.
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
    """What a unit measures: powers of the registry's base dimensions. Raises ValueError where it is
    unknown."""
    try:
        return unit_registry().Quantity(1.0, _spelling(unit)).dimensionality
    except Exception:
        raise ValueError(f"unknown unit {unit!r}") from None


def _spelling(unit: str) -> str:
    """A unit as people write it, `N m s/rad` or `kg.m^2`, as the registry reads it."""
    out: list[str] = []
    for part in unit.replace("·", " ").replace("²", "^2").split("/"):
        words = part.replace("*", " ").split()
        out.append("*".join(words) if words else "1")
    return "/".join(f"({word})" if index else word for index, word in enumerate(out))
