"""An array as a bare pointer to its first element, for loops that hand it from function to
function.

numba counts references to an array wherever one is handed over, inlined or not, with an atomic
addition each time: more than the reading of a digit costs. A pointer is not counted, and its
indices are not looked at for being negative. The caller keeps the array alive.
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


# of a contiguous array (n,); read by index as the array is
pointer_to = cast(Callable[[NDArray[Any]], NDArray[Any]], intrinsic(_first_element))
