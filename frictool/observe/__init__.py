"""Observers for velocity, friction and wear: their design, and estimates along a log.

Docstrings state the units of a rotary and of a linear axis separated by |, as in "rad | m".
"""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.observe.design.observer_design import design_observer as design_observer
    from frictool.observe.observation import LogObservation as LogObservation
    from frictool.observe.observation import observe as observe
    from frictool.observe.observation_outcome import ObservationOutcome as ObservationOutcome
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "design.observer_design": ["design_observer"],
            "observation": ["LogObservation", "observe"],
            "observation_outcome": ["ObservationOutcome"],
        },
    )
