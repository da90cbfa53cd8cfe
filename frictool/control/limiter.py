"""The limit of the drive, the same in both directions."""

from __future__ import annotations

from frictool.kernels import kernel


@kernel
def limit(drive: float, bound: float) -> tuple[float, float]:
    """The drive within +-bound [A | V], and which limit it met: -1, 0 or +1."""
    if drive > bound:
        return bound, 1.0
    if drive < -bound:
        return -bound, -1.0
    return drive, 0.0
