"""Knees of friction over speed: none on a plain clutch, whatever its inertia is within the bench's
range, and that of figure 4.10 is found.

Plain are the axes of `check_identify`. The knee is that of the non-linear clutch
(configs/clutch/nonlinear.yaml), its inertia drawn from the bench's range: from sines and ramps
together, since its friction varies with position (`friction_map`), and from sines alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from tests.support.friction_knees import false_knees, true_knees

CLUTCHES, KNEES = 200, 100
FALSE, FOUND = 0.02, 0.95


def knees() -> dict[str, Any]:
    """At most 2 % of false knees, and 95 % of the true ones."""
    false, (mapped, alone) = false_knees(CLUTCHES), true_knees(KNEES)
    passed = false <= FALSE * CLUTCHES and mapped >= FOUND * KNEES
    return {
        "passed": passed,
        "plain": CLUTCHES,
        "false_knees": false,
        "with_knee": KNEES,
        "found": mapped,
        "found_by_sines_alone": alone,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"identify: knees, false and true": knees}
