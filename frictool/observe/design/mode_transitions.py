"""Allowed switches of modes from one sample to the next (thesis, figure 6.3).

Modes 1 to n are for forward motion in the position intervals 1 to n. Modes -1 to -n are for
backward motion in the intervals of that direction. Mode 0 is for a stuck axis. In forward motion,
mode i may stay, or switch to i + 1 or 0. In backward motion, mode -i may stay, or switch to the
next lower interval or 0. From mode 0 every mode is allowed. A motion that reverses therefore passes
mode 0.

If repeated reversals without mode 0 were allowed, the inequalities of the design would have no
solution (docs/theory/observers.md).
"""

from __future__ import annotations

from itertools import product

from frictool.observe.design.switched_settings import Transitions

Switch = tuple[int, int]


def switches(forward: int, backward: int, allowed: Transitions) -> tuple[Switch, ...]:
    """Return the sorted pairs (mode, mode at the next sample).

    forward, backward: number of intervals of each direction. allowed: `neighbours`: from an
    interval, the axis may switch to the next interval in the direction of motion; `direction`: to
    any interval of the same direction.
    """
    modes = [*range(-backward, 0), 0, *range(1, forward + 1)]
    pairs = {(i, i) for i in modes} | {(i, 0) for i in modes} | {(0, i) for i in modes}
    if allowed == "direction":
        return tuple(sorted(pairs | {(i, j) for i, j in product(modes, modes) if i * j > 0}))
    pairs |= {(i, i + 1) for i in range(1, forward)}
    pairs |= {(-i, -(i - 1)) for i in range(2, backward + 1)}
    return tuple(sorted(pairs))
