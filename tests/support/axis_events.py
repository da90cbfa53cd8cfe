"""Events of an axis by the engine's own slips and rests, in plain Python.

    NUMBA_DISABLE_JIT=1 python -m tests.support.axis_events STEPS.npz COUNTS.npz

The modes between samples do not show every event of an axis with end stops: a rebound may close the
backlash at the same time. STEPS has the parameters `p` (n,), and the `commands` (m,) that are each
held for `period` [s]; COUNTS gets the `states` (m, 7), and the `events` (m, 2) until the end of
each step: all of them, and those at an end stop.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from frictool.engine import axis_motion
from frictool.engine.axis_friction import END_STOP, next_boundary
from frictool.engine.closed_loop import PARTS
from frictool.engine.slip_integration import CONTACT, FAILED, PLACE
from frictool.plant import axis as ax
from frictool.plant.axis import rest
from frictool.typing import Matrix, Vector


def events_of(p: Vector, commands: Vector, period: float) -> tuple[Matrix, Matrix]:
    """The states (m, 7) and the counted events (m, 2) after each command, in another process."""
    with tempfile.TemporaryDirectory() as folder:
        steps, counts = Path(folder, "steps.npz"), Path(folder, "counts.npz")
        np.savez(steps, p=p, commands=commands, period=period)
        subprocess.run(
            [sys.executable, "-m", "tests.support.axis_events", str(steps), str(counts)],
            env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
            check=True,
        )
        with np.load(counts) as found:
            return found["states"], found["events"]


def advance(state: Vector, command: float, p: Vector, duration: float) -> np.ndarray[Any, Any]:
    """Advance the state as `axis_motion.advance` does; return the numbers of events (2,)."""
    command = min(max(command, -p[ax.DRIVE_LIMIT]), p[ax.DRIVE_LIMIT])
    if p[ax.RESISTANCE] > 0.0:
        low, high = axis_motion.drive_range(p, state[ax.VELOCITY])
        command = min(max(command, low), high)
        state[ax.DRIVE] = min(max(state[ax.DRIVE], low), high)
    if p[ax.LAG] == 0.0:
        state[ax.DRIVE] = command
    direction = float(np.sign(state[ax.VELOCITY]))
    remaining, refused, events = duration, 0.0, np.zeros(2, int)
    while True:
        if direction == 0.0:
            spent, direction = axis_motion._rest(state, command, p, p, remaining, refused)
            state[ax.RESTED] += spent
        else:
            begins = state[ax.VELOCITY] == 0.0
            attempted = direction if begins else 0.0
            _, ahead = next_boundary(p, state[ax.POSITION], direction)
            spent, direction, kind = axis_motion._slip(
                state, command, p, p, p, direction, remaining
            )
            assert kind != FAILED
            refused = attempted if spent == 0.0 else 0.0
            if refused == 0.0:
                hits = kind == PLACE and ahead == END_STOP
                events += (int(begins) + (kind == CONTACT) + hits + (direction == 0.0), hits)
            if direction == 0.0 and spent > 0.0:
                state[ax.RESTED] = 0.0
        remaining -= spent
        if remaining <= 0.0:
            driving = direction * state[ax.GAP] >= 0.5 * p[ax.BACKLASH]
            state[ax.MODE] = direction * (ax.SLIPPING if driving else ax.LOOSE)
            return events


def main(steps: str, counts: str) -> None:
    with np.load(steps) as read:
        p, commands, period = read["p"], read["commands"], float(read["period"])
    state, total = rest(), np.zeros(2, int)
    parts = PARTS if p[ax.RESISTANCE] > 0.0 else 1
    states: list[Any] = []
    events: list[Any] = []
    for command in commands.tolist():
        for _ in range(parts):
            total += advance(state, command, p, period / parts)
        states.append(state.copy())
        events.append(total.copy())
    np.savez(counts, states=np.array(states), events=np.array(events))


if __name__ == "__main__":
    main(*sys.argv[1:])
