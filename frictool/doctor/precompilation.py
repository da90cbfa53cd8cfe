"""Compilation of all kernels before their first use, for the types in `kernels.json`.

The file `kernels.json` lists the argument types of all kernel calls in the tests. The types of
other kernels of friction laws follow from the kind of law. The command `python -m
frictool.doctor.precompilation` prints the kernels that are now in the cache, in the format of
`kernels.json`.
"""

from __future__ import annotations

import importlib
import json
import pickle
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numba.core import event, types
from numba.core.errors import NumbaError

from frictool.friction.law_registry import ROWS
from frictool.friction.law_signatures import SIGNATURES
from frictool.runtime import kernel_folders, kernels
from frictool.runtime.kernel_sources import PACKAGE, Sources
from frictool.runtime.machine_code_store import LINKED, KernelStore

LIST = Path(__file__).with_name("kernels.json")


@dataclass
class Compilation:
    """Result of a compilation of many kernels.

    prepared: number of pairs (kernel, argument types).
    compiled: number of these pairs that had to be compiled because the cache lacked them.
    failures: messages of failed compilations.
    """

    prepared: int = 0
    compiled: int = 0
    failures: list[str] = field(default_factory=list)


class _Count(event.Listener):
    def __init__(self) -> None:
        self.count = 0

    def on_start(self, event: Any) -> None:
        self.count += isinstance(event.data["dispatcher"]._cache, KernelStore)

    def on_end(self, event: Any) -> None:
        """Do nothing; compilations are counted when they start."""


def compile_all(
    progress: Callable[[float], None], rows: list[list[Any]] | None = None
) -> Compilation:
    """Compile and store every kernel in `rows`; None compiles all kernels.

    A row is (module, name, kind, types). `progress` is called with the completed fraction, 0 to 1.
    """
    rows = all_rows() if rows is None else rows
    done, count = Compilation(), _Count()
    with event.install_listener("numba:compile", count):
        for index, row in enumerate(rows):
            try:
                _compile(*row)
                done.prepared += 1
            except (ImportError, AttributeError, TypeError, NumbaError) as error:
                done.failures.append(f"{row[0]}.{row[1]}: {' '.join(str(error).split())[:200]}")
            progress((index + 1) / len(rows))
    done.compiled = count.count
    return done


def all_rows() -> list[list[Any]]:
    """Return the rows of `kernels.json`, and rows for friction-law kernels that this file lacks."""
    listed: list[list[Any]] = json.loads(LIST.read_bytes())
    known = {(module, name) for module, name, *_ in listed}
    added = []
    for law in ROWS:
        for kernel, signature in zip(law.kernels, SIGNATURES[type(law.kernels)], strict=True):
            module, name = kernel.__module__, kernel.__name__
            if (module, name) not in known:
                _, result, arguments = encode(signature)
                added.append([module, name, "pointer", [result, arguments]])
                added.append([module, name, "kernel", arguments])
    return added + listed


def _compile(module: str, name: str, kind: str, encoded: list[Any]) -> None:
    kernel = getattr(importlib.import_module(module), name)
    if kind == "pointer":
        kernels.function_pointer(kernel, decode(["function", *encoded]))
    else:
        kernel.compile(tuple(decode(one) for one in encoded))


def encode(kind: Any) -> Any:
    """Return a numba type as JSON values; `decode` is the inverse.

    Raises ValueError for a type that Python cannot pass to a kernel, such as a literal.
    """
    if isinstance(kind, types.Array):
        return ["array", str(kind.dtype), kind.ndim, kind.layout, kind.mutable]
    if isinstance(kind, types.FunctionType):
        return [
            "function",
            encode(kind.signature.return_type),
            [encode(one) for one in kind.signature.args],
        ]
    if isinstance(kind, types.BaseTuple):
        cls = getattr(kind, "instance_class", tuple)
        parts = list(getattr(kind, "types", None) or _uniform(kind))
        return ["tuple", f"{cls.__module__}:{cls.__qualname__}", [encode(one) for one in parts]]
    if isinstance(kind, types.Omitted):
        return ["omitted", kind.value]
    if isinstance(
        kind, (types.Float, types.Integer, types.Boolean, types.NoneType)
    ) and not isinstance(kind, types.Literal):
        return str(kind)
    raise ValueError(str(kind))


def decode(encoded: Any) -> Any:
    """Return the numba type that `encode` turned into the JSON values `encoded`."""
    if isinstance(encoded, str):
        return getattr(types, encoded)
    head, *rest = encoded
    if head == "array":
        dtype, dimensions, layout, is_mutable = rest
        return types.Array(
            getattr(types, {"bool": "boolean"}.get(dtype, dtype)),
            dimensions,
            layout,
            readonly=not is_mutable,
        )
    if head == "function":
        return types.FunctionType(decode(rest[0])(*map(decode, rest[1])))
    if head == "omitted":
        return types.Omitted(rest[0])  # type: ignore[no-untyped-call]  # numba has no types
    module, _, name = rest[0].partition(":")
    cls = getattr(importlib.import_module(module), name)
    return types.BaseTuple.from_types(
        [decode(one) for one in rest[1]], None if cls is tuple else cls
    )  # type: ignore[no-untyped-call]  # numba has no types


def _uniform(kind: Any) -> list[Any]:
    return [kind.dtype] * kind.count


def kept(folder: Path) -> Iterator[list[Any]]:
    """Yield the row (module, name, kind, types) of each kernel in the cache folder of a toolchain.

    A kernel comes before the kernels that it calls.
    """
    sources = Sources(PACKAGE.parent, folder)
    rows = []
    for state in kernel_folders.states(folder):
        module = f"frictool.{kernel_folders.module_of(state.path)}"
        if not sources.holds(module) or not state.path.name.endswith(
            sources.state([module]).digest
        ):
            continue  # belongs to a test or to former sources
        for index in sorted(state.path.glob("*.nbi")):
            if LINKED in index.name:
                continue  # compiled with its callers
            with open(index, "rb") as stream:
                pickle.load(stream)
                _, overloads = pickle.loads(stream.read())
            rows += list(rows_of(module, index.name.partition("-")[0], overloads))
    modules = {row[0] for row in rows}
    sizes = {module: len(sources.state([module]).modules) for module in modules}
    yield from sorted(rows, key=lambda row: (-sizes[row[0]], json.dumps(row)))


def rows_of(module: str, name: str, signatures: Any) -> Iterator[list[Any]]:
    """Yield a row (module, name, kind, types) for each kernel signature that Python can call."""
    kernel: Any = getattr(importlib.import_module(module), name, None)
    for signature, *_ in signatures if kernel is not None else ():
        try:
            if hasattr(signature, "return_type"):
                yield [
                    module,
                    name,
                    "pointer",
                    [encode(signature.return_type), [encode(one) for one in signature.args]],
                ]
            else:
                yield [module, name, "kernel", [encode(one) for one in signature]]
        except ValueError:
            continue


if __name__ == "__main__":
    if kernels.FOLDER is None:
        raise SystemExit("no folder for compiled kernels can be used; `frictool doctor` says why")
    print(
        "[\n"
        + ",\n".join(json.dumps(row, separators=(",", ":")) for row in kept(kernels.FOLDER))
        + "\n]"
    )
