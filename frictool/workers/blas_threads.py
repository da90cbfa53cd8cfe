"""Limit linear algebra to one thread, because with several threads the last digits may vary.

The limit is set in two ways. A library that is not yet loaded reads the limit from the environment.
A library that is already loaded, such as numpy in a worker of a cluster, needs a function call.
"""

from __future__ import annotations

import ctypes
import os
import sys

# modules that each load a library of linear algebra
LOADERS = ("numpy.linalg._umath_linalg", "scipy.linalg._fblas")
SETTERS = (
    "scipy_openblas_set_num_threads64_",
    "scipy_openblas_set_num_threads",
    "openblas_set_num_threads64_",
    "openblas_set_num_threads",
    "MKL_Set_Num_Threads",
)


def limit_blas_threads() -> None:
    """Use one thread in all libraries of linear algebra, also in those that are loaded later."""
    os.environ.update(OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")
    for name in LOADERS:
        path = getattr(sys.modules.get(name), "__file__", None)
        if path is not None:
            # the loaded library, through which the symbols of its dependencies are visible
            library = ctypes.CDLL(path)
            for setter in SETTERS:
                if hasattr(library, setter):
                    getattr(library, setter)(1)
