"""Pointer to the first element of an array, for compiled loops that pass the array to functions.

If an array is passed, numba counts the references to the array with an atomic addition in every
call, even if the called function is inlined. This addition takes longer than reading a digit.
References to a pointer are not counted, and indices are not checked for negative values. The caller
has to keep the array alive.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray


def _first_element(context: Any, array: Any) -> Any:
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.make_array(array)(context, builder, arguments[0]).data

    return types.CPointer(array.dtype)(array), code  # type: ignore[no-untyped-call]  # numba has no types


# pointer to a contiguous array (n,); elements are read by index
pointer_to = cast(Callable[[NDArray[Any]], NDArray[Any]], intrinsic(_first_element))
