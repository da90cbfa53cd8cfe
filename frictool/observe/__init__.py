"""Observers for velocity, friction and wear: their design, and estimates along a log."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.observe.design.observer_design import design_observer as design_observer
    from frictool.observe.observation import LogObservation as LogObservation
    from frictool.observe.observation import observe as observe
    from frictool.observe.observation_outcome import ObservationOutcome as ObservationOutcome
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "LogObservation": "frictool.observe.observation",
            "ObservationOutcome": "frictool.observe.observation_outcome",
            "design_observer": "frictool.observe.design.observer_design",
            "observe": "frictool.observe.observation",
        },
    )

__all__ = ["LogObservation", "ObservationOutcome", "design_observer", "observe"]
