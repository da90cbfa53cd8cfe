"""Linear algebra that was loaded with several threads computes with one."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

SCRIPT = """
import ctypes, sys
import numpy.linalg._umath_linalg, scipy.linalg._fblas
from frictool.workers.blas_threads import LOADERS, SETTERS, limit_blas_threads
def threads():
    libraries = [ctypes.CDLL(sys.modules[name].__file__) for name in LOADERS]
    getters = [
        getattr(one, name.replace("_set_", "_get_"))
        for one in libraries
        for name in SETTERS
        if hasattr(one, name)
    ]
    return [getter() for getter in getters]
before = threads()
limit_blas_threads()
print(before, threads())
"""


def test_what_is_loaded_is_told_too() -> None:
    own = {**os.environ, "OPENBLAS_NUM_THREADS": "2"}
    told = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=own, capture_output=True, text=True, check=True
    ).stdout
    if told.startswith("[]"):
        pytest.skip("another library than OpenBLAS")
    assert told.endswith("] [1, 1]\n"), told  # [2, 2] before, where there are two cores
