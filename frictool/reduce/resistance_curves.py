"""Load and Coulomb friction of a block as one curve for each direction of motion.

Two elements of a mechanism represent the pair of curves: a spring with the mean of both curves, and
a cam of angle 0 with half the difference as friction. Speed-dependent friction remains a separate
element, raised by the losses of the link towards the source.
"""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np

from frictool.documents.mechanism import GROUND, Cam, Curve, FrictionOf, Link, Mechanism, Spring
from frictool.documents.quantity import Axis, Quantity, Series, si_unit
from frictool.errors import NoSolutionError
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.reduce.block_resistance import BlockResistance, SpeedDependentFriction, resisting
from frictool.typing import Vector

NOTHING = 1e-12  # largest omitted curve, relative to the largest effort


@dataclass(frozen=True)
class LinkLoss:
    """Losses of a link of ratio 1; the near side is towards the source, the far side towards loads.

    drive: lost effort divided by the transmitted effort, while the near side drives.
    back: lost effort divided by the transmitted effort, while the far side drives.
    from_near: True if end `a` of the link is the near side.
    """

    drive: float
    back: float
    from_near: bool

    def through(self, opposing: Vector) -> Vector:
        """Return the effort (n,) on the source side that balances `opposing` (n,) on the far side.

        Both efforts are positive if they oppose the motion.
        """
        helped, against = self.slopes
        return np.where(opposing > 0.0, opposing * against, opposing * helped)

    @property
    def slopes(self) -> tuple[float, float]:
        """Return (effort at the near side)/(effort at the far side) for two directions of power.

        The first quotient is for an effort at the far side that drives the motion, the second for
        an effort that opposes the motion. Raises NoSolutionError if the near side would have to
        drive a self-locking link backwards.
        """
        if self.from_near:
            return 1.0 - self.back, 1.0 + self.drive
        if self.back >= 1.0:
            raise NoSolutionError(
                "the source acts on the load end of a self-locking link, but only the other end "
                "can drive; swap the two blocks of the link"
            )
        return 1.0 / (1.0 + self.drive), 1.0 / (1.0 - self.back)

    @property
    def factor(self) -> float:
        """Return the factor that reflects friction from the far side (load) to the near side."""
        return 1.0 + self.drive if self.from_near else 1.0 / (1.0 - self.back)


NO_LOSS = LinkLoss(0.0, 0.0, True)


@dataclass(frozen=True)
class DirectedResistance:
    """Resistance at n positions in the two directions of motion, in slip and at rest [N m | N].

    forward, backward: resistance (n,) in slip.
    breakaway_forward, breakaway_backward: resistance (n,) at rest, without the part in `falling`.
    falling: speed-dependent friction, the same at all positions.
    damping: viscous resistance divided by the speed.
    """

    forward: Vector
    backward: Vector
    breakaway_forward: Vector
    breakaway_backward: Vector
    falling: tuple[SpeedDependentFriction, ...]
    damping: float

    @property
    def mean(self) -> Vector:
        """Return the load (n,), the mean of the resistance in the two directions of motion."""
        return 0.5 * (self.forward + self.backward)

    @property
    def half(self) -> Vector:
        """Return the friction (n,), half the difference of the resistance in the two directions."""
        return 0.5 * (self.forward - self.backward)


def resistance(block: BlockResistance, loss: LinkLoss = NO_LOSS) -> DirectedResistance:
    """Return the resistance of a block, reflected through a lossy link (thesis (2.15), (2.28)).

    Speed-dependent friction is multiplied by `loss.factor`.
    """
    rest = block.pressed_breakaway
    raised = tuple(
        SpeedDependentFriction(
            one.drop * loss.factor, one.velocity, one.exponent, one.viscous * loss.factor, one.law
        )
        for one in block.falling
    )
    return DirectedResistance(
        loss.through(block.load + block.friction),
        -loss.through(-(block.load - block.friction)),
        loss.through(block.load + rest),
        -loss.through(-(block.load - rest)),
        raised,
        block.damping * loss.factor,
    )


