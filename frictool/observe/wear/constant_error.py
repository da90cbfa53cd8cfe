"""Effect of a wrong actuator constant on the estimates.

The logged effort is the constant times the drive signal. An error of the constant therefore scales
all estimates by the same factor:

    estimate = (true value) (constant of the bench)/(constant of the actuator)

The formula applies to wear, inertia, viscous friction and added friction. The error is not visible
in a log; the range of the constant in bench.yaml limits it. The error cancels in a ratio to the
wear of the same actuator at commissioning.
"""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.observe.wear_estimate import EstimateRange

QUANTILE = 1.96  # quantile of the normal distribution; the bench's range is a 95 % interval


def scale_of(model: Model) -> EstimateRange | None:
    """Return the common factor of all estimates: 1, with the interval value/high to value/low.

    bench.yaml states value, low and high of the actuator constant. Without a range, return None.
    """
    known = model.bench.actuator.constant
    low, high = known.interval
    return EstimateRange(1.0, known.value / high, known.value / low) if 0.0 < low < high else None


def relative_deviation(model: Model) -> float:
    """Return the relative standard deviation of the actuator constant; 0 without a range."""
    low, high = model.bench.actuator.constant.interval
    return 0.5 * (high - low) / (QUANTILE * model.bench.actuator.constant.value)
