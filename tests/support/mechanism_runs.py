"""Runs of packed mechanisms from rest or a given state."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.open_loop_run import MechanismRun, run
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import MechanismState, rest
from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder


def ready(
    b: Builder, start: ArrayLike | None = None, speeds: ArrayLike | None = None
) -> tuple[CompiledMechanism, MechanismState]:
    """A machine and its state at `start`, with `speeds`."""
    packed = b.packed()
    machine = prepare(packed)
    state = rest(packed, machine, np.zeros(len(b.inertia)) if start is None else start)
    if speeds is not None:
        state.y[len(b.inertia) : 2 * len(b.inertia)] = speeds
    return machine, state


def moved(
    b: Builder, commands: ArrayLike, period: float = 1e-3, **more: Any
) -> tuple[MechanismRun, CompiledMechanism, MechanismState]:
    """A run from rest; more: start, speeds, and what `run` takes."""
    machine, state = ready(b, more.pop("start", None), more.pop("speeds", None))
    result = run(machine, state, commands, period, **more)
    assert result.status == 0, f"status {result.status} at {result.reached} s"
    return result, machine, state


def instants(result: MechanismRun, kind: int, element: int) -> Vector:
    """Return the times of an event."""
    chosen = (result.events[:, 1] == kind) & (result.events[:, 2] == element)
    return np.asarray(result.events[chosen, 0])
