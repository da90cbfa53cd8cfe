"""Friction laws: the parameters of a law and the kernels that a driver runs.

A driver is compiled code that integrates the motion of a body with friction.

    kind     state                     work of the driver
    static   none                      slips in a fixed direction, sticks up to the breakaway
    dynamic  z and a memory            integrates `rate`; calls `commit` after each accepted step
    hybrid   mode, z and a memory      as dynamic; also calls `mode_after` at each step and `enter`
                                       at each switch

All kernels of a kind have the same signature (friction/kernel_signatures.py), so that a compiled
driver takes them as arguments. The parameter array p contains the parameters in the order of
`parameters`. In some laws a tail follows: the elements of a Maxwell bank or an Everett table, in
units of the breakaway and the presliding limit. p[0] is the Coulomb force in every law; p[1] is the
breakaway in every law with a separate breakaway.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from frictool.friction.parameter import Axis, LawParameter, Values
from frictool.typing import Vector

Kernel = Callable[..., Any]
# coulomb sign(v), (breakaway - coulomb) exp(-|v/v_s|^delta) sign(v), viscous v
SlipTerm = Literal["coulomb", "stribeck", "viscous"]


def curved_slip(p: Vector) -> tuple[float, float]:
    """Return (inf, 1), the `slip_scales` of a law whose slip force is nonlinear at all speeds."""
    return math.inf, 1.0


def straight_slip(p: Vector) -> tuple[float, float]:
    """Return (0, 1), the `slip_scales` of a law whose slip force is linear at all speeds."""
    return 0.0, 1.0


class StaticKernels(NamedTuple):
    """Kernels of a law in which friction is a function of velocity.

    The argument `direction` of a kernel is +1 or -1, the direction of the motion.
    """

    slip_force: Kernel  # (v, direction, p) -> force [N | N m]
    breakaway: Kernel  # (direction, p) -> largest friction on a body at rest, in that direction
    band: Kernel  # (p) -> half width of the velocity range treated as rest; 0 for exact laws
    seen_velocity: Kernel  # (v, p) -> rate of the position: v; 0 in the rest band of Karnopp's law


class DynamicKernels(NamedTuple):
    """Kernels of a law with an internal state z (n,), float64."""

    rate: Kernel  # (z, v, p, out) -> status; writes z' to out
    force: Kernel  # (z, zdot, v, p) -> force [N | N m]
    commit: Kernel  # (z, v, p) -> status; records an accepted step in the memory, in place
    reset: Kernel  # (p) -> z of a body that has never moved


class HybridKernels(NamedTuple):
    """Kernels of a law with two modes (friction/hybrid_kernels.py).

    The kernels depend on the effort u [N | N m] and the velocity v [m/s | rad/s].
    """

    mode_after: Kernel  # (mode, v, u, z, p) -> mode
    enter: Kernel  # (mode, v, u, z, p) -> status; prepares z, in place, for the new mode
    force: Kernel  # (mode, v, u, z, p) -> force [N | N m]
    acceleration: Kernel  # (mode, v, u, z, p) -> v' [m/s^2 | rad/s^2]
    rate: Kernel  # (mode, v, z, p, out) -> status; writes z' to out
    commit: Kernel  # (mode, z, p) -> status; records an accepted step in the memory, in place
    reset: Kernel  # (p) -> z of a body that has never moved


@dataclass(frozen=True)
class Law:
    """A friction law: its name, its parameters and its kernels.

    - title: name for users
    - equations: numbers of the law's equations in the thesis; empty if the thesis has none
    - approximation: True for a regularised law, which never sticks
    - slip_terms: terms of the slip force in `frictool equations`; if empty, the equations show the
      name of the law
    - slip_scales: function of a static law that computes two speeds [m/s | rad/s] from p. Above the
      first speed, the slip force is p[0] + viscous |v|; the second speed is the reference of
      relative tolerances
    - tail: function that takes the values of a friction.yaml, or an empty mapping, and returns the
      entries of p after the parameters; None if p has no such entries
    - tail_parameters: function that takes the size of the tail and returns the number of identified
      parameters in the tail
    """

    name: str
    title: str
    equations: str
    parameters: tuple[LawParameter, ...]
    kernels: StaticKernels | DynamicKernels | HybridKernels
    approximation: bool = False
    slip_terms: tuple[SlipTerm, ...] = ()
    slip_scales: Callable[[Vector], tuple[float, float]] = curved_slip
    tail: Callable[[Values], Vector] | None = None
    tail_parameters: Callable[[int], int] = int

    @property
    def kind(self) -> Literal["static", "dynamic", "hybrid"]:
        """Return the kind of the law (static, dynamic or hybrid)."""
        if isinstance(self.kernels, StaticKernels):
            return "static"
        return "dynamic" if isinstance(self.kernels, DynamicKernels) else "hybrid"

    def index(self, name: str) -> int:
        """Return the index of a parameter in p.

        Raises ValueError with the nearest name if the name is unknown.
        """
        names = [parameter.name for parameter in self.parameters]
        if name in names:
            return names.index(name)
        near = difflib.get_close_matches(name, names, n=1)
        hint = f"; did you mean {near[0]}?" if near else f"; allowed: {', '.join(names)}"
        raise ValueError(f"{self.name} has no parameter {name}{hint}")

    def pack(
        self, values: Mapping[str, float], axis: Axis = "linear", tail: Vector | None = None
    ) -> Vector:
        """Return the kernels' parameter array p from SI values by name.

        `tail` replaces the default entries of p after the parameters; `maxwell_bank.bank_tail` and
        `preisach_cycles.everett_tail` compute a tail from measurements. Raises ValueError if a
        parameter is unknown, missing or out of range.
        """
        for name in values:
            self.index(name)
        fixed = np.array([self._value(parameter, values, axis) for parameter in self.parameters])
        self._check_order(fixed, axis)
        if self.tail is None:
            if tail is not None:
                raise ValueError(f"{self.name}: found a table; allowed: parameters only")
            return fixed
        table = self.tail({}) if tail is None else np.asarray(tail, dtype=np.float64)
        if table.ndim != 1 or not np.all(np.isfinite(table)):
            raise ValueError(
                f"the table of {self.name} has shape {table.shape}; allowed: one row of "
                "finite numbers"
            )
        return np.concatenate([fixed, table])

    def pack_shared(
        self, values: Values, axis: Axis = "linear", tail: Vector | None = None
    ) -> Vector:
        """Return p from the values of a friction.yaml or model.yaml.

        Raises ValueError as `pack` does. `LawParameter.comparison_value` converts the values to the
        parameters of this law. A parameter without a value has its default.
        """
        chosen = {}
        for parameter in self.parameters:
            if parameter.comparison_value is not None:
                chosen[parameter.name] = parameter.comparison_value(values)
            elif parameter.name in values:
                chosen[parameter.name] = values[parameter.name]
        if tail is None and self.tail is not None:
            tail = self.tail(values)
        return self.pack(chosen, axis, tail)

    def changed(self, p: Vector, values: Mapping[str, float], axis: Axis = "linear") -> Vector:
        """Return a copy of p with new SI values for the parameters in `values`.

        Raises ValueError as `pack` does.
        """
        out = np.array(p, dtype=np.float64)
        for name, value in values.items():
            index = self.index(name)
            out[index] = self.parameters[index].checked(value, axis)
        self._check_order(out[: len(self.parameters)], axis)
        return out

    def _value(self, parameter: LawParameter, values: Mapping[str, float], axis: Axis) -> float:
        value = values.get(parameter.name, parameter.default)
        if value is None:
            raise ValueError(f"{self.name} needs {parameter.name} [{parameter.unit(axis) or '1'}]")
        return parameter.checked(value, axis)

    def _check_order(self, fixed: Vector, axis: Axis) -> None:
        for parameter, value in zip(self.parameters, fixed, strict=True):
            if parameter.at_least is None:
                continue
            bound = fixed[self.index(parameter.at_least)]
            if value < bound:
                unit = f" {parameter.unit(axis)}".rstrip()
                raise ValueError(
                    f"{parameter.name} is {value:g}{unit}; allowed: >= {parameter.at_least}, "
                    f"{bound:g}{unit}"
                )
