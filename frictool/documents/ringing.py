"""Warning about models that lack the oscillation of the position after stops (`ringing`)."""

from __future__ import annotations

import math

from frictool.documents.model import Model


def missing_ringing(model: Model) -> str | None:
    """Return a warning if the model has no resonance, but its logs show one, else None."""
    one = model.ringing
    if one is None or model.resonances is not None:
        return None
    rates = (one.rad_s, *(one.interval_rad_s or (one.rad_s,)))
    value, *ends = (f"{rate / (2.0 * math.pi):.3g}" for rate in rates)
    return (
        f"after stops, the position rings at {value} Hz ({' to '.join(ends)}): a compliance that "
        "margins and simulations of this model lack; test controllers on a mechanism with it"
    )
