"""Replacement of springs, cams and friction of each block by one curve C_r(theta, sign).

C_+ and C_- are the efforts that move a block forward and backward, thesis (2.28)-(2.29). The step
also checks at all positions whether the block is self-locking, which means C_+ >= 0 >= C_- (thesis
(2.27)): friction holds the load. In this case, the load becomes part of the friction, with a
separate level for each direction. The behaviour at rest does not change, because the axis sticks
between the same two efforts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from frictool.documents.mechanism import Cam, FrictionOf, Mechanism, Spring
from frictool.friction.law_registry import LAWS
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.block_resistance import resisting
from frictool.reduce.resistance_curves import (
    NO_LOSS,
    NOTHING,
    DirectedResistance,
    as_curves,
    position_elements,
    resistance,
)
from frictool.reduce.step_report import StepFigure, StepReport
from frictool.reduce.travel_grid import positions
from frictool.typing import Vector


@dataclass(frozen=True)
class SelfLockingMargin:
    """Smallest value of friction - |load| [N m | N]; negative if the load moves the axis.

    position: position at which this value occurs [rad | m].
    share: fraction of the positions at which friction holds the load.
    """

    margin: float
    position: float
    share: float


def self_locking_margin(x: Vector, directed: DirectedResistance) -> SelfLockingMargin:
    """Return the smallest value of friction - |load| over the positions x (n,), and its position.

    The value is the smallest effort that moves the block, negative if the load moves the block. The
    result also contains the share of the positions at which friction holds the load.
    """
    margin = np.minimum(directed.forward, -directed.backward)
    worst = int(np.argmin(margin))
    return SelfLockingMargin(float(margin[worst]), float(x[worst]), float(np.mean(margin >= 0.0)))


def in_contact(
    mechanism: Mechanism, x: Vector, behind: Mapping[str, float] | None = None
) -> DirectedResistance:
    """Return the sum of the resistances of all blocks; x (n,) [rad | m]: source positions.

    behind: backlash between the source and each block [rad | m]. A pushed block lags the source by
    half of this backlash, so that its resistance is evaluated at the lagging position. If `behind`
    is None, all blocks are at the position of the source.
    """
    assembled = assemble_cached(mechanism)
    behind = behind or {}
    sums = []
    for direction, names in (
        (1.0, ("forward", "breakaway_forward")),
        (-1.0, ("backward", "breakaway_backward")),
    ):
        positions = [x - 0.5 * direction * behind.get(block, 0.0) for block in assembled.blocks]
        parts = [
            resistance(resisting(assembled, k, position), NO_LOSS)
            for k, position in enumerate(positions)
        ]
        sums += [
            np.asarray(np.sum([getattr(one, name) for one in parts], axis=0)) for name in names
        ]
    forward, rest_forward, backward, rest_backward = sums
    falling = tuple(part for one in parts for part in one.falling)
    return DirectedResistance(
        forward, backward, rest_forward, rest_backward, falling, sum(one.damping for one in parts)
    )


def as_resistance(mechanism: Mechanism) -> tuple[Mechanism, StepReport]:
    """Replace the loads of each block by two curves; blocks with friction only are not changed.

    All blocks must be in the coordinate of one block, and the links must be lossless.
    """
    x = positions(mechanism)
    figures = []
    error = 0.0
    exact = in_contact(mechanism, x)
    between = 0.5 * (x[1:] + x[:-1])
    wanted = in_contact(mechanism, between)
    replaced: list[str] = []
    before = mechanism
    for block in mechanism.blocks:
        assembled = assemble_cached(mechanism)
        terms = resisting(assembled, assembled.blocks.index(block), x)
        if not _is_curve(mechanism, block) and (
            np.max(np.abs(terms.load)) > 0.0 or np.ptp(terms.friction) > 0.0
        ):
            replaced += position_elements(mechanism, block)
            mechanism = as_curves(mechanism, assembled, block, x)
    left_out = neglected_memory(before, replaced)
    margin = self_locking_margin(x, exact)
    largest = max(
        float(np.max(np.abs(exact.forward))), float(np.max(np.abs(exact.backward))), 1e-300
    )
    if replaced:
        obtained = in_contact(mechanism, between)
        error = (
            max(
                float(np.max(np.abs(obtained.forward - wanted.forward))),
                float(np.max(np.abs(obtained.backward - wanted.backward))),
            )
            / largest
        )
    unit = "N m" if assemble_cached(mechanism).kinds[0] == "rotary" else "N"
    position = "rad" if unit == "N m" else "m"
    figures = [
        StepFigure("C_r forward, least", float(np.min(exact.forward)), unit),
        StepFigure("C_r forward, most", float(np.max(exact.forward)), unit),
        StepFigure("C_r backward, least", float(np.min(-exact.backward)), unit),
        StepFigure("C_r backward, most", float(np.max(-exact.backward)), unit),
        StepFigure("friction minus load, least", margin.margin, unit),
        StepFigure("position of this minimum", margin.position, position),
    ]
    did = f"{', '.join(replaced)} as C_r(theta, sign)" if replaced else _unchanged(exact, largest)
    note = (
        "self-locking over the whole travel: without a command the axis stays at rest, and the "
        "friction of the model includes the load"
        if margin.margin >= 0.0
        else f"not self-locking over {1.0 - margin.share:.1%} of the travel: "
        "there the load moves the axis without a command"
    )
    return mechanism, StepReport(
        "resisting curve",
        did,
        ", ".join(["the curves between their points", *left_out]) if replaced else "nothing",
        error,
        "the largest effort",
        tuple(figures),
        (note,),
    )


def _unchanged(directed: DirectedResistance, largest: float) -> str:
    varies = (
        max(float(np.ptp(directed.forward)), float(np.ptp(directed.backward))) > NOTHING * largest
    )
    return (
        "the loads are already a curve for each direction"
        if varies
        else "no load depends on the position"
    )


def neglected_memory(mechanism: Mechanism, names: Iterable[str]) -> list[str]:
    """Return a text for each link in `names` with a friction law whose states are neglected."""
    links = [(name, mechanism.links[name]) for name in names]
    return [
        f"presliding and memory of {name} ({link.law})"
        for name, link in links
        if isinstance(link, FrictionOf) and LAWS[link.law].kind != "static"
    ]


def _is_curve(mechanism: Mechanism, block: str) -> bool:
    links = [mechanism.links[name] for name in position_elements(mechanism, block)]
    springs, cams = (
        [one for one in links if isinstance(one, Spring)],
        [one for one in links if isinstance(one, Cam)],
    )
    plain = all(one.force is not None for one in springs) and all(
        set(one.angle.value.values) == {0.0} for one in cams
    )
    slow = all(
        one.parameters["coulomb"].value == 0.0 for one in links if isinstance(one, FrictionOf)
    )
    return plain and slow and len(springs) <= 1 and len(cams) <= 1
