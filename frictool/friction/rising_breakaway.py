"""Rising static friction: the breakaway grows with the time at rest (thesis 2.3.2.1, 3.4.2.3).

    F_s(t) = F_s (1 - (1 - fresh) tau/(tau + t))

t is the time at rest, and tau the rise time. The breakaway is a fraction `fresh` of F_s just after
a stop, and F_s after a long rest. The thesis does not specify the function F_s(t); this is the
hyperbola of Armstrong's seven-parameter law (reference [1] of the thesis).
"""

from __future__ import annotations

from frictool.runtime.kernels import kernel


@kernel
def dwell_factor(dwell: float, fresh: float, rise_time: float) -> float:
    """Return the factor, `fresh` to 1, of the breakaway F_s after `dwell` [s] at rest.

    `fresh` is the factor just after a stop. The factor is 1 if rise_time [s] is 0.
    """
    return 1.0 - (1.0 - fresh) * rise_time / (rise_time + dwell) if rise_time > 0.0 else 1.0
