"""The engine of mechanisms at full count: energy over random mechanisms, starts against Gauss's
principle."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.support.energy_balance import CLOSED, balance_error
from tests.support.self_locking_mechanisms import compared

MECHANISMS, SELF_LOCKING = 4000, 200


def energy_closes() -> dict[str, Any]:
    """Random mechanisms of all elements under random inputs: what is put in is held or lost; no
    loss is negative; every run ends."""
    errors = np.array([balance_error(seed) for seed in range(MECHANISMS)])
    return {
        "passed": bool(errors.max() < CLOSED),
        "mechanisms": MECHANISMS,
        "worst": float(errors.max()),
        "at": int(errors.argmax()),
    }


def self_locking_is_the_limit_of_stiff_links() -> dict[str, Any]:
    """Random self-locking links, rigid, move as ever stiffer ones with damping do, where the size
    of the damping decides nothing."""
    found = {seed: compared(seed) for seed in range(SELF_LOCKING)}
    limited = [seed for seed, one in found.items() if one.has_limit]
    apart = [seed for seed in limited if not found[seed].agrees]
    moving = sum(found[seed].moves for seed in limited)
    passed = not apart and len(limited) >= 0.95 * SELF_LOCKING and moving >= 0.25 * SELF_LOCKING
    return {
        "passed": passed,
        "mechanisms": SELF_LOCKING,
        "with_limit": len(limited),
        "moving": moving,
        "apart": apart,
    }


CHECKS = {
    "mechanisms_energy_closes": energy_closes,
    "self_locking_is_the_limit_of_stiff_links": self_locking_is_the_limit_of_stiff_links,
}
