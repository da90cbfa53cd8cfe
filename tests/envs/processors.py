"""The tests with the linear algebra of other processors: the kernels of OpenBLAS, and one or two
threads."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from tests.support.documentation_pages import ROOT

NEEDS = {
    "Prescott": "pni",
    "Haswell": "avx2",
    "Zen": "avx2",
    "SkylakeX": "avx512f",
}  # flags of /proc/cpuinfo
THREADS = {"Prescott": 2, "Haswell": 1, "Zen": 2, "SkylakeX": 1}


def flags(path: Path = Path("/proc/cpuinfo")) -> set[str]:
    """Return what the processor can do; nothing where the system does not say."""
    if not path.exists():
        return set()
    line = next((line for line in path.read_text().splitlines() if line.startswith("flags")), "")
    return set(line.partition(":")[2].split())


def suite(core: str, threads: int, paths: tuple[str, ...] = ()) -> dict[str, Any]:
    """Run the tests, or those in `paths`, with the kernels of OpenBLAS for `core`."""
    if NEEDS[core] not in flags():
        return {"passed": True, "skipped": f"this processor has no {NEEDS[core]}"}
    environment = {**os.environ, "OPENBLAS_CORETYPE": core, "OPENBLAS_NUM_THREADS": str(threads)}
    start = time.perf_counter()
    words = [sys.executable, "-m", "pytest", "-n", "auto", "--dist", "loadfile", *paths]
    done = subprocess.run(
        words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False
    )
    lines = done.stdout.splitlines()
    failed = [line for line in lines if line.startswith(("FAILED", "ERROR"))]
    seconds = round(time.perf_counter() - start, 1)
    return {
        "passed": done.returncode == 0,
        "threads": threads,
        "end": lines[-1] if lines else "",
        "failed": failed,
        "s": seconds,
    }


ENVIRONMENTS: dict[str, Callable[..., dict[str, Any]]] = {
    core: partial(suite, core, threads) for core, threads in THREADS.items()
}
