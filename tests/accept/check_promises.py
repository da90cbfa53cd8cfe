"""Do the tests of `excite --for` keep their promises? Ten rigs with 100 drawn axes each.

The half width is at most the promised one in 97 of 100 axes of a rig. Its interval holds the true
value in at least 88 of 100, and in 93 to 97 % of all. No test is longer than the default kind of
equal precision, and the median is at most half as long. The mean square error is at most 1.6 times
the Cramer-Rao bound, and 1.25 times in the median. A test is designed in at most 20 s of processor
time. The rows are written to build/promises.txt.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

from studies.promises.__main__ import HEADER, counts_of
from studies.promises.rigs import benches
from tests.support.commit_hash import commit_hash

AXES = 100
KEPT, HELD = 0.97, 0.88
LOWEST, HIGHEST = 0.93, 0.97  # share of all intervals that hold the true value
SHORTER = 0.5  # of the default kind's duration, in the median
VARIANCE, MEDIAN_VARIANCE = 1.6, 1.25  # over the Cramer-Rao bound
DESIGN_S = 20.0


def promises() -> dict[str, Any]:
    """Rates and ratios over the ten rigs; the figures name the least and the largest."""
    first = int(commit_hash()[:8], 16)
    page = Path("build", "promises.txt")
    page.parent.mkdir(exist_ok=True)
    page.write_text(f"first seed {first}\n{HEADER}\n")
    counts = []
    for bench in benches():
        for one in counts_of(bench, range(first, first + AXES)):
            counts.append(one)
            with page.open("a") as file:
                file.write(f"{one.row()}\n")
    figures = {
        "least_kept": min(one.kept / one.trials for one in counts),
        "least_held": min(one.held / one.trials for one in counts),
        "held": sum(one.held for one in counts) / sum(one.trials for one in counts),
        "longest": max(one.duration / one.default for one in counts),
        "median_duration": median(one.duration / one.default for one in counts),
        "largest_variance": max(one.variance for one in counts),
        "median_variance": median(one.variance for one in counts),
        "largest_design_s": max(one.design for one in counts),
    }
    return {
        "passed": figures["least_kept"] >= KEPT
        and figures["least_held"] >= HELD
        and LOWEST <= figures["held"] <= HIGHEST
        and figures["longest"] <= 1.0
        and figures["median_duration"] <= SHORTER
        and figures["largest_variance"] <= VARIANCE
        and figures["median_variance"] <= MEDIAN_VARIANCE
        and figures["largest_design_s"] <= DESIGN_S,
        "rows": str(page),
        **figures,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"excite: promises of ten rigs": promises}
