"""Simulation of a mechanism under a sequence of constant commands, with a record at each sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.event_driven_motion import TOLERANCE, advance
from frictool.engine.mechanism.events import EVENT_SIZE, EventRows
from frictool.engine.mechanism.state import MechanismState, counts
from frictool.engine.status_codes import OK
from frictool.runtime.kernels import kernel
from frictool.typing import Vector

MOST_EVENTS = 100_000


@dataclass(frozen=True)
class MechanismRun:
    """Result of a run at the `times` (m,); the first sample is the initial state.

    - status: code of engine/status_codes.py
    - events: rows of engine/mechanism/events.py
    - happened: number of all events, including those for which `events` has no row

    Values after `reached` [s] are NaN.
    """

    status: int
    reached: float
    times: Vector  # (m,) s
    positions: Vector  # (n, m) rad | m, of the n blocks
    speeds: Vector  # (n, m) rad/s | m/s
    drives: Vector  # (u, m) A | V | N m | N, of the u sources
    events: Vector
    happened: int


@kernel
def _run(
    machine: CompiledMechanism,
    state: MechanismState,
    commands: Vector,
    external: Vector,
    period: float,
    tolerance: float,
    event_rows: EventRows,
    positions: Vector,
    speeds: Vector,
    drives: Vector,
) -> tuple[int, int]:
    n = positions.shape[0]
    for sample in range(commands.shape[0] + 1):
        for i in range(n):
            positions[i, sample] = state.y[i]
            speeds[i, sample] = state.y[n + i]
        for s in range(state.drive.shape[0]):
            drives[s, sample] = state.drive[s]
        if sample == commands.shape[0]:
            break
        held = external[min(sample, external.shape[0] - 1)]
        status = advance(machine, state, commands[sample], held, period, tolerance, event_rows)
        if status != OK:
            return status, sample
    return OK, commands.shape[0]


def run(
    machine: CompiledMechanism,
    state: MechanismState,
    commands: ArrayLike,
    period: float,
    external: ArrayLike | None = None,
    *,
    tolerance: float = TOLERANCE,
    most_events: int = MOST_EVENTS,
) -> MechanismRun:
    """Simulate a mechanism from `state` under a sequence of constant commands.

    Parameters
    ----------
    machine
        The compiled mechanism.
    state
        State at the beginning, changed in place.
    commands
        (m, u) commands of the sources [A | V | N m | N].
    period
        Time for which each command acts [s].
    external
        Efforts on blocks [N m | N], (m, n), or (1, n) if they are constant; 0 by default.
    tolerance
        Relative tolerance of speeds.
    most_events
        Largest number of events to return.

    Returns
    -------
    MechanismRun
        Samples and events.

    Raises
    ------
    ValueError
        If the shape of `commands` or `external` is wrong.
    """
    c = counts(machine)
    rows = np.ascontiguousarray(commands, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != c["sources"]:
        raise ValueError(
            f"commands have shape {rows.shape}; allowed: (samples, {c['sources']}), "
            "a column for each source"
        )
    held = (
        np.zeros((1, c["blocks"]))
        if external is None
        else np.ascontiguousarray(external, dtype=np.float64)
    )
    if held.ndim != 2 or held.shape[1] != c["blocks"] or held.shape[0] not in (1, rows.shape[0]):
        raise ValueError(
            f"external has shape {held.shape}; allowed: ({rows.shape[0]} or 1, {c['blocks']}), "
            "a column for each block"
        )
    m = rows.shape[0] + 1
    positions, speeds = np.full((c["blocks"], m), np.nan), np.full((c["blocks"], m), np.nan)
    drives = np.full((c["sources"], m), np.nan)
    events = np.zeros((most_events, EVENT_SIZE))
    happened = np.zeros(1, dtype=np.int64)
    start = float(state.pace[1])
    runner: Any = _run
    status, _ = runner(
        machine,
        state,
        rows,
        held,
        period,
        tolerance,
        EventRows(events, happened),
        positions,
        speeds,
        drives,
    )
    seen = min(int(happened[0]), most_events)
    times = start + period * np.arange(m)
    return MechanismRun(
        status,
        float(state.pace[1]),
        times,
        positions,
        speeds,
        drives,
        events[:seen].copy(),
        int(happened[0]),
    )
