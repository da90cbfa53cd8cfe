"""Weights for the coefficients that are fitted to the rows of the weak form.

The weighted sum of the coefficients is the friction in one direction or zone of the travel, divided
by the friction of the model.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from frictool.friction.position_polynomial import mean_over
from frictool.observe.wear.parameter_restriction import dry_columns, level_columns
from frictool.observe.wear.weak_form_layout import WeakFormLayout
from frictool.typing import Vector

DIGITS = 6  # significant digits of printed zone boundaries, relative to the travel
SIDES = ("backward", "forward")


def zone_edges(layout: WeakFormLayout) -> list[float]:
    """Return the boundaries (z + 1,) of the zones [rad | m], rounded for printing."""
    span = float(np.ptp(layout.edges))
    return [
        float(edge) + 0.0
        for edge in np.round(
            layout.edges, DIGITS - math.floor(math.log10(span)) if span > 0.0 else DIGITS
        )
    ]


def zone_mean(layout: WeakFormLayout, zone: int) -> Vector:
    """Return weights (p,) that average a zone's dry-friction coefficients over both directions."""
    columns = dry_columns(layout, zone=zone)
    return np.asarray(columns / np.sum(columns))


def friction_share(layout: WeakFormLayout, zones: Sequence[int], side: str | None = None) -> Vector:
    """Return weights (p,) with which the coefficients sum to (mean friction)/(model's friction).

    - zones: indices of zones; empty for all zones
    - side: direction; None for both directions
    """
    sides = SIDES if side is None else (side,)
    bounded = np.all(np.isfinite(layout.edges)) and layout.edges[0] < layout.edges[-1]
    spans = {
        zone: float(layout.edges[zone + 1] - layout.edges[zone]) if bounded else 1.0
        for zone in zones or range(layout.zones)
    }
    weights = np.zeros(len(layout.names))
    whole = 0.0
    for name in sides:
        for zone, span in spans.items():
            part = span * _mean_friction(layout, name, zone)
            weights[layout.names.index(f"dry_{name}_{zone}")] = part
            whole += part
    # half the sum of both levels is friction, half their difference is an offset
    each = 0.5 * len(sides) * sum(spans.values())
    levels = level_columns(layout, each, each)
    return np.asarray((weights + levels) / whole)


def _mean_friction(layout: WeakFormLayout, side: str, zone: int) -> float:
    curve, (low, high) = layout.dry[SIDES.index(side)], layout.mapped
    if not np.isfinite(low):
        return float(curve[0])
    return mean_over(
        curve, float(low), float(high), float(layout.edges[zone]), float(layout.edges[zone + 1])
    )
