"""A mechanism made ready for the engine."""

from __future__ import annotations

from frictool.engine.mechanism.advance import ADVANCE, held_command
from frictool.engine.mechanism.field import FIELD, rates_of_state
from frictool.engine.mechanism.image import Machine, image
from frictool.engine.mechanism.settle import MODES, modes_at_instant
from frictool.engine.mechanism.stages import STAGES_OF_STEP, stages_of_step
from frictool.kernels import pointer
from frictool.plant.mechanism.packed import Packed


def prepare(packed: Packed) -> Machine:
    """The machine of a mechanism. ValueError where its joints have no solution, or where a law of friction is not in the table."""
    machine = image(packed)
    machine.laws[-1, 0] = pointer(held_command, ADVANCE).address
    machine.laws[-1, 1] = pointer(rates_of_state, FIELD).address
    machine.laws[-1, 2] = pointer(stages_of_step, STAGES_OF_STEP).address
    machine.laws[-1, 3] = pointer(modes_at_instant, MODES).address
    return machine
