"""Types of the kernels of each kind of law, for drivers that take kernels as arguments.

A driver is a compiled loop that calls the kernels of a law. A driver that takes function pointers,
such as `kernels.pointer(kernel, SLIP_FORCE)`, is compiled once, is cached on disk, and runs every
law of the kind. A driver that takes the kernels themselves is compiled again for every law in every
process. Never pass a kernel itself to a driver declared with these types: numba would cache the
driver under the key for pointers, and a later call with a pointer would fail.
"""

from __future__ import annotations

from typing import Any

from numba import types

_f: Any = types.float64
_a: Any = types.float64[::1]
_i: Any = types.int64


def _function(result: Any, *arguments: Any) -> Any:
    return types.FunctionType(result(*arguments))


# static
SLIP_FORCE = _function(_f, _f, _f, _a)
BREAKAWAY = SEEN_VELOCITY = _function(_f, _f, _a)
BAND = _function(_f, _a)
# dynamic
RATE = _function(_i, _a, _f, _a, _a)
FORCE = _function(_f, _a, _a, _f, _a)
COMMIT = _function(_i, _a, _f, _a)
RESET = _function(_a, _a)
# hybrid
MODE_AFTER = ENTER = _function(_i, _i, _f, _f, _a, _a)
HYBRID_FORCE = HYBRID_ACCELERATION = _function(_f, _i, _f, _f, _a, _a)
HYBRID_RATE = _function(_i, _i, _f, _a, _a, _a)
HYBRID_COMMIT = _function(_i, _i, _a, _a)
