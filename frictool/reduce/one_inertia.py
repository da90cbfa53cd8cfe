"""Last step: reduction to one inertia, with C_r(theta, sign) as polynomials and one backlash.

    J theta'' = u - C_r(theta, sign(theta'))        thesis (2.24)-(2.29)

J is the inertia, theta the position, u the effort of the source, and C_r the resistance. While the
backlash is open (thesis (4.45)), only the blocks between the source and the backlash move, against
the friction of these blocks. A block behind the backlash is on the load side. While the source
pushes such a block, the block lags the source by half the backlash; the resistance of the block is
therefore evaluated at this lagging position. The model neglects the masses behind an open backlash,
the error of the polynomials, and the order in which several backlashes open.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from frictool.documents.mechanism import Coupling, Gear, Mechanism, Stop
from frictool.documents.resonances import Resonances
from frictool.errors import NoSolutionError
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.backlash import BacklashChain, play
from frictool.reduce.block_resistance import resisting
from frictool.reduce.kept_resonances import resonances
from frictool.reduce.polynomial_fit import PolynomialFit, fit_polynomial, mean_of
from frictool.reduce.reflected_inertia import ReflectedInertia
from frictool.reduce.residual_load import LoadUnits, ResidualLoad, fit_residual_load
from frictool.reduce.resistance_step import in_contact
from frictool.reduce.rigid_lumping import lump_rigid_links
from frictool.reduce.travel_grid import POINTS, positions
from frictool.typing import Vector

SAME = 1e-9  # distance of ends that count as equal, relative to the travel
FLAT = 1e-9  # variation of a curve that counts as constant, relative to its mean


@dataclass(frozen=True)
class DirectionFriction:
    """Friction in one direction, by position [N m | N], positive if it opposes the motion.

    coulomb: polynomial of the Coulomb friction.
    extra: polynomial of the breakaway minus the Coulomb friction.
    curve: Coulomb friction (n,) that `coulomb` approximates.
    breakaway: breakaway (n,) that `coulomb` plus `extra` approximates.
    met: mask (n,), True where the blocks behind the backlash are within their travel, so that the
        source can push them.
    """

    coulomb: PolynomialFit
    extra: PolynomialFit
    curve: Vector
    breakaway: Vector
    met: NDArray[np.bool_]

    def level(self, low: float, high: float) -> float:
        """Return the mean of the polynomial `coulomb` from position `low` to `high`."""
        return mean_of(self.coulomb.coefficients, low, high)

    @property
    def breakaway_terms(self) -> tuple[float, ...]:
        """Return the coefficients of the breakaway's polynomial, `coulomb` plus `extra`."""
        first, second = self.coulomb.coefficients, self.extra.coefficients
        count = max(len(first), len(second))
        padded = [(*terms, *(0.0 for _ in range(count - len(terms)))) for terms in (first, second)]
        return tuple(a + b for a, b in zip(*padded, strict=True))

    @property
    def misses(self) -> float:
        """Return the largest error of the polynomial `coulomb`, divided by the mean friction."""
        return (
            self.coulomb.error / max(float(np.mean(self.curve)), 1e-300)
            if len(self.coulomb.coefficients) > 1
            else 0.0
        )

    @property
    def flat(self) -> bool:
        """Return True if `coulomb` and `extra` are constants."""
        return len(self.coulomb.coefficients) == 1 and len(self.extra.coefficients) == 1


