"""Allowed switches of modes from one sample to the next: figure 6.3.

Modes 1..n are for positive motion, in the intervals of rising position; modes -1..-n are for
negative motion, in the intervals of that direction; mode 0 is for a stuck axis. In forward motion,
mode i stays, goes to i + 1, or to 0. In backward motion, mode -i stays, goes to the interval below
it, or to 0. Any mode may follow mode 0. A motion that reverses therefore passes mode 0.

If repeated turns without mode 0 were allowed, (6.6) would have no gains. A wrong alpha shows in the
position two samples later; if the direction has changed by then, the correction of alpha has the
wrong sign. With the gains for figure 6.3, the error of the clutch's modes grows by 1 % a sample
along (1, 1, -1, -1, ...).
"""

from __future__ import annotations

from itertools import product

from frictool.observe.design.switched_settings import Transitions

Switch = tuple[int, int]


def switches(forward: int, backward: int, allowed: Transitions) -> tuple[Switch, ...]:
    """Return the sorted pairs (mode, mode at the next sample) for these numbers of intervals."""
    modes = [*range(-backward, 0), 0, *range(1, forward + 1)]
    pairs = {(i, i) for i in modes} | {(i, 0) for i in modes} | {(0, i) for i in modes}
    if allowed == "direction":
        return tuple(sorted(pairs | {(i, j) for i, j in product(modes, modes) if i * j > 0}))
    pairs |= {(i, i + 1) for i in range(1, forward)}
    pairs |= {(-i, -(i - 1)) for i in range(2, backward + 1)}
    return tuple(sorted(pairs))
