"""Multiplicative observer: friction has grown by a factor alpha (thesis 6.13 to 6.19)."""

from __future__ import annotations

import msgspec

from frictool.documents.model import Model
from frictool.documents.observer import Mode, Observer
from frictool.documents.provenance import Provenance
from frictool.observe.design.design_notes import UNIT_DEVIATION
from frictool.observe.design.friction_map import friction_map
from frictool.observe.design.mode_transitions import switches
from frictool.observe.design.position_intervals import intervals
from frictool.observe.design.switched import design_switched, facts_of
from frictool.observe.design.switched_settings import SwitchedObserverSettings


def design(model: Model, settings: SwitchedObserverSettings, provenance: Provenance) -> Observer:
    """Design the observer, with verified gains for each position interval and direction.

    Raises NoSolutionError if there are too few intervals, if the inequalities have no solution, or
    if the gains fail verification.
    """
    friction = friction_map(model)
    forward, backward = (
        intervals(friction, direction, settings.intervals) for direction in (1, -1)
    )
    modes = [
        *(
            Mode(-i, -1, (), 0.0, (one.low, one.high), one.friction, one.deviation)
            for i, one in reversed(list(enumerate(backward, 1)))
        ),
        Mode(0, 0, (), 0.0),
        *(
            Mode(i, 1, (), 0.0, (one.low, one.high), one.friction, one.deviation)
            for i, one in enumerate(forward, 1)
        ),
    ]
    if not any(mode.deviation for mode in modes):
        modes = [
            msgspec.structs.replace(mode, deviation=UNIT_DEVIATION * mode.friction)
            for mode in modes
        ]
    facts = facts_of(model, settings, friction, "multiplicative")
    return design_switched(
        model,
        settings,
        provenance,
        facts,
        friction,
        modes,
        switches(len(forward), len(backward), settings.transitions),
    )