@dataclass(frozen=True)
class OneInertia:
    """One-inertia model in SI units, in the coordinate of the reduced mechanism.

    inertia: inertia or mass of all blocks.
    inner: inertia or mass that moves while the backlash is open.
    residual: law of the part of the load that the friction curves do not include.
    inside: Coulomb friction while the backlash is open.
    positions: positions (n,) at which the curves of friction are evaluated.
    restitution: coefficient of restitution of the end stops that are not behind backlash.
    reflected: bounds of the inertia reflected through lossy links, relative to `inertia`.
    travel: travel of the source's block between the end stops; None if it is unknown.
    """

    inertia: float
    inner: float
    viscous: float
    forward: DirectionFriction
    backward: DirectionFriction
    residual: ResidualLoad
    stribeck_velocity: float
    stribeck_exponent: float
    play: BacklashChain
    inside: float
    positions: Vector
    resonances: Resonances | None
    restitution: float
    reflected: ReflectedInertia
    travel: tuple[float, float] | None

    @property
    def ends(self) -> tuple[float, float]:
        """Return the first and the last position of the travel."""
        return float(self.positions[0]), float(self.positions[-1])

    def scalars(self) -> dict[str, float]:
        """Return the numbers that may have an interval, by their names in model.yaml."""
        low, high = self.ends
        width = high - low

        def mean(values: Vector) -> float:
            return float(np.trapezoid(values, self.positions)) / width

        numbers = {
            "inertia": self.inertia,
            "viscous": self.viscous,
            "coulomb": mean(self.forward.curve),
            "breakaway": mean(self.forward.breakaway),
            "backward.coulomb": mean(self.backward.curve),
            "backward.breakaway": mean(self.backward.breakaway),
            "offset": self.residual.offset,
            "stiffness": self.residual.stiffness,
            "sine": self.residual.sine,
            "cosine": self.residual.cosine,
            "backlash": self.play.width,
            "backlash_coulomb": self.inside,
            "inertia.least": self.inertia * self.reflected.least,
            "inertia.most": self.inertia * self.reflected.most,
            "inner.least": self.inner * self.reflected.inner_least,
            "least": min(float(np.min(side.curve)) for side in (self.forward, self.backward)),
            "most": max(float(np.max(side.curve)) for side in (self.forward, self.backward)),
        }
        if self.resonances is not None:
            for kind in ("poles", "zeros"):
                numbers |= {
                    f"{kind}.{k}": one.rad_s for k, one in enumerate(getattr(self.resonances, kind))
                }
        return numbers | (
            {"stribeck_velocity": self.stribeck_velocity} if self.stribeck_velocity > 0.0 else {}
        )


def one_inertia(
    mechanism: Mechanism,
    source: str,
    sensor: str,
    reflected: ReflectedInertia,
    side: float = 1.0,
    turns: Sequence[float] = (),
    number: float | None = None,
) -> OneInertia:
    """Reduce a mechanism to one inertia.

    All blocks must be in the coordinate of one block, and the rigid links must be lossless.

    reflected: bounds of the inertia reflected through the lossy links that were replaced.
    side: -1 if the sensor counts down for motion in the positive direction, else 1.
    turns: likely angular wave numbers of the load's harmonic.
    number: wave number of this harmonic (residual_load.py) if it is known, else None.

    Raises NoSolutionError if every load law of model.yaml leaves a load that friction cannot hold.
    """
    root, sensor_block = mechanism.sources[source].on, mechanism.sensors[sensor].on
    stiff = lump_rigid_links(stiffened(mechanism), root)[0]
    assembled = assemble_cached(stiff)
    behind = {name: play(mechanism, root, name).before_sensor for name in stiff.blocks}
    travel = stopped(stiff, behind)
    x = _positions(stiff, travel, behind)
    contact = in_contact(stiff, x, behind)
    first = resisting(assembled, assembled.blocks.index(root), x)
    at_rest = sum(one.drop for one in contact.falling)

    def sides(load: Vector) -> tuple[DirectionFriction, DirectionFriction]:
        """Return the forward and the backward friction that remain after `load` is subtracted."""
        return (
            _side(
                x,
                contact.forward - load,
                contact.breakaway_forward - load + at_rest,
                _met(stiff, x, behind, 1.0),
            ),
            _side(
                x,
                load - contact.backward,
                load - contact.breakaway_backward + at_rest,
                _met(stiff, x, behind, -1.0),
            ),
        )

    units = ("N m", "rad") if assembled.kinds[0] == "rotary" else ("N", "m")

    def misses(law: ResidualLoad) -> float:
        return max(one.misses for one in sides(law.at(x)))

    residual = fit_residual_load(
        x, contact, turns, LoadUnits(mechanism.name, *units, side), misses, number
    )
    forward, backward = sides(residual.at(x))
    falls = [one for one in contact.falling if one.drop > 0.0 and one.velocity > 0.0]
    drop = sum(one.drop for one in falls)
    inner = float(assembled.packed.inertia[assembled.blocks.index(root)])
    return OneInertia(
        inertia=float(np.sum(assembled.packed.inertia)),
        inner=inner,
        viscous=contact.damping + sum(one.viscous for one in contact.falling),
        forward=forward,
        backward=backward,
        residual=residual,
        stribeck_velocity=sum(one.drop * one.velocity for one in falls) / drop
        if drop > 0.0
        else 0.0,
        stribeck_exponent=sum(one.drop * one.exponent for one in falls) / drop
        if drop > 0.0
        else 2.0,
        play=play(mechanism, root, sensor_block),
        inside=float(np.mean(first.friction)),
        positions=x,
        resonances=resonances(mechanism, source, sensor),
        restitution=max(
            (
                one.restitution
                for one in stiff.links.values()
                if isinstance(one, Stop) and behind[one.on] == 0.0
            ),
            default=0.0,
        ),
        reflected=reflected,
        travel=travel,
    )


