"""Kernels that several dynamic laws share: the initial state, and a `commit` that does nothing."""

from __future__ import annotations

import numpy as np

from frictool.friction.status_codes import OK
from frictool.runtime.kernels import kernel
from frictool.typing import Vector


@kernel
def scalar_reset(p: Vector) -> Vector:
    """Return the state z (1,) [m | rad] of a body that has never moved."""
    return np.zeros(1)


@kernel
def no_memory(z: Vector, v: float, p: Vector) -> int:
    """Return the status OK: `commit` of a law without memory has nothing to store."""
    return OK
