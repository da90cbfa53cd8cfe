"""Events of a simulated mechanism as a CSV table: breakaways, sticking, contacts and impacts."""

from __future__ import annotations

from frictool.engine.mechanism.events import NAMES
from frictool.simulate.mechanism_runs import MechanismOutcome, element_of

HEAD = "time_s,plant,element,event,speed\n"


class EventCsv:
    """Builder of a CSV table with the events of all simulated variants.

    The column `plant` contains the name of the variant, empty for the nominal plant. The column
    `speed` contains the speed just before the event [rad/s | m/s], or 0 if no speed belongs to the
    event.
    """

    def __init__(self) -> None:
        self._parts = [HEAD]

    def add(self, outcome: MechanismOutcome) -> None:
        """Add the events of one variant, in order of time."""
        name = outcome.variant.name
        self._parts += [
            f"{event[0]:.9f},{name},{element_of(outcome.variant, event)},"
            f"{NAMES[int(event[1])]},{event[3]:.9g}\n"
            for event in outcome.out.events
        ]

    @property
    def text(self) -> str:
        """Return the table as CSV text with a header."""
        return "".join(self._parts)
