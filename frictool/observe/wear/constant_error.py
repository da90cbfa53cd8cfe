"""What a wrong actuator's constant does: the effort is logged as constant times drive, so that all
that is found from it is scaled alike.

    found = true (constant of the bench)/(constant of the unit)         wear, inertia, viscous
                                                                        friction, what is added

No log of the actuator alone can tell it. The bench's range says how large it may be; a ratio to the
unit's own commissioning is free of it.
"""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.observe.estimate import EstimateRange

QUANTILE = 1.96  # the bench's interval is taken as one of 95 %


def scale_of(model: Model) -> EstimateRange | None:
    """The factor on all that is found, 1 within the bench's range of the constant; None where the
    bench gives none."""
    known = model.bench.actuator.constant
    low, high = known.interval
    return EstimateRange(1.0, known.value / high, known.value / low) if 0.0 < low < high else None


def relative_deviation(model: Model) -> float:
    """Of the actuator's constant, over it; 0 where the bench gives no range."""
    low, high = model.bench.actuator.constant.interval
    return 0.5 * (high - low) / (QUANTILE * model.bench.actuator.constant.value)
