"""Does `identify` give what `assess` promises? Its proposed test is played on simulated clutches,
through the commands that a user gives.

    assess --json -> excite --kind sines -> simulated bench -> ingest -> identify --json

Each seed has its own noise, turns, encoder phase and its own axis, as in check_identify. Promised
is half of a 95 % interval: the errors of the records have to be within it at about that rate, and
their rms times 1.96 near it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.identify.assess.identifiability import CONFIDENCE, QUANTILE
from tests.support.assess_promises import PARAMETERS, outcomes, promised

RECORDS = 200
CHANCE = 1e-3


def kept() -> dict[str, Any]:
    """The inertia that differentiation is refused for, by the weak form, and friction by sines: all
    within what is promised."""
    rows, (errors, held) = promised(), outcomes(RECORDS)
    limits = np.array([rows[name]["precision"] for name in PARAMETERS])
    inside, reached = (
        np.sum(np.abs(errors) <= limits, axis=0),
        QUANTILE * np.sqrt(np.mean(errors**2, axis=0)),
    )
    least = int(binom.ppf(CHANCE, RECORDS, CONFIDENCE))
    methods = [rows[name]["method"] for name in PARAMETERS]
    out: dict[str, Any] = {
        "passed": methods == ["weak", "sines", "sines"]
        and bool(
            np.all(inside >= least)
            and np.all(held.sum(axis=0) >= least)
            and np.all(reached <= 1.2 * limits)
        ),
        "records": RECORDS,
        "inertia_by_differentiation": rows["inertia"]["bound"],
        "least_accepted": least,
    }
    for k, name in enumerate(PARAMETERS):
        out |= {
            f"{name}_promised": float(limits[k]),
            f"{name}_reached": float(reached[k]),
            f"{name}_inside": int(inside[k]),
        }
        out |= {
            f"{name}_mean_error": float(errors[:, k].mean()),
            f"{name}_interval_holds": int(held[:, k].sum()),
        }
    return out


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"assess: what it promises, identify gives": kept}
