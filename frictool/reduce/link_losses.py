"""Replacement of each lossy link by a lossless link and friction on its load side (thesis 2.1.6).

All efforts are in one coordinate, in which each link has the ratio 1. The loss of a link is
drive_loss times the effort on its load side while the source drives, and back_loss times this
effort while the load drives. At a steady speed, the link transmits the efforts of the loads and
friction on its load side. The step adds the losses of these efforts to the curves C_+ and C_-, the
efforts that move the block forward and backward (thesis (2.15)). The effort that accelerates a mass
m on the load side has losses, too. The reflected mass is therefore s m, with s from 1 - back_loss
to 1 + drive_loss for any load. The model's inertia is the value for s = 1, with an interval for all
values of s.

A link with 1 - back_loss < 0 is self-locking, for example a thread whose friction coefficient
exceeds the tangent of its angle. No load moves such a link, and the source must push to lower a
load. A load that accelerates downwards presses less on the link, so that s < 0. The reflected
inertia of the whole mechanism is then less than the inertia of the motor alone.

The step describes the losses by friction, not by an efficiency (thesis (2.14)). With an efficiency,
a load that drives the motor back would give an oscillator without damping.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
import numpy as np

from frictool.adapters.mechanism.transmissions import tangent_of_lead
from frictool.documents.mechanism import Coupling, Gear, Mechanism, Screw
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.connections import BlockMotion, Connection, connections, seen_from
from frictool.reduce.reflected_inertia import ReflectedInertia
from frictool.reduce.resistance_curves import LinkLoss, as_curves
from frictool.reduce.rigid_lumping import bodies, lump_rigid_links
from frictool.reduce.step_report import StepFigure, StepReport
from frictool.reduce.travel_grid import positions


def as_friction(
    mechanism: Mechanism, root: str, whole: Mechanism
) -> tuple[Mechanism, StepReport, ReflectedInertia]:
    """Replace the losses of rigid links by friction; return mechanism, report, reflected inertia.

    All blocks must be in the coordinate of one block.

    - whole: document with the original threads and efficiencies

    Raises NoSolutionError if the source would have to drive a self-locking link backwards.
    """
    x = positions(mechanism)
    figures = []
    notes = []
    predicted = 0.0
    slopes = dict.fromkeys(mechanism.blocks, (1.0, 1.0))
    for name in _deepest_first(mechanism, root):
        assembled = assemble_cached(mechanism)
        link, beyond, near = _placed(assembled, name, root)
        loss = LinkLoss(link.drive_loss, link.back_loss, near)
        helped, against = loss.slopes
        figures += [
            StepFigure(f"{name}: efficiency", 1.0 / loss.factor, ""),
            StepFigure(f"{name}: driven back", 1.0 - link.back_loss, ""),
        ]
        notes.append(_verdict(name, link, whole))
        inertia = assembled.packed.inertia
        predicted = max(
            predicted, (loss.factor - 1.0) * float(np.sum(inertia[beyond]) / np.sum(inertia))
        )
        for block in (assembled.blocks[number] for number in beyond):
            mechanism = as_curves(mechanism, assembled, block, x, loss)
            assembled = assemble_cached(mechanism)
            slopes[block] = _sloped(slopes[block], helped, against)
        if len(beyond) > 1:
            notes.append(
                f"{name}: the losses for the {len(beyond)} blocks beyond this link are added; the "
                "sum is too large where the loads of these blocks balance each other"
            )
        mechanism = msgspec.structs.replace(
            mechanism, links={**mechanism.links, name: _lossless(mechanism, name)}
        )
    lossless = lump_rigid_links(mechanism, root)[0]
    if not figures:
        return lossless, StepReport("losses", "no lossy rigid link", "nothing"), ReflectedInertia()
    reflected = _reflected_inertia(mechanism, root, slopes)
    total = _total(lossless)
    unit = "kg m^2" if _rotary(lossless) else "kg"
    figures += [
        StepFigure("reflected inertia, coasting", reflected.least * total, unit),
        StepFigure("reflected inertia, accelerating", reflected.most * total, unit),
    ]
    return lossless, _losses_report(predicted, tuple(figures), tuple(notes)), reflected


def _sloped(beyond: tuple[float, float], helped: float, against: float) -> tuple[float, float]:
    ends = [slope * one for slope in (helped, against) for one in beyond]
    return min(ends), max(ends)


def _losses_report(
    predicted: float, figures: tuple[StepFigure, ...], notes: tuple[str, ...]
) -> StepReport:
    return StepReport(
        "losses",
        "losses of links as friction that depends on direction and position",
        "losses of links during accelerations",
        predicted,
        "the accelerating effort",
        figures,
        notes,
        covered="the inertia's interval",
    )


def _reflected_inertia(
    mechanism: Mechanism, root: str, slopes: Mapping[str, tuple[float, float]]
) -> ReflectedInertia:
    """Return reflected-inertia bounds of all blocks, and of blocks rigidly linked to the root.

    slopes: for each block, smallest and largest ratio of its reflected inertia to its inertia.
    """
    assembled = assemble_cached(mechanism)
    into = bodies(mechanism, root)
    inertia = dict(zip(assembled.blocks, map(float, assembled.packed.inertia), strict=True))

    def share(names: list[str], end: int) -> float:
        return sum(inertia[name] * slopes[name][end] for name in names) / sum(
            inertia[name] for name in names
        )

    def least(names: list[str]) -> float:
        """Return a lower bound of the sum of the reflected inertias over the sum of the inertias.

        The sums are over the blocks `names`. If the bound is negative, the mechanism locks; a block
        with a negative reflected inertia then counts as 0, and the bound is computed again.
        """
        value = share(names, 0)
        if value > 0.0:
            return value
        kept = sum(inertia[name] * max(0.0, slopes[name][0]) for name in names)
        return kept / sum(inertia[name] for name in names)

    inner = [name for name in inertia if into[name] == root]
    return ReflectedInertia(least(list(inertia)), share(list(inertia), 1), least(inner))


def _total(mechanism: Mechanism) -> float:
    return float(np.sum(assemble_cached(mechanism).packed.inertia))


def _rotary(mechanism: Mechanism) -> bool:
    return assemble_cached(mechanism).kinds[0] == "rotary"


def _lossless(mechanism: Mechanism, name: str) -> Coupling:
    link = mechanism.links[name]
    assert isinstance(link, Gear)
    return Coupling(link.between, link.compliance, link.backlash)


def _deepest_first(mechanism: Mechanism, root: str) -> list[str]:
    assembled = assemble_cached(mechanism)
    links = connections(assembled)
    seen = _seen(assembled, root)
    lossy = [link for link in links if not link.lossless and not link.compliant]
    return [
        link.name
        for link in sorted(lossy, key=lambda link: -max(len(seen[link.a].by), len(seen[link.b].by)))
    ]


def _seen(assembled: AssembledMechanism, root: str) -> Mapping[int, BlockMotion]:
    return seen_from(assembled.blocks.index(root), connections(assembled), assembled.blocks)


def _placed(
    assembled: AssembledMechanism, name: str, root: str
) -> tuple[Connection, list[int], bool]:
    link = next(one for one in connections(assembled) if one.name == name)
    seen = _seen(assembled, root)
    beyond = [number for number, one in seen.items() if name in {step.name for step in one.by}]
    return link, beyond, link.a not in beyond


def _verdict(name: str, link: Connection, whole: Mechanism) -> str:
    original = whole.links.get(name)
    why = f"its efficiency is {1.0 - link.back_loss:.4g} if the load drives"
    if isinstance(original, Screw) and original.friction_coefficient is not None:
        steep = tangent_of_lead(f"links.{name}", original)
        why = (
            f"mu {original.friction_coefficient:.4g} "
            f"{'>' if original.friction_coefficient > steep else '<='} tan(alpha) {steep:.4g}"
        )
    if link.back_loss > 1.0:
        return f"{name} is self-locking: {why}; the model keeps its friction, which holds any load"
    return (
        f"{name} is back-drivable: {why}; loads can drive the link, "
        "but the model keeps its friction, without which the axis would oscillate"
    )
