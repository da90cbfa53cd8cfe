"""The engine of mechanisms at full count: energy over random mechanisms, starts against Gauss's principle."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.engine.mechanism.test_balance import CLOSED, check

MECHANISMS = 4000


def energy_closes() -> dict[str, Any]:
    """Random mechanisms of all elements under random inputs: what is put in is held or lost; no loss is negative; every run ends."""
    errors = np.array([check(seed) for seed in range(MECHANISMS)])
    return {"passed": bool(errors.max() < CLOSED), "mechanisms": MECHANISMS, "worst": float(errors.max()), "at": int(errors.argmax())}


CHECKS = {"mechanisms_energy_closes": energy_closes}
