"""The engine of the axis as a function pointer.

If a kernel calls `advance` directly, numba compiles the whole engine again, in two seconds. A
kernel with a pointer to `advance` as its argument compiles in a fraction of this time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba import types

from frictool.engine.axis_motion import advance
from frictool.runtime.kernels import function_pointer
from frictool.typing import Vector

Advance = Callable[[Vector, float, Vector, float], int]  # arguments of engine/axis_motion.py
_float: Any = types.float64
ADVANCE: Any = types.FunctionType(types.int64(_float[::1], _float, _float[::1], _float))


def advance_pointer() -> Advance:
    """Return `advance` for a kernel that takes it as an argument."""
    return cast(Advance, function_pointer(advance, ADVANCE))
