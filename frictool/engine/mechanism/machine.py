"""A mechanism made ready for the engine."""

from __future__ import annotations

from frictool.engine.mechanism.advance import ADVANCE, held_command
from frictool.engine.mechanism.field import FIELD, rates_of_state
from frictool.engine.mechanism.image import Machine, image
from frictool.kernels import pointer
from frictool.plant.mechanism.packed import Packed


def prepare(packed: Packed) -> Machine:
    """The machine of a mechanism. ValueError where its joints have no solution, or where a law of friction is not in the table."""
    machine = image(packed)
    machine.laws[-1, 0] = pointer(held_command, ADVANCE).address
    machine.laws[-1, 1] = pointer(rates_of_state, FIELD).address
    return machine
