"""Switched observers of drawn models at full count: axes from a throttle to a portal,
periods from 0.1 to 10 ms, friction that turns up to four times. Each is designed and kept by an
independent simulation in SI, or refused in one line."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from frictool.documents.provenance import Provenance
from frictool.errors import NoSolutionError
from frictool.observe.design import additive, multiplicative
from frictool.typing import Matrix
from tests.support.random_observer_models import (
    COUNT,
    largest_gain,
    random_model,
)

LEAST_DESIGNED = 0.95


def drawn_models() -> dict[str, Any]:
    """All of COUNT."""
    found, refused = [], []
    for number in range(COUNT):
        model, settings, is_additive = random_model(number)
        try:
            observer = (additive if is_additive else multiplicative).design(
                model, settings, Provenance("drawn", "0")
            )
        except NoSolutionError as error:
            refused.append(f"{number}: {error}")
            continue
        assert observer.switched is not None
        radius = max(mode.spectral_radius for mode in observer.switched.modes)
        found.append(
            (
                largest_gain(observer),
                observer.switched.simulated_gain / observer.switched.gamma,
                radius - observer.switched.decay,
            )
        )
    table: Matrix = np.array(found)
    kept = bool(
        np.all(table[:, 0] <= 1.0) and np.all(table[:, 1] <= 1.0) and np.all(table[:, 2] < 0.0)
    )
    return {
        "passed": kept and len(found) >= LEAST_DESIGNED * COUNT,
        "designed": f"{len(found)} of {COUNT}",
        "refused": "; ".join(refused) or "none",
        "worst gain over gamma, independent simulation": round(float(table[:, 0].max()), 4),
        "worst disturbance over gamma": f"{table[:, 1].min():.3f} to {table[:, 1].max():.4f}",
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "observers: designs of drawn models": drawn_models
}