def position_elements(mechanism: Mechanism, block: str) -> tuple[str, ...]:
    """Return the names of the links that are replaced by the resistance curves of the block."""

    def is_one(link: Link) -> bool:
        if isinstance(link, Spring):
            return block in link.between and GROUND in link.between
        return isinstance(link, Cam | FrictionOf) and link.on == block

    return tuple(name for name, link in mechanism.links.items() if is_one(link))


def as_curves(
    mechanism: Mechanism,
    assembled: AssembledMechanism,
    block: str,
    x: Vector,
    loss: LinkLoss = NO_LOSS,
) -> Mechanism:
    """Replace the links to the frame and the constant efforts of `block` by curves at x (n,)."""
    number = assembled.blocks.index(block)
    directed = resistance(resisting(assembled, number, x), loss)
    replaced = position_elements(mechanism, block)
    links = {name: link for name, link in mechanism.links.items() if name not in replaced}
    axis = assembled.kinds[number]
    position, effort = si_unit("position", axis), si_unit("effort", axis)

    def curve(values: Vector) -> Curve:
        return Curve(
            Series(tuple(map(float, x)), position), Series(tuple(map(float, values)), effort)
        )

    largest = max(float(np.max(np.abs(directed.forward))), float(np.max(np.abs(directed.backward))))
    name = free_name(links, f"{block}_load")
    damping = (
        Quantity(directed.damping, unit=si_unit("viscous", axis))
        if directed.damping > 0.0
        else None
    )
    if np.max(np.abs(directed.mean)) > NOTHING * largest:
        links[name] = Spring((block, GROUND), force=curve(directed.mean), damping=damping)
    elif damping is not None:
        links[name] = Spring((block, GROUND), damping=damping)
    if np.max(directed.half) > NOTHING * largest:
        level = Curve(Series((float(x[0]), float(x[-1])), position), Series((0.0, 0.0), "rad"))
        half = np.maximum(directed.half, 0.0)
        links[free_name(links, f"{block}_friction")] = Cam(
            block, curve(half), level, 1.0, max(1.0, breakaway_ratio(directed))
        )
    for index, one in enumerate(directed.falling):
        if one.drop > 0.0 or one.viscous > 0.0:
            links[free_name(links, f"{block}_speed{index or ''}")] = falling_friction(
                one, block, axis == "rotary"
            )
    sources = {
        name: msgspec.structs.replace(source, effort=None) if source.on == block else source
        for name, source in mechanism.sources.items()
    }
    return msgspec.structs.replace(mechanism, links=links, sources=sources)


def breakaway_ratio(directed: DirectedResistance) -> float:
    """Return the ratio of the mean friction at rest to the mean friction in slip."""
    slip = float(np.mean(directed.half))
    return (
        float(np.mean(0.5 * (directed.breakaway_forward - directed.breakaway_backward))) / slip
        if slip > 0.0
        else 1.0
    )


def falling_friction(one: SpeedDependentFriction, block: str, rotary: bool) -> FrictionOf:
    """Return speed-dependent friction as law `stribeck`, or as `svc` if it never falls."""
    axis: Axis = "rotary" if rotary else "linear"
    effort, viscous = si_unit("effort", axis), si_unit("viscous", axis)
    parameters = {
        "coulomb": Quantity(0.0, unit=effort),
        "breakaway": Quantity(one.drop, unit=effort),
        "viscous": Quantity(one.viscous, unit=viscous),
    }
    if one.velocity > 0.0 and one.drop > 0.0:
        parameters["stribeck_velocity"] = Quantity(one.velocity, unit=si_unit("velocity", axis))
        parameters["stribeck_exponent"] = Quantity(one.exponent, unit="1")
        return FrictionOf(block, "stribeck", parameters)
    return FrictionOf(block, "svc", parameters)


def free_name(links: dict[str, Link], wanted: str) -> str:
    """Return `wanted`, or a similar name that no link has."""
    name = wanted
    count = 1
    while name in links:
        count += 1
        name = f"{wanted}{count}"
    return name
