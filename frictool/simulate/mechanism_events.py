"""The events of runs of mechanisms as rows of a text file: what breaks away, sticks, touches,
strikes, and when."""

from __future__ import annotations

from frictool.engine.mechanism.events import NAMES
from frictool.simulate.mechanism_runs import MechanismOutcome, element_of

HEAD = "time_s,plant,element,event,speed\n"


class EventCsv:
    """Gathers them, run by run. time_s in s; plant empty for the nominal one; speed before the
    event, rad/s or m/s, 0 where it has none."""

    def __init__(self) -> None:
        self._parts = [HEAD]

    def add(self, moved: MechanismOutcome) -> None:
        """The events of one run, in their order."""
        name = moved.variant.name
        self._parts += [
            f"{event[0]:.9f},{name},{element_of(moved.variant, event)},{NAMES[int(event[1])]},{event[3]:.9g}\n"
            for event in moved.out.events
        ]

    @property
    def text(self) -> str:
        """The whole table, as CSV with a head."""
        return "".join(self._parts)
