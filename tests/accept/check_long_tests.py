"""Tests that `make test` leaves out, by file: repetitions with more cases, plants or pages.

They carry the mark `accept`, as a whole or for some of their cases.

python -m tests.accept build/accept.json "long tests: tests/prove/test_step_proof.py"
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

from tests.support.documentation_pages import ROOT

MARKED = sorted(
    str(path.relative_to(ROOT))
    for path in (ROOT / "tests").rglob("test_*.py")
    if "pytest.mark.accept" in path.read_text(encoding="utf-8")
)


def passes(path: str, *options: str) -> dict[str, Any]:
    """Passed where the tests of a file or folder that `options` select pass."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", path, "-q", *options],
        cwd=ROOT,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
    )
    return {"passed": done.returncode == 0, "end": done.stdout[-300:]}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    **{f"long tests: {path}": partial(passes, path, "-m", "accept") for path in MARKED},
    # `make test` draws 20 examples of each property that states no number of its own
    "property tests: a hundred examples": partial(
        passes, "tests", "-m", "hypothesis", "--hypothesis-profile", "hundred examples"
    ),
}
