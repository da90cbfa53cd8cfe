"""Additive observer: friction has grown by alpha [N m | N] everywhere (thesis 6.20 to 6.26).

    X^+     = A_i X^ + B_i (u - s (f^(y) + alpha)) + L_X (y - C X^)
    alpha^+ = alpha + L_alpha (y - C X^)            s: direction of motion

X is the vector of position and speed, y the measured position, u the effort, and f^ the friction
map. ^ marks an estimate, + the value at the next sample; L_X and L_alpha are the gains.
mode_matrices.py defines A_i, B_i and C. A positive alpha increases friction in both directions, as
in thesis (6.25); in thesis (6.22), alpha has the opposite sign.
"""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.documents.observer import Mode, Observer
from frictool.documents.provenance import Provenance
from frictool.observe.design.friction_map import friction_map
from frictool.observe.design.mode_transitions import switches
from frictool.observe.design.switched import design_switched, facts_of
from frictool.observe.design.switched_settings import SwitchedObserverSettings


def design(model: Model, settings: SwitchedObserverSettings, provenance: Provenance) -> Observer:
    """Design the observer, with verified gains for the three modes (backward, stuck, forward).

    Raises NoSolutionError if the inequalities have no solution or the gains fail verification.
    """
    friction = friction_map(model)
    modes = [Mode(-1, -1, (), 0.0), Mode(0, 0, (), 0.0), Mode(1, 1, (), 0.0)]
    facts = facts_of(model, settings, friction, "additive")
    return design_switched(
        model, settings, provenance, facts, friction, modes, switches(1, 1, settings.transitions)
    )
