"""Intervals of a model's parameters, with and without the uncertainty of the drive constant."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.adapters.parameter_intervals import absolute
from frictool.documents.model import Model
from frictool.documents.quantity import FROM_LOGS, Estimate, Quantity
from frictool.identify.fit_result import CURVE, PARAMETERS, Interval

FORCES = PARAMETERS  # parameters that an error of the drive constant scales, if they are from logs


@dataclass(frozen=True)
class ParameterIntervals:
    """Estimate of one parameter, its absolute interval, and its value in bench.yaml.

    - estimate: estimate in the model document
    - absolute: interval that includes the uncertainty of the drive constant
    - bench: quantity in bench.yaml; None if bench.yaml does not state the parameter
    """

    name: str
    estimate: Estimate
    absolute: Interval
    bench: Quantity | None

    @property
    def identified(self) -> bool:
        """Return True if the logs determine the parameter."""
        return self.estimate.source == "identified"

    @property
    def assumed(self) -> bool:
        """Return True if the range is assumed, and comes from neither logs nor bench.yaml."""
        return self.estimate.source == "assumed" and self.estimate.low is not None

    @property
    def from_logs(self) -> bool:
        """Return True if the logs determine the parameter or narrow the range in bench.yaml."""
        return self.estimate.source in FROM_LOGS

    @property
    def relative_half_width(self) -> float:
        """Return the interval's half width divided by |value|; infinity if the value is 0."""
        low, high = self.estimate.interval
        value = abs(self.estimate.value)
        return 0.5 * (high - low) / value if value > 0.0 else float("inf")


def parameter_intervals(model: Model) -> list[ParameterIntervals]:
    """Return the intervals of all parameters in the model, in the order of the model document."""
    constant = model.bench.actuator.constant
    rows = []
    for name in (*PARAMETERS, *CURVE):
        estimate: Estimate | None = getattr(model.parameters, name)
        if estimate is None:
            continue
        ends = estimate.interval
        known = getattr(model.bench.mechanics, name, None)
        if name in FORCES and estimate.source != "bench":
            ends = absolute(*ends, constant)
        if known is not None and estimate.source == "log and bench":
            ends = max(ends[0], known.interval[0]), min(ends[1], known.interval[1])
        rows.append(ParameterIntervals(name, estimate, Interval(estimate.value, *ends), known))
    return rows
