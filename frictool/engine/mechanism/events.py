"""What happens to a mechanism, as rows (time [s], kind, element's place, speed before [rad/s | m/s])."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.image import BLOCKS, COUPLINGS, GROUP, JOINTS, STOPS
from frictool.engine.mechanism.state import OPEN, STUCK
from frictool.kernels import inset_kernel

Vector = NDArray[np.float64]
Places = NDArray[np.int64]

(
    STICKS,
    BREAKS_AWAY,
    REVERSES,
    TOUCHES,
    SEPARATES,
    POWER_TURNS,
    FLANK_MEETS,
    FLANK_LETS_GO,
    STRIKES,
    LEAVES_STOP,
    JAMS,
) = range(11)
NAMES = (
    "sticks",
    "breaks away",
    "reverses",
    "touches",
    "separates",
    "power turns",
    "flank meets",
    "flank lets go",
    "strikes end stop",
    "leaves end stop",
    "jams",
)
ELEMENTS = ("block", "block", "block", "joint", "joint", "joint", "coupling", "coupling", "stop", "stop", "block")
EVENT_SIZE = 4


@inset_kernel
def write(events: Vector, happened: Places, t: float, kind: int, element: int, speed: float) -> None:
    """Adds a row; where there is no room, happened[0] goes on counting."""
    row = happened[0]
    if row < events.shape[0]:
        events[row, 0], events[row, 1], events[row, 2], events[row, 3] = t, kind, element, speed
    happened[0] = row + 1


@inset_kernel
def write_changes(k: Places, t: float, speeds: Vector, before: Places, modes: Places, events: Vector, happened: Places) -> None:
    """Adds a row for each mode that has changed; of a group of rigidly joined blocks, for its first block. speeds (n,): before."""
    n, j, c = k[BLOCKS], k[JOINTS], k[COUPLINGS]
    for i in range(n):
        if before[i] != modes[i] and k[k[GROUP] + i] == i:
            kind = STICKS if modes[i] == STUCK else BREAKS_AWAY if before[i] == STUCK else REVERSES
            write(events, happened, t, kind, i, speeds[i])
    for joint in range(j):
        was, now = before[n + joint], modes[n + joint]
        if was != now and was != OPEN:
            write(events, happened, t, SEPARATES, joint, 0.0)
        if was != now and now != OPEN:
            write(events, happened, t, TOUCHES, joint, 0.0)
        if before[n + j + joint] != modes[n + j + joint]:
            write(events, happened, t, POWER_TURNS, joint, 0.0)
    for i in range(c):
        was, now = before[n + 2 * j + i], modes[n + 2 * j + i]
        if was != now:
            write(events, happened, t, FLANK_LETS_GO if now == OPEN else FLANK_MEETS, i, 0.0)
    for s in range(k[STOPS]):
        was, now = before[n + 2 * j + c + s], modes[n + 2 * j + c + s]
        if was != OPEN and now == OPEN:
            write(events, happened, t, LEAVES_STOP, s, 0.0)
