"""Loads and Coulomb friction of a block as one curve for each direction, C_+(x) and C_-(x) (2.28),
in place of what they come from.

In a mechanism the pair is a spring with the curve of their mean and a pressing, a cam of angle 0,
with half their difference; what depends on the speed stays a friction of its own, whose level a
loss on the way raises.
"""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np

from frictool.documents.mechanism import GROUND, Cam, Curve, FrictionOf, Link, Mechanism, Spring
from frictool.documents.quantity import Axis, Quantity, Series, si_unit
from frictool.errors import NoSolutionError
from frictool.plant.mechanism.assembly import AssembledMechanism
from frictool.reduce.block_resistance import (
    BlockResistance,
    SpeedDependentFriction,
    Vector,
    resisting,
)

NOTHING = 1e-12  # of the largest effort: a curve below it is none


@dataclass(frozen=True)
class LinkLoss:
    """A link's losses at ratio 1: efforts lost per unit carried, driving the far side and driven
    back by it.

    from_near: `a` of the link, whose effort the loss is added to, is the near side.
    """

    drive: float
    back: float
    from_near: bool

    def through(self, opposing: Vector) -> Vector:
        """What the near side feels of an effort `opposing` (n,) the motion at the far one; helps
        where negative."""
        helped, against = self.slopes
        return np.where(opposing > 0.0, opposing * against, opposing * helped)

    @property
    def slopes(self) -> tuple[float, float]:
        """Of an effort that helps, and of one that opposes: what the near side feels of it.

        Raises NoSolutionError where the near side is where the link would have to be driven back
        from, and cannot be.
        """
        if self.from_near:
            return 1.0 - self.back, 1.0 + self.drive
        if self.back >= 1.0:
            raise NoSolutionError(
                "the source would have to drive an irreversible link backwards: it does not move; turn the link round: the "
                "other of its two blocks first"
            )
        return 1.0 / (1.0 + self.drive), 1.0 / (1.0 - self.back)

    @property
    def factor(self) -> float:
        """Of friction that opposes alone."""
        return 1.0 + self.drive if self.from_near else 1.0 / (1.0 - self.back)


NO_LOSS = LinkLoss(0.0, 0.0, True)


@dataclass(frozen=True)
class DirectedResistance:
    """At positions (n,): what it takes forward and backward, in slip and at rest (without what
    `falling` has), N m | N; and that."""

    forward: Vector
    backward: Vector
    breakaway_forward: Vector
    breakaway_backward: Vector
    falling: tuple[SpeedDependentFriction, ...]
    damping: float

    @property
    def mean(self) -> Vector:
        return 0.5 * (self.forward + self.backward)

    @property
    def half(self) -> Vector:
        """Half the difference: friction."""
        return 0.5 * (self.forward - self.backward)


def resistance(found: BlockResistance, loss: LinkLoss = NO_LOSS) -> DirectedResistance:
    """(2.28) behind a link that loses (2.15). Falling and viscous parts are raised as by a load
    that opposes."""
    rest = found.pressed_breakaway
    raised = tuple(
        SpeedDependentFriction(
            one.drop * loss.factor, one.velocity, one.exponent, one.viscous * loss.factor, one.law
        )
        for one in found.falling
    )
    return DirectedResistance(
        loss.through(found.load + found.friction),
        -loss.through(-(found.load - found.friction)),
        loss.through(found.load + rest),
        -loss.through(-(found.load - rest)),
        raised,
        found.damping * loss.factor,
    )


def position_elements(mechanism: Mechanism, block: str) -> tuple[str, ...]:
    """Links that `resistance` of the block stands for."""

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
    """The mechanism with the block's links to the frame and its constant efforts replaced by its
    resistance over positions x (n,)."""
    number = assembled.blocks.index(block)
    found = resistance(resisting(assembled, number, x), loss)
    replaced = position_elements(mechanism, block)
    links = {name: link for name, link in mechanism.links.items() if name not in replaced}
    axis = assembled.kinds[number]
    place, effort = si_unit("position", axis), si_unit("effort", axis)

    def curve(values: Vector) -> Curve:
        return Curve(Series(tuple(map(float, x)), place), Series(tuple(map(float, values)), effort))

    largest = max(float(np.max(np.abs(found.forward))), float(np.max(np.abs(found.backward))))
    name = free_name(links, f"{block}_load")
    damping = (
        Quantity(found.damping, unit=si_unit("viscous", axis)) if found.damping > 0.0 else None
    )
    if np.max(np.abs(found.mean)) > NOTHING * largest:
        links[name] = Spring((block, GROUND), force=curve(found.mean), damping=damping)
    elif damping is not None:
        links[name] = Spring((block, GROUND), damping=damping)
    if np.max(found.half) > NOTHING * largest:
        level = Curve(Series((float(x[0]), float(x[-1])), place), Series((0.0, 0.0), "rad"))
        half = np.maximum(found.half, 0.0)
        links[free_name(links, f"{block}_friction")] = Cam(
            block, curve(half), level, 1.0, max(1.0, breakaway_ratio(found))
        )
    for index, one in enumerate(found.falling):
        if one.drop > 0.0 or one.viscous > 0.0:
            links[free_name(links, f"{block}_speed{index or ''}")] = falling_friction(
                one, block, axis == "rotary"
            )
    sources = {
        name: msgspec.structs.replace(source, effort=None) if source.on == block else source
        for name, source in mechanism.sources.items()
    }
    return msgspec.structs.replace(mechanism, links=links, sources=sources)


def breakaway_ratio(found: DirectedResistance) -> float:
    """Of the friction at rest to that in slip, the mean over the positions."""
    slip = float(np.mean(found.half))
    return (
        float(np.mean(0.5 * (found.breakaway_forward - found.breakaway_backward))) / slip
        if slip > 0.0
        else 1.0
    )


def falling_friction(one: SpeedDependentFriction, block: str, rotary: bool) -> FrictionOf:
    """Friction of speed alone: Stribeck's law, or (2.31) where nothing falls with the speed."""
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
    """A name that no link has."""
    name, count = wanted, 1
    while name in links:
        count += 1
        name = f"{wanted}{count}"
    return name
