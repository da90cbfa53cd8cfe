"""Exports of a package that are imported at first use, so that importing it stays cheap."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import Any


def lazy_exports(
    package: str, where: dict[str, str]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return `__getattr__` and `__dir__` of a package that exports names of its modules.

    Parameters
    ----------
    package
        Full name of the package.
    where
        Full name of the module that defines each exported name.

    Returns
    -------
    tuple
        `__getattr__`, which imports the module and keeps the value in the package, and `__dir__`.
        `__getattr__` raises AttributeError for any other name.
    """

    def get(name: str) -> Any:
        if name not in where:
            raise AttributeError(
                f"module {package!r} has no attribute {name!r}; it offers {', '.join(where)}"
            )
        found = getattr(importlib.import_module(where[name]), name)
        setattr(sys.modules[package], name, found)
        return found

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *where})

    return get, names
