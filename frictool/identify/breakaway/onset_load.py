"""Unknown load over position at the onsets of ramps.

A load L(x) at the position x adds to the friction at a forward onset, and is subtracted from the
friction at a backward onset:

    direction effort = friction(x) + direction (offset + L(x))

If a log of sliding determines the load, the effort of the load is subtracted at the onsets. The
intervals of the load then widen the interval of the breakaway. If `load.terms` declares a load that
no log of sliding determines, two results are computed, and the result with the narrower interval is
used:

- The load is fitted together with the friction. Friction that varies with position may resemble the
  load. The interval of the breakaway therefore also contains the result of a fit in which the
  polynomial of friction over position has FURTHER_ORDERS more orders.
- The load is 0, and the interval of the breakaway allows for every load up to `load.most`.

If the sliding log shows a ripple that the model lacks, the interval of the breakaway includes the
effect of this ripple with any phase. If all onsets lie within one period of the ripple, their
scatter does not show the ripple.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frictool.documents.laws import Load
from frictool.documents.quantity import Estimate, Span
from frictool.plant.position_load import LoadHarmonic, PositionLoad
from frictool.typing import Matrix, Vector

FURTHER_ORDERS = 2
PHASES = 24  # number of phases of a ripple that are tried
NEGLIGIBLE = 1e-6  # least share of a load's effort that an offset cannot explain

SPRING_UNIT = (PositionLoad(1.0),)
CONSTANT = PositionLoad(harmonics=(LoadHarmonic(0.0, 0.0, 1.0),))


def harmonic_units(number: float) -> tuple[PositionLoad, PositionLoad]:
    """Return sine and cosine loads of amplitude 1; `number` is the wave number [1/rad | 1/m]."""
    return (
        PositionLoad(harmonics=(LoadHarmonic(number, 1.0, 0.0),)),
        PositionLoad(harmonics=(LoadHarmonic(number, 0.0, 1.0),)),
    )


def load_sum(units: Sequence[PositionLoad], factors: Vector) -> PositionLoad:
    """Return the sum of p unit loads, each multiplied by its factor in `factors` (p,)."""
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
    """Unknown load in the records of ramps, and errors of their known load.

    - free: unit loads of the declared terms that no log of sliding determines; the load is the sum
      of these unit loads times unknown factors
    - most: for each of these terms, loads with the largest effort `load.most`; empty if the bench
      does not state `load.most`
    - errors: for each parameter of the known load, the change of the load at either end of the
      parameter's interval
    - possible: for each further load that may act, its possible forms, such as a ripple in PHASES
      phases
    - constant: True if every dependence on position is attributed to the load, so that the friction
      is fitted as a constant
    - what: names of the declared terms that no log of sliding determines, for messages
    """

    free: tuple[PositionLoad, ...] = ()
    most: tuple[tuple[PositionLoad, ...], ...] = ()
    errors: tuple[tuple[PositionLoad, ...], ...] = ()
    possible: tuple[tuple[PositionLoad, ...], ...] = ()
    constant: bool = False
    what: str = ""

    @property
    def bounded(self) -> OnsetLoad:
        """Return a copy with the loads `most` among the `possible` loads, and no `free` loads."""
        return replace(self, free=(), possible=(*self.possible, *self.most), constant=True)


NO_LOAD = OnsetLoad()


def joint_error(load: Load | None, offset: float) -> float | None:
    """Return the error of the total load [N m | N] if it is below `offset`, else None.

    The total load is the sum of all loads and the offset.

    offset: half width of the interval of the offset, N m | N
    """
    if load is None or load.total is None or load.total.error.value >= offset:
        return None
    return load.total.error.value


def joint_errors(over: Span | None, error: float) -> tuple[tuple[PositionLoad, ...], ...]:
    """Return two possible errors of a total load: a constant, and a line over the positions `over`.

    Each error has a largest effort of `error` [N m | N], with either sign. Without `over`, a sine
    and a cosine replace the line.
    """
    units = [CONSTANT, *harmonic_units(1.0)] if over is None else [CONSTANT]
    if over is not None:
        middle, slope = 0.5 * (over.low + over.high), 2.0 / (over.high - over.low)
        units.append(load_sum([*SPRING_UNIT, CONSTANT], slope * np.array([1.0, -middle])))
    return tuple(
        tuple(load_sum([unit], np.array([end])) for end in (-error, error)) for unit in units
    )


def load_errors(load: Load | None) -> tuple[tuple[PositionLoad, ...], ...]:
    """Return, for each load parameter, the change of the load at either end of its interval."""
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
    """Return ripples with the wave number `number` [1/rad | 1/m], one for each of PHASES phases.

    amplitude: amplitude of the ripples, N m | N.
    """
    angles = 2.0 * np.pi * np.arange(PHASES) / PHASES
    factors = amplitude * np.column_stack((np.cos(angles), np.sin(angles)))
    return tuple(load_sum(harmonic_units(number), one) for one in factors)


def independent_loads(units: Sequence[PositionLoad], position: Vector) -> Matrix:
    """Return factors (p, q) that combine p unit loads to q loads, uncorrelated at the onsets.

    Loads that hardly differ from an offset at the onsets are left out.

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
