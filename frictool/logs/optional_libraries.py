"""Import of libraries that only some file formats need."""

from __future__ import annotations

import importlib
from pathlib import Path
from types import ModuleType

from frictool.errors import LogError


def library(path: Path, module: str, extra: str) -> ModuleType:
    """Return the imported module `module`.

    Raises LogError with `path` and the install command if the module is missing.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or not module.startswith(error.name.partition(".")[0]):
            raise
        raise LogError(
            path, f"needs {error.name}, which is not installed: pip install 'frictool[{extra}]'"
        ) from None
