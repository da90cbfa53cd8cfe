"""The synthesis against SLICOT (sb10ad through ctrlsys), each call in a process of its own with a
time-out.

the seeded family of orders 4 to 20     gamma within 1 %, both controllers rebuilt
position loop, D12 = 0                  what SLICOT answers, and what ours gives for each vertex
                                        alone
annex C, regularised                    gamma and the true norm of SLICOT's own controller
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from frictool.lmi.hinf_synthesis import controller, minimise
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.verify.hinf_norm import norm
from studies.references.slicot import AVAILABLE, MISSING, slicot
from studies.rigs.mixed_sensitivity import ORDERS, mixed_sensitivity
from studies.rigs.published_plants import READINGS, annex_lft, annex_mixed, position

TIMEOUT, WITHIN, RECENTRING = 120.0, 0.01, 1.02


def compared(plant: GeneralisedPlant) -> dict[str, Any]:
    """Optimum, true norm and seconds of both."""
    start = time.perf_counter()
    found = minimise([plant], RECENTRING)
    reached = norm(plant.closed(controller(plant, found)))[0]
    ours = time.perf_counter() - start
    start = time.perf_counter()
    theirs = slicot(plant, TIMEOUT)
    told: dict[str, Any] = {
        "ours": found.optimum,
        "asked": found.gamma,
        "ours_true": reached,
        "ours_s": ours,
    }
    told |= {"slicot": theirs.gamma, "slicot_says": theirs.reason}
    if theirs.controller is not None:
        told["slicot_true"] = norm(plant.closed(theirs.controller))[0]
    return told | {"slicot_s": time.perf_counter() - start}


def skipped() -> dict[str, Any]:
    return {"passed": True, "skipped": MISSING}


def family() -> dict[str, Any]:
    """Every order."""
    if not AVAILABLE:
        return skipped()
    rows = {order: compared(mixed_sensitivity(order)) for order in ORDERS}
    for order, row in rows.items():
        print(
            f"  order {order:2d}: ours {row['ours']:.5f} (true norm {row['ours_true']:.5f}), "
            f"SLICOT {row['slicot']} {row['slicot_says']}",
            flush=True,
        )
    off = {
        order: abs(row["ours"] / row["slicot"] - 1.0) if row["slicot"] else float("inf")
        for order, row in rows.items()
    }
    kept = all(row["ours_true"] <= row["asked"] for row in rows.values())
    return {
        "passed": kept and max(off.values()) <= WITHIN,
        "worst_difference": max(off.values()),
        "orders": len(rows),
        "rows": rows,
    }


def without_d12() -> dict[str, Any]:
    """D12 = 0 breaks the assumptions of the Riccati equations; the inequalities have none."""
    if not AVAILABLE:
        return skipped()
    rows = [compared(plant) for plant in position()[::5]]
    answers = sorted(
        {
            row["slicot_says"]
            or f"gamma {row['slicot']:.4g}, its controller {row['slicot_true']:.4g}"
            for row in rows
        }
    )
    return {
        "passed": all(row["ours_true"] <= row["asked"] for row in rows),
        "slicot_says": "; ".join(answers),
        "ours_worst": max(row["ours"] for row in rows),
        "ours_true_worst": max(row["ours_true"] / row["asked"] for row in rows),
        "rows": rows,
    }


def annex() -> dict[str, Any]:
    """The regularised annex, LFT, which both can solve; and its LPV vertices, each alone for
    SLICOT."""
    if not AVAILABLE:
        return skipped()
    row = compared(annex_lft(READINGS["regularised"]))
    vertices = [compared(plant) for plant in annex_mixed(READINGS["regularised"])]
    passed = all(one["ours_true"] <= one["asked"] for one in (row, *vertices))
    agreed = row["slicot"] is not None and abs(row["ours"] / row["slicot"] - 1.0) <= WITHIN
    return {"passed": passed and agreed, **row, "vertices": vertices}


def beyond() -> dict[str, Any]:
    """Order 24: SLICOT's own controller, rebuilt, does not reach the gamma that SLICOT tells; ours
    keeps what it was asked for."""
    if not AVAILABLE:
        return skipped()
    row = compared(mixed_sensitivity(24))
    return {"passed": row["ours_true"] <= row["asked"], **row}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "slicot: mixed sensitivity, orders 4 to 20": family,
    "slicot: order 24": beyond,
    "slicot: the position loop, D12 = 0": without_d12,
    "slicot: annex C, regularised": annex,
}
