"""Allowed transitions between modes from one sample to the next (thesis, figure 6.3).

Mode i > 0 is forward motion in position interval i, mode -i is backward motion in interval i of the
backward direction, and mode 0 is a stuck axis. From a moving mode, three transitions are allowed:
to the same mode, to mode 0, and to the next interval in the direction of motion. The setting
`direction` allows any interval of this direction, not only the next. From mode 0, every mode is
allowed. A motion that reverses therefore passes mode 0.

If repeated reversals without mode 0 were allowed, the inequalities of the design would have no
solution (docs/theory/observers.md).
"""

from __future__ import annotations

from itertools import product

from frictool.observe.design.switched_settings import Transitions

Switch = tuple[int, int]


def switches(forward: int, backward: int, allowed: Transitions) -> tuple[Switch, ...]:
    """Return the allowed transitions as sorted pairs (mode, mode at the next sample).

    - forward, backward: number of position intervals of each direction
    - allowed: `neighbours` if a moving mode may change to the next interval in the direction of
      motion only; `direction` if it may change to any interval of this direction
    """
    modes = [*range(-backward, 0), 0, *range(1, forward + 1)]
    pairs = {(i, i) for i in modes} | {(i, 0) for i in modes} | {(0, i) for i in modes}
    if allowed == "direction":
        return tuple(sorted(pairs | {(i, j) for i, j in product(modes, modes) if i * j > 0}))
    pairs |= {(i, i + 1) for i in range(1, forward)}
    pairs |= {(-i, -(i - 1)) for i in range(2, backward + 1)}
    return tuple(sorted(pairs))