def _positions(
    mechanism: Mechanism, travel: tuple[float, float] | None, behind: Mapping[str, float]
) -> Vector:
    """Return the positions (n,) of the source's block at which the curves are evaluated.

    The positions include every position at which a block behind backlash is at a point of its
    curve.
    """
    x = positions(mechanism)
    low, high = (float(x[0]), float(x[-1])) if travel is None else travel
    shifted = [x + side * 0.5 * width for width in {0.0, *behind.values()} for side in (-1.0, 1.0)]
    inside = np.concatenate(shifted)
    return np.unique(
        np.concatenate([np.linspace(low, high, POINTS), inside[(inside > low) & (inside < high)]])
    )


def stopped(mechanism: Mechanism, behind: Mapping[str, float]) -> tuple[float, float] | None:
    """Return the travel of the source's block between its end stops; None if it is unknown.

    A stop behind the backlash is shifted outwards by half of the backlash. The ends of the
    document's `travel` replace stops that lie further out. Raises NoSolutionError if the whole
    `travel` lies beyond a stop.
    """
    lows = []
    highs = []
    travel = mechanism.travel
    for link in mechanism.links.values():
        if isinstance(link, Stop):
            margin = 0.5 * behind[link.on]
            lows += [] if link.low is None else [(link.low.value, link.low.value - margin)]
            highs += [] if link.high is None else [(link.high.value, link.high.value + margin)]
    if not lows or not highs:
        return None if travel is None else (travel.low, travel.high)
    (low, least), (high, most) = (
        max(lows, key=lambda ends: ends[1]),
        min(highs, key=lambda ends: ends[1]),
    )
    if travel is None:
        return least, most
    inside = SAME * (high - low)
    if travel.low >= high or travel.high <= low:
        raise NoSolutionError(
            f"{mechanism.name}: its travel, {travel.low:.4g} to {travel.high:.4g} {travel.unit} at "
            f"the source, lies beyond its end stops at {low:.4g} and {high:.4g} {travel.unit}"
        )
    return (travel.low if travel.low > low + inside else least), (
        travel.high if travel.high < high - inside else most
    )


def stiffened(mechanism: Mechanism) -> Mechanism:
    """Return the mechanism in which all links between blocks are rigid; the backlash remains."""
    links = dict(mechanism.links)
    for name, link in links.items():
        if isinstance(link, Coupling | Gear):
            backlash = (
                None
                if link.backlash is None
                else msgspec.structs.replace(link.backlash, compliance=None)
            )
            links[name] = msgspec.structs.replace(link, compliance=None, backlash=backlash)
    return msgspec.structs.replace(mechanism, links=links)


def _met(
    mechanism: Mechanism, x: Vector, behind: Mapping[str, float], direction: float
) -> NDArray[np.bool_]:
    grid = positions(mechanism)
    shift = 0.5 * direction * max(behind.values(), default=0.0)
    margin = 1e-9 * float(grid[-1] - grid[0])
    return np.asarray((x - shift >= grid[0] - margin) & (x - shift <= grid[-1] + margin))


def _side(
    x: Vector, coulomb: Vector, breakaway: Vector, met: NDArray[np.bool_]
) -> DirectionFriction:
    coulomb = np.maximum(coulomb, 0.0)
    breakaway = np.maximum(breakaway, coulomb)
    over = (float(x[0]), float(x[-1]))
    met = met if np.count_nonzero(met) > 1 else np.ones_like(met)
    return DirectionFriction(
        _fit(x[met], coulomb[met], over),
        _fit(x[met], (breakaway - coulomb)[met], over),
        coulomb,
        breakaway,
        met,
    )


def _fit(x: Vector, values: Vector, over: tuple[float, float]) -> PolynomialFit:
    if np.ptp(values) <= FLAT * max(float(np.max(np.abs(values))), 1e-300):
        return PolynomialFit((float(np.mean(values)),), 0.5 * float(np.ptp(values)))
    return fit_polynomial(x, values, over)
