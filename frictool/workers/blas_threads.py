"""Linear algebra in one thread, in a process that may have loaded it before: sums in another order
give other bytes.

A library is told so by the environment as it is loaded, and later by a call of its own only: a
worker of a cluster has loaded numpy before it is given its first task.
"""

from __future__ import annotations

import ctypes
import os
import sys

LOADERS = (
    "numpy.linalg._umath_linalg",
    "scipy.linalg._fblas",
)  # modules that each bring a library of linear algebra
SETTERS = (
    "scipy_openblas_set_num_threads64_",
    "scipy_openblas_set_num_threads",
    "openblas_set_num_threads64_",
    "openblas_set_num_threads",
    "MKL_Set_Num_Threads",
)


def limit_blas_threads() -> None:
    """From here on, for what is loaded and for what comes."""
    os.environ.update(OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")
    for name in LOADERS:
        path = getattr(sys.modules.get(name), "__file__", None)
        if path is not None:
            library = ctypes.CDLL(
                path
            )  # the one that is loaded, which finds the names of what it depends on
            for setter in SETTERS:
                if hasattr(library, setter):
                    getattr(library, setter)(1)
