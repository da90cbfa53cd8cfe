"""Loop of a controller with the plants of simulated logs: its margins, and whether the controller was verified for their model."""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.logs.log import Log
from frictool.verify.certified_box import outside_message, parameters_outside
from frictool.verify.plant_margins import PlantMargins
from frictool.verify.played_plant import INTERVALS, RECORD, PlayedPlant, intervals_of_text

NO_PLANT = "the log does not describe its plant as one axis (a mechanism, or an older log); try `frictool reduce` and `verify --model`"
RECORDED = "the plant of a recorded axis is not known"


class JudgedLoop:
    """Margins of one controller around the plants that logs describe."""

    def __init__(self, controller: Controller) -> None:
        self.controller, self._margins = controller, PlantMargins(controller)
        self._beyond: dict[tuple[tuple[str, str], ...], str] = {}

    def margin(self, log: Log, topic: str) -> tuple[float | None, str]:
        """Return the modulus margin at the plant of a stream, 0 if the loop is unstable; or None and the reason."""
        if log.metadata.get("log", {}).get("kind") != "simulated":
            return None, RECORDED
        plant = PlayedPlant.of_text(log.metadata.get(RECORD, {}).get(topic, ""))
        return (None, NO_PLANT) if plant is None else (self._margins(plant), "")

    def beyond(self, log: Log) -> str:
        """Say how the log's model lies outside the intervals for which the controller was verified; empty if it does not."""
        record = log.metadata.get(INTERVALS, {})
        key = tuple(record.items())
        if key not in self._beyond:
            found = parameters_outside(self.controller, intervals_of_text(record))
            self._beyond[key] = f"the model {outside_message(self.controller.name, found)}" if found else ""
        return self._beyond[key]
