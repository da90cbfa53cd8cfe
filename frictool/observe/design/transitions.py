"""Which mode may follow which from one sample to the next: figure 6.3.

Modes 1..n hold for a positive motion in the intervals of rising position, -1..-n for a negative one
in those of its own, 0 where it is stuck. Moving forward, mode i lasts, goes to i + 1, or gets
stuck; moving backward the rules are mirrored: -i lasts, goes to the interval below it, or gets
stuck. From 0 any mode may follow. So a motion that turns passes 0.

That a motion turns without passing 0, again and again, has no gains (6.6): a wrong alpha shows in
the position two samples later, and where the direction has changed by then alpha is corrected the
wrong way. With the gains for figure 6.3 the error grows by 1 % a sample along (1, 1, -1, -1, ...),
the clutch's modes.
"""

from __future__ import annotations

from itertools import product

from frictool.observe.design.settings import Transitions

Switch = tuple[int, int]


def switches(forward: int, backward: int, allowed: Transitions) -> tuple[Switch, ...]:
    """The pairs (mode at a sample, mode at the next) for `forward` and `backward` intervals, in
    order."""
    modes = [*range(-backward, 0), 0, *range(1, forward + 1)]
    pairs = {(i, i) for i in modes} | {(i, 0) for i in modes} | {(0, i) for i in modes}
    if allowed == "direction":
        return tuple(sorted(pairs | {(i, j) for i, j in product(modes, modes) if i * j > 0}))
    pairs |= {(i, i + 1) for i in range(1, forward)}
    pairs |= {(-i, -(i - 1)) for i in range(2, backward + 1)}
    return tuple(sorted(pairs))
