"""Calls of kernels by address, through wrappers generated from the kernels' types.

A kernel is a compiled function. The engine calls friction laws by address and is therefore compiled
once for all laws. An address is valid in one process only.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, Signature
from typing import Any, cast

from numba import types
from numba.extending import intrinsic

FLOAT: Any = types.float64
INTEGER: Any = types.int64
VECTOR: Any = types.float64[::1]
MATRIX: Any = types.float64[:, ::1]
INDICES: Any = types.int64[::1]
INDEX_ROWS: Any = types.int64[:, ::1]


def record_type(record: type, *fields: Any) -> Any:
    """Return the numba type of a NamedTuple class whose fields have the numba types `fields`."""
    return types.BaseTuple.from_types(fields, record)  # type: ignore[no-untyped-call]  # numba has no types


def function_type(result: Any, *arguments: Any) -> Any:
    """Return the numba type of a kernel from the types of its result and arguments."""
    return types.FunctionType(result(*arguments))


def call_by_address(kind: Any) -> Callable[..., Any]:
    """Return a numba function f(address, *arguments) that calls a kernel of the type `kind`."""
    called = kind.signature

    def code(context: Any, builder: Any, _: Any, arguments: Any) -> Any:
        function = builder.inttoptr(arguments[0], context.get_value_type(kind.ftype))
        return builder.call(function, arguments[1:])

    def call(*_: Any) -> Any:
        return called.return_type(types.int64, *called.args), code

    names = ["context", "address", *(f"argument_{index}" for index in range(len(called.args)))]
    cast(Any, call).__signature__ = Signature(
        [Parameter(name, Parameter.POSITIONAL_OR_KEYWORD) for name in names]
    )
    return cast(Callable[..., Any], intrinsic(call))
