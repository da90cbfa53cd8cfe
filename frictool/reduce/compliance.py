"""Compliant links: a link with a resonance above the bandwidth is made rigid (thesis 2.6-2.9).

Two inertias J_a and J_b with a stiffness k between them resonate at w_r = sqrt(k (1/J_a + 1/J_b)).
Far below w_r the link is nearly rigid. If the link is made rigid, the gain has an error of
(w/w_r)^2 at the frequency w, and the twist effort/k is neglected. The error at the bandwidth is
computed from the linearised mechanisms before and after the step.
"""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
import numpy as np

from frictool.adapters.mechanism.sources_and_sensors import controlled_names
from frictool.documents.mechanism import Coupling, Gear, Mechanism
from frictool.plant.mechanism.linearisation import linearise
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.connections import Connection, connections, seen_from
from frictool.reduce.rigid_lumping import lump_rigid_links
from frictool.reduce.step_report import StepFigure, StepReport
from frictool.reduce.travel_grid import known_travel

TAKES_PART = 0.05  # share of a mode's strain energy above which a link is part of the mode


@dataclass(frozen=True)
class LinkResonance:
    """Compliant link with its slowest resonance.

    frequency: resonance frequency [rad/s]. If the link takes part in no oscillation, the frequency
        is sqrt(k (1/J_a + 1/J_b)), with the stiffness k and the inertias J_a and J_b on both sides
        of the link.
    damping: damping ratio of the resonance.
    compliance: 1/stiffness [rad/(N m) | m/N].
    twist: deformation of the link under the source's largest effort [rad | m].
    """

    link: Connection
    frequency: float
    damping: float
    compliance: float
    twist: float


def compliant_links(mechanism: Mechanism) -> tuple[Connection, ...]:
    """Return the compliant links between two blocks."""
    return tuple(one for one in connections(assemble_cached(mechanism)) if one.compliant)


def link_resonances(mechanism: Mechanism, root: str) -> tuple[LinkResonance, ...]:
    """Return the resonance of each compliant link, slowest first.

    All blocks must be in the coordinate of one block.
    """
    assembled = assemble_cached(mechanism)
    links = connections(assembled)
    seen = seen_from(assembled.blocks.index(root), links, assembled.blocks)
    modes = linearise(assembled, middle(mechanism)).modes()
    inertia = assembled.packed.inertia
    largest = float(
        np.max(assembled.packed.sources.constant * assembled.packed.sources.limit, initial=0.0)
    )
    resonances = []
    for link in (one for one in links if one.compliant):
        beyond = [k for k, one in seen.items() if link.name in {step.name for step in one.by}]
        far = float(np.sum(inertia[beyond]))
        near = float(np.sum(inertia)) - far
        alone = (
            float(np.sqrt(link.stiffness * (1.0 / near + 1.0 / far)))
            if far > 0.0 and near > 0.0
            else np.inf
        )
        link_modes = [mode for mode in modes if mode.links.get(link.name, 0.0) > TAKES_PART]
        frequency = link_modes[0].frequency if link_modes else alone
        damping = (
            link_modes[0].damping if link_modes else 0.5 * link.damping / link.stiffness * alone
        )
        give = 1.0 / link.stiffness if link.stiffness > 0.0 else 0.0
        resonances.append(
            LinkResonance(
                link, frequency, damping, give, give * largest if np.isfinite(largest) else np.nan
            )
        )
    return tuple(sorted(resonances, key=lambda one: one.frequency))


def stiffen_above(
    mechanism: Mechanism, root: str, bandwidth: float
) -> tuple[Mechanism, StepReport]:
    """Make each link with a resonance above `bandwidth` [rad/s] rigid, and merge its two blocks."""
    resonances = link_resonances(mechanism, root)
    if not resonances:
        return mechanism, StepReport("compliance", "no link is compliant", "nothing")
    dropped = [one for one in resonances if one.frequency > bandwidth]
    reduced = rigid(mechanism, {one.link.name for one in dropped})
    gain, phase = _difference(mechanism, reduced, bandwidth) if dropped else (0.0, 0.0)
    unit = "rad" if assemble_cached(mechanism).kinds[0] == "rotary" else "m"
    effort = "N m" if unit == "rad" else "N"
    figures = [StepFigure("bandwidth", bandwidth, "rad/s")]
    notes = []
    for one in resonances:
        figures += [
            StepFigure(f"{one.link.name}: resonance", one.frequency, "rad/s"),
            StepFigure(f"{one.link.name}: damping ratio", one.damping, ""),
            StepFigure(f"{one.link.name}: compliance", one.compliance, f"{unit}/({effort})"),
            StepFigure(f"{one.link.name}: twist under the largest effort", one.twist, unit),
        ]
        kept = "kept, below" if one not in dropped else "dropped, above"
        notes.append(
            f"{one.link.name}: {one.frequency:.4g} rad/s {kept} "
            f"the bandwidth of {bandwidth:.4g} rad/s"
        )
    if dropped:
        figures += [
            StepFigure("gain error at the bandwidth", gain, ""),
            StepFigure("phase error at the bandwidth", phase, "rad"),
        ]
    names = ", ".join(one.link.name for one in dropped)
    did = f"{names} rigid" if dropped else "every resonance is kept"
    neglects = (
        f"resonances above {bandwidth:.4g} rad/s and the static twist of {names}"
        if dropped
        else "nothing"
    )
    return lump_rigid_links(reduced, root)[0], StepReport(
        "compliance", did, neglects, gain, "the gain at the bandwidth", tuple(figures), tuple(notes)
    )


def rigid(mechanism: Mechanism, names: set[str]) -> Mechanism:
    """Return the mechanism without compliance in the links `names` and in their backlash."""
    links = dict(mechanism.links)
    for name in names:
        link = links[name]
        assert isinstance(link, Coupling | Gear)
        backlash = (
            None
            if link.backlash is None
            else msgspec.structs.replace(link.backlash, compliance=None)
        )
        links[name] = msgspec.structs.replace(link, compliance=None, backlash=backlash)
    return msgspec.structs.replace(mechanism, links=links)


def middle(mechanism: Mechanism) -> np.ndarray:
    """Return the positions (n,) of the blocks in mid-travel; without a travel, at the start."""
    assembled, travel = assemble_cached(mechanism), known_travel(mechanism)
    return (
        assembled.start if travel is None else assembled.start * 0.0 + 0.5 * (travel[0] + travel[1])
    )


def _difference(before: Mechanism, after: Mechanism, bandwidth: float) -> tuple[float, float]:
    source, sensor = controlled_names(before)
    one, other = (
        complex(
            linearise(assemble_cached(each), middle(each))
            .transfer(source, sensor)
            .response(bandwidth)[0, 0, 0]
        )
        for each in (before, after)
    )
    ratio = other / one
    return abs(abs(ratio) - 1.0), float(abs(np.angle(ratio)))
