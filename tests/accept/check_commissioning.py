"""100 actuators, drawn by the commit's hash, commissioned by `plan` on a simulated bench.

At least 97 % end with a controller that meets the specification on all plants of the judge, or
with a refusal where the judge's search finds none. No test breaks a limit of the bench. The results
are kept in build/commissioning/HASH.json: the check continues after an interruption.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from studies.commissioning import commissionings, summary
from tests.support.commit_hash import commit_hash

COUNT = 100
LEAST_RIGHT = 0.97


def commissioned_actuators() -> dict[str, Any]:
    """Counts over COUNT actuators; the rows are written to build/commissioning.txt."""
    seed = commit_hash()
    page = Path("build", "commissioning.txt")
    kept = Path("build", "commissioning", f"{seed}.json")
    rows = []
    page.parent.mkdir(exist_ok=True)
    page.write_text(f"seed {seed}\n")
    for one in commissionings(seed, range(COUNT), kept, os.cpu_count() or 1):
        rows.append(one)
        with page.open("a") as file:
            file.write(f"{one.row()}\n")
    found = summary(rows)
    return {
        "passed": found["right"] >= LEAST_RIGHT * COUNT and found["broken_limits"] == 0,
        "rows": str(page),
        **found,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "plan: 100 commissioned actuators": commissioned_actuators
}
