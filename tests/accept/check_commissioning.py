"""100 actuators, drawn by the commit's hash, commissioned by `plan` on a simulated bench.

At least 97 % end with a controller that meets the specification on all plants of the judge, or
with a refusal where the judge's search finds none. No test breaks a limit of the bench.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from studies.commissioning import commission, summary
from tests.support.commit_hash import commit_hash

COUNT = 100
LEAST_RIGHT = 0.97


def commissioned_actuators() -> dict[str, Any]:
    """Counts over COUNT actuators; the rows are written to build/commissioning.txt."""
    seed = commit_hash()
    page = Path("build", "commissioning.txt")
    page.parent.mkdir(exist_ok=True)
    page.write_text(f"seed {seed}\n")
    rows = []
    for number in range(COUNT):
        rows.append(commission(seed, number))
        with page.open("a") as file:
            file.write(f"{rows[-1].row()}\n")
    found = summary(rows)
    return {
        "passed": found["right"] >= LEAST_RIGHT * COUNT and found["broken_limits"] == 0,
        "rows": str(page),
        **found,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "plan: 100 commissioned actuators": commissioned_actuators
}
