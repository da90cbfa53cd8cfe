"""The last step: one inertia, the curve C_r(theta, sign) as polynomials, one backlash
(2.24)-(2.29), (4.45).

    J theta'' = u - C_r(theta, sign(theta'))        inside the backlash only what lies before it
                                                    moves, with its friction

What lies behind a play is half of it behind the source when it is pushed, forward and backward:
each direction's curve is that of the place where the block then is. What is neglected: masses
behind the play while it is open; curves between polynomial and points; where several links play,
that they open one after another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray

from frictool.documents.mechanism import Coupling, Gear, Mechanism, Stop
from frictool.documents.resonances import Resonances
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.backlash import BacklashChain, play
from frictool.reduce.block_resistance import Vector, resisting
from frictool.reduce.polynomial_fit import PolynomialFit, fit_polynomial, mean_of
from frictool.reduce.reflected_inertia import ReflectedInertia
from frictool.reduce.residual_load import LoadUnits, ResidualLoad, load_beside
from frictool.reduce.resisting_curves import in_contact
from frictool.reduce.resonances import resonances
from frictool.reduce.rigid_lumping import lump_rigid_links
from frictool.reduce.travel_grid import POINTS, positions

SAME = 1e-9  # of the travel: ends that are nearer are one
FLAT = 1e-9  # of its mean: a curve that varies less is a number


@dataclass(frozen=True)
class DirectionFriction:
    """One direction: Coulomb friction and breakaway over the travel, and what they are near to,
    each > 0 where it opposes."""

    coulomb: PolynomialFit
    extra: PolynomialFit  # breakaway over Coulomb friction
    curve: Vector  # (n,)
    breakaway: Vector  # (n,)
    met: NDArray[
        np.bool_
    ]  # (n,) where the source can push what lies behind its play; elsewhere it turns back before

    def level(self, low: float, high: float) -> float:
        """The mean of the polynomial."""
        return mean_of(self.coulomb.coefficients, low, high)

    @property
    def breakaway_terms(self) -> tuple[float, ...]:
        """Coefficients of both together."""
        first, second = self.coulomb.coefficients, self.extra.coefficients
        count = max(len(first), len(second))
        padded = [(*terms, *(0.0 for _ in range(count - len(terms)))) for terms in (first, second)]
        return tuple(a + b for a, b in zip(*padded, strict=True))

    @property
    def misses(self) -> float:
        """What the polynomials are off the curve, of the mean friction."""
        return (
            self.coulomb.error / max(float(np.mean(self.curve)), 1e-300)
            if len(self.coulomb.coefficients) > 1
            else 0.0
        )

    @property
    def flat(self) -> bool:
        return len(self.coulomb.coefficients) == 1 and len(self.extra.coefficients) == 1


@dataclass(frozen=True)
class OneInertia:
    """SI, in the coordinate of the mechanism. inner: the inertia that moves inside the play.
    beside: the load that is none of friction. positions (n,): where the curves are known."""

    inertia: float
    inner: float
    viscous: float
    forward: DirectionFriction
    backward: DirectionFriction
    beside: ResidualLoad
    stribeck_velocity: float
    stribeck_exponent: float
    play: BacklashChain
    inside: float  # Coulomb friction inside the play
    positions: Vector
    resonances: Resonances | None
    restitution: float  # at end stops of what does not lie behind a play
    felt: ReflectedInertia  # the interval of the inertia that losses make
    travel: tuple[float, float] | None  # between end stops, of the source's block

    @property
    def ends(self) -> tuple[float, float]:
        return float(self.positions[0]), float(self.positions[-1])

    def scalars(self) -> dict[str, float]:
        """The numbers that carry intervals, by the names of model.yaml."""
        low, high = self.ends
        width = high - low

        def mean(values: Vector) -> float:
            return float(np.trapezoid(values, self.positions)) / width

        found = {
            "inertia": self.inertia,
            "viscous": self.viscous,
            "coulomb": mean(self.forward.curve),
            "breakaway": mean(self.forward.breakaway),
            "backward.coulomb": mean(self.backward.curve),
            "backward.breakaway": mean(self.backward.breakaway),
            "offset": self.beside.offset,
            "stiffness": self.beside.stiffness,
            "sine": self.beside.sine,
            "cosine": self.beside.cosine,
            "backlash": self.play.width,
            "backlash_coulomb": self.inside,
            "inertia.least": self.inertia * self.felt.least,
            "inertia.most": self.inertia * self.felt.most,
            "inner.least": self.inner * self.felt.inner_least,
            "least": min(float(np.min(side.curve)) for side in (self.forward, self.backward)),
            "most": max(float(np.max(side.curve)) for side in (self.forward, self.backward)),
        }
        if self.resonances is not None:
            for kind in ("poles", "zeros"):
                found |= {
                    f"{kind}.{k}": one.rad_s for k, one in enumerate(getattr(self.resonances, kind))
                }
        return found | (
            {"stribeck_velocity": self.stribeck_velocity} if self.stribeck_velocity > 0.0 else {}
        )


def one_inertia(
    mechanism: Mechanism,
    source: str,
    sensor: str,
    felt: ReflectedInertia,
    side: float = 1.0,
    turns: Sequence[float] = (),
    number: float | None = None,
) -> OneInertia:
    """Of a mechanism in one coordinate whose rigid links lose nothing; felt: what those that did
    make of its inertia; side: -1 where the sensor counts against that coordinate; turns, number: of
    the load's harmonic, as `load_beside` takes them.

    Raises NoSolutionError where the load that friction does not hold is none that a model.yaml has.
    """
    root, sensor_block = mechanism.sources[source].on, mechanism.sensors[sensor].on
    stiff = lump_rigid_links(stiffened(mechanism), root)[0]
    assembled = assemble_cached(stiff)
    behind = {name: play(mechanism, root, name).before_sensor for name in stiff.blocks}
    travel = stopped(stiff, behind)
    x = _positions(stiff, travel, behind)
    found = in_contact(stiff, x, behind)
    first = resisting(assembled, assembled.blocks.index(root), x)
    at_rest = sum(one.drop for one in found.falling)

    def sides(load: Vector) -> tuple[DirectionFriction, DirectionFriction]:
        """Friction forward and backward, beside this load."""
        return (
            _side(
                x,
                found.forward - load,
                found.breakaway_forward - load + at_rest,
                _met(stiff, x, behind, 1.0),
            ),
            _side(
                x,
                load - found.backward,
                load - found.breakaway_backward + at_rest,
                _met(stiff, x, behind, -1.0),
            ),
        )

    units = ("N m", "rad") if assembled.kinds[0] == "rotary" else ("N", "m")

    def misses(law: ResidualLoad) -> float:
        return max(one.misses for one in sides(law.at(x)))

    beside = load_beside(x, found, turns, LoadUnits(mechanism.name, *units, side), misses, number)
    forward, backward = sides(beside.at(x))
    falls = [one for one in found.falling if one.drop > 0.0 and one.velocity > 0.0]
    drop = sum(one.drop for one in falls)
    inner = float(assembled.packed.inertia[assembled.blocks.index(root)])
    return OneInertia(
        inertia=float(np.sum(assembled.packed.inertia)),
        inner=inner,
        viscous=found.damping + sum(one.viscous for one in found.falling),
        forward=forward,
        backward=backward,
        beside=beside,
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
        felt=felt,
        travel=travel,
    )


def _positions(
    mechanism: Mechanism, travel: tuple[float, float] | None, behind: Mapping[str, float]
) -> Vector:
    """Where the source's block is looked at: its travel, with the places at which blocks behind a
    play meet points of their curves."""
    x = positions(mechanism)
    low, high = (float(x[0]), float(x[-1])) if travel is None else travel
    shifted = [x + side * 0.5 * width for width in {0.0, *behind.values()} for side in (-1.0, 1.0)]
    inside = np.concatenate(shifted)
    return np.unique(
        np.concatenate([np.linspace(low, high, POINTS), inside[(inside > low) & (inside < high)]])
    )


def stopped(mechanism: Mechanism, behind: Mapping[str, float]) -> tuple[float, float] | None:
    """Between which positions the source's block is looked at: its end stops, half a play beyond
    those that lie behind one; but no further than a `travel` whose end lies within them."""
    lows, highs, travel = [], [], mechanism.travel
    for link in mechanism.links.values():
        if isinstance(link, Stop):
            room = 0.5 * behind[link.on]
            lows += [] if link.low is None else [(link.low.value, link.low.value - room)]
            highs += [] if link.high is None else [(link.high.value, link.high.value + room)]
    if not lows or not highs:
        return None if travel is None else (travel.low, travel.high)
    (low, least), (high, most) = (
        max(lows, key=lambda ends: ends[1]),
        min(highs, key=lambda ends: ends[1]),
    )
    if travel is None:
        return least, most
    inside = SAME * (high - low)
    return (travel.low if travel.low > low + inside else least), (
        travel.high if travel.high < high - inside else most
    )


def stiffened(mechanism: Mechanism) -> Mechanism:
    """The mechanism with every link between two blocks rigid; play stays."""
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
    """Positions (n,) at which the source can push in this direction what lies behind its play:
    within that one's own travel."""
    places, shift = positions(mechanism), 0.5 * direction * max(behind.values(), default=0.0)
    room = 1e-9 * float(places[-1] - places[0])
    return np.asarray((x - shift >= places[0] - room) & (x - shift <= places[-1] + room))


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
