"""Preparation of a mechanism for the engine."""

from __future__ import annotations

from frictool.engine.mechanism.advance import ADVANCE, held_command
from frictool.engine.mechanism.articulated_body import FIELD, rates_of_state
from frictool.engine.mechanism.compiled_mechanism import CompiledMechanism, compile_mechanism
from frictool.engine.mechanism.mode_iteration import MODES, modes_at_instant
from frictool.engine.mechanism.step_stages import STAGES_OF_STEP, stages_of_step
from frictool.plant.mechanism.packed_mechanism import PackedMechanism
from frictool.runtime.kernels import function_pointer


def prepare(packed: PackedMechanism) -> CompiledMechanism:
    """Return the compiled mechanism with the addresses of the engine's own kernels.

    Raises ValueError if its joints have no solution, or a friction law is not in the registry.
    """
    machine = compile_mechanism(packed)
    machine.laws[-1, 0] = function_pointer(held_command, ADVANCE).address
    machine.laws[-1, 1] = function_pointer(rates_of_state, FIELD).address
    machine.laws[-1, 2] = function_pointer(stages_of_step, STAGES_OF_STEP).address
    machine.laws[-1, 3] = function_pointer(modes_at_instant, MODES).address
    return machine
