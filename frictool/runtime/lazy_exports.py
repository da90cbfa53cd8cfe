"""Exports of a package that are imported on first use, so that importing the package is fast."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from typing import Any


def lazy_exports(
    package: str, modules: dict[str, list[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return `__getattr__`, `__dir__` and `__all__` of a package that exports names of its modules.

    Parameters
    ----------
    package : str
        Full name of the package.
    modules : dict
        Names that each module exports; a key is a module's name relative to the package.

    Returns
    -------
    tuple
        `__getattr__`, `__dir__` and `__all__`. `__getattr__` imports the module that exports a
        name, and stores the value in the package. For a name that is not exported, `__getattr__`
        raises AttributeError.
    """
    where = {name: f"{package}.{module}" for module, names in modules.items() for name in names}
    exported = sorted(where)

    def get(name: str) -> Any:
        if name not in where:
            raise AttributeError(
                f"module {package!r} has no attribute {name!r}; it offers {', '.join(exported)}"
            )
        value = getattr(importlib.import_module(where[name]), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *where})

    return get, names, exported
