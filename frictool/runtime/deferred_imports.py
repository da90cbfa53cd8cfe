"""Deferred import of parts of numpy and scipy that numba and other packages import needlessly.

This module is imported before the first kernel is called.
"""

from __future__ import annotations

import functools
import importlib.util
import sys

import numpy as np

BLAS = "scipy.linalg.cython_blas"
# parts of numpy that scipy.linalg looks at, but does not use
UNUSED = ("f2py", "testing")


@functools.cache
def import_array_functions() -> None:
    """Import numba's array functions, which compilation needs, but do not import scipy.linalg.

    numba would import scipy's BLAS for numpy.cov, which no kernel uses. For other functions of
    linear algebra, numba imports the BLAS later.
    """
    hidden = BLAS not in sys.modules
    if hidden:
        sys.modules[BLAS] = None  # type: ignore[assignment]  # the import system then reports a missing module
    try:
        import numba.np.arraymath  # noqa: F401  # its functions are registered
    finally:
        if hidden:
            del sys.modules[BLAS]


def defer_parts_of_numpy() -> None:
    """Make numpy load its rarely used modules only when one of their attributes is read."""
    for part in UNUSED:
        name = f"numpy.{part}"
        spec = importlib.util.find_spec(name) if name not in sys.modules else None
        if spec is None or spec.loader is None:
            continue
        loader = importlib.util.LazyLoader(spec.loader)
        spec.loader = loader
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        loader.exec_module(module)
        setattr(np, part, module)
