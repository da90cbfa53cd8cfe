"""Effect of a wrong actuator constant on the estimates.

The logged effort is the constant times the drive. An error of the constant therefore scales all
estimates alike:

    estimate = true (constant of the bench)/(constant of the unit)

This holds for wear, inertia, viscous friction and added friction. No log of the actuator alone
reveals the error. The bench's range bounds the error. A ratio to the wear of the same unit at
commissioning is free of it.
"""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.observe.interval_estimate import EstimateRange

QUANTILE = 1.96  # of a normal distribution: the bench's interval is taken as a 95 % interval


def scale_of(model: Model) -> EstimateRange | None:
    """Return the range of a common factor of all estimates; None if the bench gives no range.

    The factor follows from the bench's range of the actuator's constant, and is 1 at its value.
    """
    known = model.bench.actuator.constant
    low, high = known.interval
    return EstimateRange(1.0, known.value / high, known.value / low) if 0.0 < low < high else None


def relative_deviation(model: Model) -> float:
    """Return the relative standard deviation of the actuator's constant; 0 without a range."""
    low, high = model.bench.actuator.constant.interval
    return 0.5 * (high - low) / (QUANTILE * model.bench.actuator.constant.value)
