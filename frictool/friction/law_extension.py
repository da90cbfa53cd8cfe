"""Extension of a friction law by direction, position, time at rest, speed ranges and a film.

    F_c(x, direction)    = F_c(direction) position factor(x, direction)      thesis (4.41)-(4.44)
    F_s(x, direction, t) = F_s(direction) position factor(x, direction) dwell factor(t)
    F                    = F_law(film velocity) + sigma_v (v - film velocity) + knee force(v)

F_c is the Coulomb friction, F_s the breakaway (section 3.4.2.3 of the thesis), x the position, t
the time at rest, v the velocity, and sigma_v the viscous coefficient. The kernels of the law are
not changed: before each call, the present F_c and F_s are written to the parameter array p. The
knee force is an additional viscous friction above certain speeds (friction/speed_regimes.py). The
film between the surfaces has a separate velocity (friction/lubricant_film.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from frictool.friction.law import DynamicKernels, Law
from frictool.friction.parameter import Axis
from frictool.friction.polynomial_minimum import minimum
from frictool.friction.position_kernels import position_factor
from frictool.friction.rising_breakaway import dwell_factor
from frictool.friction.speed_regimes import regimes_from
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

CONSTANT: tuple[float, ...] = (1.0,)

# indices in the table; the coefficients of both polynomials and the (knee, slope) pairs follow
BREAKAWAY_INDEX, VISCOUS_INDEX, FRESH, RISE_TIME, LOW, HIGH, LAG, BOUNDARY, DELAY = range(9)
BACKWARD_START, KNEES_START, COEFFICIENTS = range(9, 12)


class PackedExtension(NamedTuple):
    """Arrays of a law's extension for the kernels.

    `forward` and `backward` are the parameter arrays p of the law for each direction. `table` (n,)
    holds the values of the extension at the indices BREAKAWAY_INDEX to COEFFICIENTS of this module,
    and is empty without an extension.
    """

    forward: Vector
    backward: Vector
    table: Vector


@dataclass(frozen=True)
class FrictionExtension:
    """Parameters of an extension in SI; the default values leave the law unchanged.

    - backward_values: values of the law's parameters that differ for the negative direction
    - forward, backward: coefficients of the position factor of each direction
      (`position_polynomial.normalised_coefficients`)
    - travel: range (low, high) of positions for which the factors are valid, m | rad
    - fresh: breakaway just after a stop divided by the breakaway after a long rest, in (0, 1]
    - rise_time: rise time tau of the breakaway (friction/rising_breakaway.py), s
    - regimes: pairs (knee speed, additional viscous coefficient) of friction/speed_regimes.py
    - lag, delay: time constant and pure delay of the film velocity, s
    - boundary: speed below which no film forms, m/s | rad/s
    """

    backward_values: Mapping[str, float] = field(default_factory=dict)
    forward: tuple[float, ...] = CONSTANT
    backward: tuple[float, ...] = CONSTANT
    travel: tuple[float, float] = (0.0, 1.0)
    fresh: float = 1.0
    rise_time: float = 0.0
    regimes: tuple[tuple[float, float], ...] = ()
    lag: float = 0.0
    delay: float = 0.0
    boundary: float = 0.0

    @property
    def plain(self) -> bool:
        """Return True if the extension leaves the law unchanged."""
        return self == NO_EXTENSION

    def pack(self, law: Law, p: Vector, axis: Axis = "linear") -> PackedExtension:
        """Return the arrays for the kernels; p is the result of `law.pack(...)`.

        Raises ValueError if a value is out of range, or if the law does not support a part of the
        extension.
        """
        self._check_numbers()
        self._check_law(law)
        names = [parameter.name for parameter in law.parameters]
        index, viscous, stiffness = (
            names.index(name) if name in names else -1
            for name in ("breakaway", "viscous", "stiffness")
        )
        backward = law.changed(p, self.backward_values, axis)
        for levels_of in (p, backward):
            if index >= 0 and self.rise_time > 0.0 and self.fresh * levels_of[index] < levels_of[0]:
                low = self.fresh * levels_of[index]
                raise ValueError(
                    f"fresh is {self.fresh:g}: the breakaway just after a stop is {low:g}; "
                    f"allowed: >= coulomb, {levels_of[0]:g}"
                )
            if "elastic_limit" in names:
                self._check_elastic_limit(
                    p[names.index("elastic_limit")], levels_of[index] / p[stiffness]
                )
        split = COEFFICIENTS + len(self.forward)
        head = [
            index,
            viscous,
            self.fresh,
            self.rise_time,
            *self.travel,
            self.lag,
            self.boundary,
            self.delay,
        ]
        head += [split, split + len(self.backward)]
        table = np.concatenate(
            [head, self.forward, self.backward, regimes_from(list(self.regimes))]
        )
        return PackedExtension(np.array(p, dtype=np.float64), backward, table)

    def _check_elastic_limit(self, elastic: float, yielded: float) -> None:
        """Raise ValueError if the presliding limit falls below z_ba, the elastic limit.

        The state of thesis (2.46) would then switch between elastic and plastic without end.
        """
        smallest = yielded * min(
            minimum(self.forward, *self.travel)[1], minimum(self.backward, *self.travel)[1]
        )
        if elastic >= smallest:
            raise ValueError(
                f"elastic_limit is {elastic:g}; allowed: below {smallest:g}, the smallest "
                "breakaway within the travel, divided by the stiffness"
            )

    def _check_numbers(self) -> None:
        low, high = self.travel
        if not np.all(np.isfinite([low, high])) or low >= high:
            raise ValueError(
                f"travel of the position factors: found [{low:g}, {high:g}]; allowed: finite "
                "limits with low < high"
            )
        for name, coefficients in (("forward", self.forward), ("backward", self.backward)):
            if not coefficients or not np.all(np.isfinite(coefficients)):
                raise ValueError(
                    f"{name} position factor: found coefficients {[*coefficients]}; allowed: at "
                    "least one, all finite"
                )
            smallest = minimum(coefficients, low, high)[1]
            if smallest <= 0.0:
                raise ValueError(
                    f"the {name} position factor falls to {smallest:g} within the travel; "
                    "allowed: > 0 everywhere"
                )
        if not 0.0 < self.fresh <= 1.0 or not (
            math.isfinite(self.rise_time) and self.rise_time >= 0.0
        ):
            raise ValueError(
                f"fresh is {self.fresh:g}, rise_time {self.rise_time:g} s; allowed: fresh in "
                "(0, 1], rise_time >= 0"
            )
        film = {"lag": self.lag, "delay": self.delay, "boundary": self.boundary}
        for name, value in film.items():
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} is {value:g}; allowed: a finite number >= 0")
        if self.lag > 0.0 and self.delay > 0.0:
            raise ValueError(
                f"film: lag {self.lag:g} s and delay {self.delay:g} s are above 0; "
                "allowed: one of the two, not both"
            )

    def _check_law(self, law: Law) -> None:
        names = {parameter.name for parameter in law.parameters}
        dynamic = isinstance(law.kernels, DynamicKernels)
        stores = dynamic and "presliding_limit" in names
        by_direction = bool(self.backward_values) or self.forward != self.backward
        if self.rise_time > 0.0 and (dynamic or "breakaway" not in names):
            reason = "never rests" if dynamic else "has no breakaway"
            raise ValueError(
                f"{law.name} {reason}; allowed: rise_time 0 (no rise of the breakaway at rest)"
            )
        if stores and by_direction:
            raise ValueError(
                f"{law.name} stores energy in its contacts: friction that differs by direction "
                "would release more energy than was stored; use equal friction in both directions"
            )
        if (self.lag > 0.0 or self.delay > 0.0 or self.boundary > 0.0) and (
            dynamic or law.approximation
        ):
            raise ValueError(
                f"{law.name} does not support a lubricant film; allowed: a hybrid law, or a static "
                "law that can stick"
            )


NO_EXTENSION = FrictionExtension()


@kernel
def levels(
    forward: Vector,
    backward: Vector,
    table: Vector,
    x: float,
    direction: float,
    dwell: float,
    out: Vector,
) -> float:
    """Write to `out` the law's parameters at position x [m | rad] after `dwell` [s] at rest.

    `forward`, `backward`, `table`: arrays of a PackedExtension. Returns the factor of the
    breakaway: the product of the factors of the position and of the time at rest.
    """
    first = COEFFICIENTS
    second = int(table[BACKWARD_START])
    last = int(table[KNEES_START])
    out[:] = forward if direction > 0.0 else backward
    coefficients = table[first:second] if direction > 0.0 else table[second:last]
    factor = position_factor(coefficients, table[LOW], table[HIGH], x)
    rested: float = factor * dwell_factor(dwell, table[FRESH], table[RISE_TIME])
    out[0] *= factor
    index = int(table[BREAKAWAY_INDEX])
    if index >= 0:
        out[index] *= rested
    return rested


def pack_plain_law(p: Vector) -> PackedExtension:
    """Return the arrays of a law without an extension."""
    return PackedExtension(p, p, np.zeros(0))


@kernel
def regime_table(table: Vector) -> Vector:
    """Return the array `regimes` of friction/speed_regimes.py from an extension's table."""
    regimes: Vector = table[int(table[KNEES_START]) :]
    return regimes
