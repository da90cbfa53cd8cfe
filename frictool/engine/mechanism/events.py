"""Events of a mechanism, as rows (time [s], kind, element index, speed before [rad/s | m/s])."""

from __future__ import annotations

from typing import NamedTuple

from frictool.engine.mechanism import array_layout as ly
from frictool.engine.mechanism.address_calls import INDICES, MATRIX, record_type
from frictool.engine.mechanism.array_layout import CompiledMechanism
from frictool.engine.mechanism.joint_losses import is_lossy
from frictool.engine.mechanism.state import OPEN, STUCK
from frictool.runtime.kernels import bare_kernel, part_kernel
from frictool.typing import IntVector, Vector

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
ELEMENTS = (
    "block",
    "block",
    "block",
    "joint",
    "joint",
    "joint",
    "coupling",
    "coupling",
    "stop",
    "stop",
    "block",
)
EVENT_SIZE = 4


class EventRows(NamedTuple):
    """Array of events, and the number of events."""

    rows: Vector  # (m, EVENT_SIZE)
    happened: IntVector  # (1,): number of all events, including those that `rows` cannot store


EVENTS = record_type(EventRows, MATRIX, INDICES)


@bare_kernel
def write(events: EventRows, t: float, kind: int, element: int, speed: float) -> None:
    """Write an event to the next row; if the array is full, only increase the count."""
    row = events.happened[0]
    if row < events.rows.shape[0]:
        events.rows[row, 0] = t
        events.rows[row, 1] = kind
        events.rows[row, 2] = element
        events.rows[row, 3] = speed
    events.happened[0] = row + 1


@part_kernel
def write_changes(
    machine: CompiledMechanism,
    t: float,
    speeds: Vector,
    before: IntVector,
    modes: IntVector,
    events: EventRows,
) -> None:
    """Write an event for each changed mode; a rigid group of blocks has one event.

    - before: modes before the event
    - speeds (n,): speeds before the event

    A change of a joint's branch (side of the kink of its loss) is written only if the joint has
    losses.
    """
    k, p, _ = machine
    n, j, c = k[ly.BLOCKS], k[ly.JOINTS], k[ly.COUPLINGS]
    for i in range(n):
        if before[i] != modes[i] and ly.group_of(k, i) == i:
            kind = STICKS if modes[i] == STUCK else BREAKS_AWAY if before[i] == STUCK else REVERSES
            write(events, t, kind, i, speeds[i])
    for joint in range(j):
        was, now = before[n + joint], modes[n + joint]
        if was != now and was != OPEN:
            write(events, t, SEPARATES, joint, 0.0)
        if was != now and now != OPEN:
            write(events, t, TOUCHES, joint, 0.0)
        if (
            before[n + j + joint] not in (0, modes[n + j + joint])
            and modes[n + j + joint] != 0
            and is_lossy(p, ly.joint_row(k, joint))
        ):
            write(events, t, POWER_TURNS, joint, 0.0)
    for i in range(c):
        was, now = before[n + 2 * j + i], modes[n + 2 * j + i]
        if was != now:
            write(events, t, FLANK_LETS_GO if now == OPEN else FLANK_MEETS, i, 0.0)
    for s in range(k[ly.STOPS]):
        was, now = before[n + 2 * j + c + s], modes[n + 2 * j + c + s]
        if was != OPEN and now == OPEN:
            write(events, t, LEAVES_STOP, s, 0.0)
