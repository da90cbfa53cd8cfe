"""Polynomials of the breakaway over position, fitted to the onsets of ramps, and their errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from frictool.identify.breakaway.onset_friction import OnsetData
from frictool.identify.breakaway.onset_load import OnsetLoad
from frictool.identify.breakaway.position_law import (
    PolynomialOrders,
    choose_structure,
    fit_polynomials,
)
from frictool.identify.breakaway.stribeck_velocity import IMMEDIATE, StribeckVelocityRange
from frictool.identify.fit_result import Interval
from frictool.identify.regression.combined_interval import half_width
from frictool.identify.regression.regression import LeastSquaresSolution
from frictool.plant.position_load import PositionLoad
from frictool.typing import Vector

UNIFORM = float(np.sqrt(3.0))  # half width of a uniform distribution / its standard deviation
# number of iterations: the breakaways at the onsets depend on the fitted polynomials and load, and
# vice versa
ROUNDS = 3


@dataclass(frozen=True)
class BreakawayFit:
    """Breakaway over position as fitted polynomials, and the friction at the onsets.

    - structure: orders of the polynomials
    - shape: breakaway at the onsets divided by the mean, (n,); None if the breakaway is constant
    - solution: least-squares solution for the coefficients of the polynomials
    - friction: breakaway at the onsets, (n,), N m | N
    """

    structure: PolynomialOrders
    shape: Vector | None
    solution: LeastSquaresSolution
    friction: Vector

    @property
    def levels(self) -> list[Vector]:
        """Return weights (p,) of the fitted coefficients for each direction with onsets.

        The coefficients, multiplied by the weights of a direction and added, are its mean
        breakaway.
        """
        structure = self.structure
        unit = np.eye(self.solution.value.size)
        if structure.common:
            return [unit[0], unit[0]]
        sizes = [order + 1 for order in structure.orders]
        return [unit[first] for first, size in zip((0, sizes[0]), sizes, strict=True) if size]


def fit_breakaway(data: OnsetData, nominal: Mapping[str, float]) -> BreakawayFit:
    """Return the polynomials whose orders the onsets support.

    `nominal` contains the parameters of the axis in SI units.
    """
    shape: Vector | None = None
    for _ in range(ROUNDS):
        friction = data.friction(nominal, shape)
        structure = choose_structure(data.positions, friction)
        solution = fit_polynomials(data.positions, friction, structure)
        if structure.constant:
            break
        shape = data.shape(structure, solution.value)
    return BreakawayFit(structure, shape, solution, friction)


@dataclass(frozen=True)
class BreakawayErrors:
    """Errors of the coefficients (p,) of the polynomials of a `BreakawayFit`.

    - ranges: for each uncertain quantity (axis parameters, rest position, load parameters), changes
      (p,) of the coefficients at both ends of its range
    - added: for each of the other causes (Stribeck curves, a drive train that yields just before
      the onset, loads that may act), possible changes (p,) of the coefficients; these errors are
      added in full
    - half_step: half of the increase of a ramp in one sample, N m | N
    """

    solution: LeastSquaresSolution
    ranges: list[Sequence[Vector]]
    added: list[Sequence[Vector]]
    half_step: float
    confidence: float

    def interval(self, weights: Vector) -> Interval:
        """Return the interval of the sum of the coefficients times `weights` (p,)."""
        value = float(weights @ self.solution.value)
        statistical = np.linalg.norm(weights * self.solution.half_width(self.confidence))
        deviation = float(statistical) / float(scipy.special.ndtri(0.5 + 0.5 * self.confidence))

        def largest(sign: float, shifts: Sequence[Vector]) -> float:
            return max([0.0, *(sign * float(weights @ shift) for shift in shifts)])

        down, up = (
            self.half_step
            + sum(largest(sign, shifts) for shifts in self.added)
            + half_width(
                self.confidence,
                deviation,
                [self.half_step, *(largest(sign, shifts) for shifts in self.ranges)],
            )
            for sign in (-1.0, 1.0)
        )
        return Interval(value, value - down, value + up)


def breakaway_errors(
    data: OnsetData,
    fit: BreakawayFit,
    axis: Mapping[str, Interval],
    fall: StribeckVelocityRange,
    load: OnsetLoad,
    half_step: float,
    confidence: float,
) -> BreakawayErrors:
    """Return the errors of the coefficients of `fit`.

    - axis: intervals of `inertia`, `viscous`, `coulomb` and `offset`
    - half_step: half of the increase of a ramp in one sample, N m | N
    """
    nominal = {name: known.value for name, known in axis.items()}
    positions = data.positions
    design = positions.design(fit.structure)
    friction = data.friction(nominal, fit.shape)

    def moved(end: Vector) -> Vector:
        return np.asarray(np.linalg.lstsq(design, end - friction, rcond=None)[0], dtype=np.float64)

    def at(name: str, value: float) -> Vector:
        return moved(data.friction({**nominal, name: value}, fit.shape))

    def under(loads: Sequence[PositionLoad]) -> list[Vector]:
        return [moved(friction - positions.direction * one.at(positions.position)) for one in loads]

    low, high = (moved(data.friction(nominal, fit.shape, end)) for end in (-UNIFORM, UNIFORM))
    ends = [(at(name, one.low), at(name, one.high)) for name, one in axis.items()]
    falls = [replace(data, fall=end) for end in fall.ends]
    yields = []
    if data.yields and fall.velocity > 0.0:
        # a motion of one count by which the drive train yields looks like a slow decrease of
        # friction
        yields.append(data.later(fall.value if fall.known else IMMEDIATE))
    return BreakawayErrors(
        fit.solution,
        [*ends, (low, high), *map(under, load.errors)],
        [
            [moved(fallen.friction(nominal, fit.shape)) for fallen in falls],
            [moved(late.friction(nominal, fit.shape)) for late in yields],
            *map(under, load.possible),
        ],
        half_step,
        confidence,
    )
