"""Events of mechanism runs as rows of a CSV file: breakaways, sticking, contacts and impacts."""

from __future__ import annotations

from frictool.engine.mechanism.events import NAMES
from frictool.simulate.mechanism_runs import MechanismOutcome, element_of

HEAD = "time_s,plant,element,event,speed\n"


class EventCsv:
    """Builder of the table of events of all runs.

    The column `plant` contains the name of the variant, empty for the nominal plant. `speed` is the
    speed before the event [rad/s | m/s], 0 if the event has no speed.
    """

    def __init__(self) -> None:
        self._parts = [HEAD]

    def add(self, moved: MechanismOutcome) -> None:
        """Add the events of one run, in their order."""
        name = moved.variant.name
        self._parts += [
            f"{event[0]:.9f},{name},{element_of(moved.variant, event)},"
            f"{NAMES[int(event[1])]},{event[3]:.9g}\n"
            for event in moved.out.events
        ]

    @property
    def text(self) -> str:
        """Return the table as CSV with a header."""
        return "".join(self._parts)
