"""Preparation of a mechanism for the engine."""

from __future__ import annotations

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.articulated_body import RATES_OF_STATE, rates_of_state
from frictool.engine.mechanism.compiled_mechanism import compile_mechanism
from frictool.engine.mechanism.event_driven_motion import HELD_COMMAND, held_command
from frictool.engine.mechanism.integration_step import STAGES_OF_STEP, stages_of_step
from frictool.engine.mechanism.mode_iteration import MODES_AT_INSTANT, modes_at_instant
from frictool.engine.mechanism.stiff_step import ROSENBROCK_STEP, rosenbrock_step
from frictool.plant.mechanism.packed_mechanism import PackedMechanism
from frictool.runtime.kernels import function_pointer


def prepare(packed: PackedMechanism) -> CompiledMechanism:
    """Return the compiled mechanism, with the addresses of the engine's kernels.

    Raises the errors of `compile_mechanism`.
    """
    machine = compile_mechanism(packed)
    for column, compiled, kind in (
        (ly.ADVANCE, held_command, HELD_COMMAND),
        (ly.FIELD, rates_of_state, RATES_OF_STATE),
        (ly.STEP_STAGES, stages_of_step, STAGES_OF_STEP),
        (ly.SETTLE, modes_at_instant, MODES_AT_INSTANT),
    ):
        machine.laws[-1, column] = function_pointer(compiled, kind).address
    if machine.whole[ly.STIFF] > 0:  # compiled only for a mechanism that needs it
        address = function_pointer(rosenbrock_step, ROSENBROCK_STEP).address
        machine.laws[-1, ly.STIFF_STEP] = address
    return machine
