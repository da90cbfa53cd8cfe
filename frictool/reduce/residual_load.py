"""Law of model.yaml for the load that friction cannot hold, in the reduced coordinate x [rad | m].

    load(x) = offset + stiffness x + sine sin(number x) + cosine cos(number x)

The law has a spring or a harmonic, not both. `number` is the harmonic's angular wave number: for
gravity on an arm behind a gear, the gear's ratio; for cogging, the number of poles. The ratios of
the rotary blocks are tried first, then any other value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy

from frictool.errors import NoSolutionError
from frictool.reduce.advice import parts_of_travel
from frictool.reduce.resistance_curves import DirectedResistance
from frictool.typing import Vector

NOTHING = 1e-12  # largest omitted term, relative to the largest load
HELD = 1e-9  # allowed excess of the remaining load over friction, relative to the largest load
FITS = 0.01  # sufficient error of the friction's polynomials, relative to the mean friction
LEAST_TURN = 0.5  # smallest phase [rad] of a harmonic over the travel; a smaller part is a line
POINTS_PER_CYCLE = 8.0  # positions per cycle of the fastest harmonic
NUMBERS = 300  # number of values of `number` that are tried before the best value is refined


@dataclass(frozen=True)
class ResidualLoad:
    """Coefficients of the load law in SI; by default there is no load."""

    offset: float = 0.0
    stiffness: float = 0.0
    number: float = 0.0  # 1/rad | 1/m; 0: no harmonic
    sine: float = 0.0
    cosine: float = 0.0

    def at(self, x: Vector) -> Vector:
        """Return the load (n,) [N m | N] at x (n,), positive if it opposes a positive effort."""
        straight = self.offset + self.stiffness * x
        return np.asarray(
            straight + self.sine * np.sin(self.number * x) + self.cosine * np.cos(self.number * x)
        )


@dataclass(frozen=True)
class LoadUnits:
    """Name of the mechanism and units for error messages.

    side: -1 if the sensor's reading falls while the position x of the law rises, else 1.
    """

    name: str
    effort: str
    position_unit: str
    side: float = 1.0


def fit_residual_load(
    x: Vector,
    resistance: DirectedResistance,
    turns: Iterable[float],
    words: LoadUnits,
    misses: Callable[[ResidualLoad], float],
    known: float | None = None,
) -> ResidualLoad:
    """Return a load law whose remaining load friction can hold; simple laws are preferred.

    The remaining load is the load minus the law. A law is acceptable if friction holds the
    remaining load at rest. Laws are tried from simple to general, beginning with no load. The
    result is the first acceptable law for which the error of the friction's polynomials is below
    FITS. If there is none, the result is the acceptable law with the smallest error of the
    polynomials.

    resistance: resistance at the positions x (n,) in the two directions.
    turns: likely angular wave numbers of the harmonic.
    misses: function that returns the error of the friction's polynomials for a law.
    known: angular wave number in the law of the same mechanism with other parameter values; 0 if
        that law has no harmonic, None if the wave number is unknown.

    Raises NoSolutionError if no law is acceptable. The message names ranges of the travel for which
    a constant or a spring suffices.
    """
    mean, half = resistance.mean, resistance.half
    scale = max(float(np.max(np.abs(mean))), 1e-300)
    fits: list[tuple[float, ResidualLoad]] = []
    nearest = ResidualLoad()
    for one in (_rounded(law, scale, x) for law in _laws(x, mean, turns, known)):
        if _short(one, x, mean, half) < _short(nearest, x, mean, half):
            nearest = one
        if _short(one, x, mean, half) <= HELD * scale:
            fits.append((misses(one), one))
            if fits[-1][0] <= FITS:
                return one
    if not fits:
        raise NoSolutionError(_refusal(x, mean, half, nearest, words))
    return min(fits, key=lambda pair: pair[0])[1]


def _laws(
    x: Vector, mean: Vector, turns: Iterable[float], known: float | None
) -> Iterator[ResidualLoad]:
    if known:
        yield _harmonic(x, mean, known)
    yield ResidualLoad()
    yield _line(x, mean, 0)
    straight = _line(x, mean, 1)
    if known is not None:
        yield straight
        return
    least, most = _numbers(x)
    turning = [
        _harmonic(x, mean, number) for number in sorted(set(turns)) if least <= number <= most
    ]
    yield from sorted([straight, *turning], key=lambda one: _left(one, x, mean))
    if least < most:
        yield _any_harmonic(x, mean, least, most)


def _line(x: Vector, mean: Vector, degree: int) -> ResidualLoad:
    terms = np.polynomial.polynomial.polyfit(x, mean, degree)
    return ResidualLoad(float(terms[0]), float(terms[1]) if degree else 0.0)


def _harmonic(x: Vector, mean: Vector, number: float) -> ResidualLoad:
    columns = np.column_stack([np.ones_like(x), np.sin(number * x), np.cos(number * x)])
    offset, sine, cosine = (float(one) for one in np.linalg.lstsq(columns, mean)[0])
    return ResidualLoad(offset, 0.0, number, sine, cosine)


def _numbers(x: Vector) -> tuple[float, float]:
    return LEAST_TURN / float(x[-1] - x[0]), 2.0 * math.pi / (
        POINTS_PER_CYCLE * float(np.median(np.diff(x)))
    )


def _any_harmonic(x: Vector, mean: Vector, least: float, most: float) -> ResidualLoad:
    def squares(number: float) -> float:
        return float(np.sum((mean - _harmonic(x, mean, number).at(x)) ** 2))

    looked = np.linspace(least, most, NUMBERS)
    best = int(np.argmin([squares(float(number)) for number in looked]))
    ends = (float(looked[max(best - 1, 0)]), float(looked[min(best + 1, NUMBERS - 1)]))
    return _harmonic(
        x,
        mean,
        float(
            scipy.optimize.minimize_scalar(
                squares, bounds=ends, method="bounded", options={"xatol": 1e-10 * ends[1]}
            ).x
        ),
    )


def _left(one: ResidualLoad, x: Vector, mean: Vector) -> float:
    return float(np.max(np.abs(mean - one.at(x))))


def _short(one: ResidualLoad, x: Vector, mean: Vector, half: Vector) -> float:
    """Return max(|remaining load| - friction) [N m | N] over the positions x.

    mean, half: load and friction (n,) at x.
    """
    return float(np.max(np.abs(mean - one.at(x)) - half))


def _rounded(one: ResidualLoad, scale: float, x: Vector) -> ResidualLoad:
    def kept(value: float, reach: float = 1.0) -> float:
        return 0.0 if abs(value) * reach < NOTHING * scale else value

    stiffness = kept(one.stiffness, max(abs(float(x[0])), abs(float(x[-1]))))
    return ResidualLoad(kept(one.offset), stiffness, one.number, kept(one.sine), kept(one.cosine))


def _refusal(x: Vector, mean: Vector, half: Vector, nearest: ResidualLoad, words: LoadUnits) -> str:
    left = np.abs(mean - nearest.at(x)) - half
    worst = int(np.argmax(left))
    side = words.side
    parts = parts_of_travel(x, _straight(x, mean, half))
    ranges = [sorted(side * end for end in part) for part in parts]
    if not ranges:
        tried = "the mechanism itself (frictool simulate), or the mechanism that --reduced writes"
    else:
        tried = " and ".join(f"--travel {low:.6g} {high:.6g}" for low, high in sorted(ranges))
        tried += ", with one model for each part" if len(ranges) > 1 else ", where a law suffices"
    return (
        f"{words.name}: at {side * x[worst]:.4g} {words.position_unit} the load is "
        f"{side * mean[worst]:.4g} {words.effort}, but friction holds only {half[worst]:.4g} "
        f"{words.effort}; the best law of model.yaml (constant, spring, harmonic) leaves "
        f"{left[worst]:.3g} {words.effort} too much; try {tried}"
    )


def _straight(x: Vector, mean: Vector, half: Vector) -> Callable[[slice], bool]:
    def holds(part: slice) -> bool:
        margin = HELD * max(float(np.max(np.abs(mean[part]))), 1e-300)
        return any(
            _short(_line(x[part], mean[part], degree), x[part], mean[part], half[part]) <= margin
            for degree in (0, 1)
        )

    return holds
