"""Velocity, friction and wear from a running actuator: observers designed, and logs that they run along."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.observe.design.any_kind import design_observer as design_observer
    from frictool.observe.observation import Observed as Observed
    from frictool.observe.observation import observe as observe
    from frictool.observe.outcome import Outcome as Outcome
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Observed": "frictool.observe.observation",
            "Outcome": "frictool.observe.outcome",
            "design_observer": "frictool.observe.design.any_kind",
            "observe": "frictool.observe.observation",
        },
    )

__all__ = ["Observed", "Outcome", "design_observer", "observe"]
