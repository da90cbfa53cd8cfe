"""What dynamic laws share: a scalar presliding z that starts at 0, and no memory beside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.friction.status import OK
from frictool.runtime.kernels import kernel

Vector = NDArray[np.float64]


@kernel
def scalar_reset(p: Vector) -> Vector:
    """State z (1,) of a body that never moved [m | rad]."""
    return np.zeros(1)


@kernel
def no_memory(z: Vector, v: float, p: Vector) -> int:
    """`commit` of a law whose state is all in z. Returns friction/status.py."""
    return OK
