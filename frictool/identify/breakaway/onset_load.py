"""Load over position at the onsets of ramps, as far as it is unknown.

A load L(x) at the position x adds to the friction at a forward onset, and is subtracted from it at
a backward one:

    direction effort = friction(x) + direction (offset + L(x))

A log of sliding gives the load. Its effort is subtracted from the ramps, and its intervals widen
that of the breakaway. A load that `load.terms` declares and no log of sliding gives is treated in
two ways, of which the one with the narrower interval is used:

- The load is fitted together with the friction. Friction that varies with position may resemble the
  load. The interval therefore also contains the result of a fit with FURTHER_ORDERS more orders of
  friction over position.
- The load is 0, and the interval contains every load up to `load.most`.

A ripple that the sliding log shows and the model lacks widens the interval by its amplitude, in any
phase. Onsets within one period of the ripple do not show it in their scatter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.laws import Load
from frictool.documents.quantity import Estimate
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from frictool.typing import Matrix, Vector

FURTHER_ORDERS = 2
PHASES = 24  # number of phases of a ripple that are tried
NEGLIGIBLE = 1e-6  # least effort of a fitted load that an offset does not explain, relative to it

SPRING_UNIT = (PositionLoad(1.0),)


def harmonic_units(number: float) -> tuple[PositionLoad, PositionLoad]:
    """Return sine and cosine with the wave number `number` [1/rad | 1/m] and an effort of 1."""
    return (
        PositionLoad(harmonics=(LoadHarmonic(number, 1.0, 0.0),)),
        PositionLoad(harmonics=(LoadHarmonic(number, 0.0, 1.0),)),
    )


def load_sum(units: Sequence[PositionLoad], factors: Vector) -> PositionLoad:
    """Return the sum of the unit loads times their `factors` (p,)."""
    pairs = list(zip(units, factors.tolist(), strict=True))
    return PositionLoad(
        sum(factor * unit.stiffness for unit, factor in pairs),
        tuple(
            LoadHarmonic(number, factor * sine, factor * cosine)
            for unit, factor in pairs
            for number, sine, cosine in unit.harmonics
        ),
    )


@dataclass(frozen=True)
class OnsetLoad:
    """Load whose effort the records of ramps still contain, and errors of the subtracted load.

    - free: unit loads of the declared terms that no log of sliding gives; the effort of the load is
      a sum of these, with unknown factors
    - most: for each declared term in `free`, its loads with the effort `load.most`; empty if the
      bench does not state `load.most`
    - errors: for each parameter of the subtracted load, the differences at the ends of its interval
    - possible: for each further load that may act, its forms; the load is a ripple that the model
      lacks, in PHASES phases
    - constant: True if every dependence on position is attributed to the load, so that the friction
      is fitted as a constant
    - what: names of the declared terms that no log of sliding gives, for messages
    """

    free: tuple[PositionLoad, ...] = ()
    most: tuple[tuple[PositionLoad, ...], ...] = ()
    errors: tuple[tuple[PositionLoad, ...], ...] = ()
    possible: tuple[tuple[PositionLoad, ...], ...] = ()
    constant: bool = False
    what: str = ""

    @property
    def bounded(self) -> OnsetLoad:
        """Return the load with every effort up to `load.most` in place of the unknown factors."""
        return replace(self, free=(), possible=(*self.possible, *self.most), constant=True)


NO_LOAD = OnsetLoad()


def load_errors(load: Load | None) -> tuple[tuple[PositionLoad, ...], ...]:
    """Return, for each parameter of a fitted load, the loads at the ends of its interval.

    The fitted load is subtracted from these loads.
    """
    if load is None:
        return ()
    parts: list[tuple[PositionLoad, Estimate]] = []
    if load.stiffness is not None:
        parts += zip(SPRING_UNIT, (load.stiffness,), strict=True)
    if load.gravity is not None:
        known = load.gravity.sine, load.gravity.cosine
        parts += zip(harmonic_units(1.0), known, strict=True)
    for ripple in load.ripples:
        number = 2.0 * math.pi * ripple.cycles / ripple.per.value
        parts += zip(harmonic_units(number), (ripple.sine, ripple.cosine), strict=True)
    return tuple(
        tuple(load_sum([unit], np.array([end - one.value])) for end in one.interval)
        for unit, one in parts
    )


def ripple_phases(number: float, amplitude: float) -> tuple[PositionLoad, ...]:
    """Return a ripple [N m | N] with the wave number `number` [1/rad | 1/m] in all phases."""
    angles = 2.0 * np.pi * np.arange(PHASES) / PHASES
    factors = amplitude * np.column_stack((np.cos(angles), np.sin(angles)))
    return tuple(load_sum(harmonic_units(number), one) for one in factors)


def independent_loads(units: Sequence[PositionLoad], position: Vector) -> Matrix:
    """Return the factors (p, q) of p unit loads in q sums with uncorrelated efforts at the onsets.

    Sums whose effort hardly differs from an offset are left out.

    - position: position of each onset, (n,), rad | m
    """
    efforts = load_efforts(units, position)
    size = np.linalg.norm(efforts, axis=0)
    size[size == 0.0] = 1.0
    centred = (efforts - np.mean(efforts, axis=0)) / size
    _, singular, right = np.linalg.svd(centred, full_matrices=False)
    kept = singular > NEGLIGIBLE
    return np.asarray(right[kept].T / singular[kept] / size[:, None])


def load_efforts(units: Sequence[PositionLoad], position: Vector) -> Matrix:
    """Return the effort (n, p) of p loads at the positions (n,) [rad | m]."""
    return np.column_stack([unit.at(position) for unit in units])
