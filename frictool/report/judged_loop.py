"""Closed loop of a controller with the simulated plants of logs, for margins and warnings."""

from __future__ import annotations

from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.logs.log import Log
from frictool.plant.parameter_box import enclosing_box
from frictool.plant.polytope import PARAMETERS
from frictool.verify.certified_intervals import (
    bench_differences,
    differences,
    outside_message,
    parameters_outside,
)
from frictool.verify.logged_plant import INTERVALS, RECORD, LoggedPlant, intervals_of_text
from frictool.verify.plant_margins import PlantMargins
from frictool.verify.rig_facts import RECORD as FACTS
from frictool.verify.rig_facts import facts_of_text, missing_facts

NO_PLANT = (
    "the log does not describe its plant as one axis (a mechanism, or an older log); try "
    "`frictool reduce` and `verify --model`"
)
RECORDED = "the plant of a recorded axis is not known"


class JudgedLoop:
    """Closed loop of one controller with the plants that simulated logs describe.

    `bench`: bench of recorded logs; None if it is the controller's bench. `doubt`: reason why the
    margins may be wrong for every plant, or "".
    """

    def __init__(self, controller: Controller, bench: Bench | None = None, doubt: str = "") -> None:
        self.controller = controller
        self._margins = PlantMargins(controller)
        self._bench = (
            ""
            if bench is None
            else self._words(f"the bench {bench.name}", bench_differences(controller, bench))
        )
        self._beyond: dict[tuple[tuple[str, str], ...], str] = {}
        self.doubt = doubt

    def margin(self, log: Log, topic: str) -> tuple[float | None, str]:
        """Return (modulus margin, "") for the plant of the stream `topic`, or (None, reason).

        The margin of an unstable loop is 0.
        """
        if not _simulated(log):
            return None, RECORDED
        plant = LoggedPlant.of_text(log.metadata.get(RECORD, {}).get(topic, ""))
        return self.margin_of(plant, unstated_words(log))

    def margin_of(self, plant: LoggedPlant | None, unstated: str = "") -> tuple[float | None, str]:
        """Return (modulus margin, "") for a simulated plant, or (None, reason).

        `unstated`: reason why the plant's bench is unknown; "" if the bench is known.
        """
        if plant is None or not plant.is_possible:
            return None, NO_PLANT
        return (None, unstated) if unstated else (self._margins(plant), "")

    def beyond(self, log: Log) -> str:
        """Return text on the `doubt` and on differences between a log's rig and the verified rig.

        If the log's rig is unknown, no difference is reported. The text may be empty.
        """
        return "; ".join(one for one in (self._different(log), self.doubt) if one)

    def _different(self, log: Log) -> str:
        if not _simulated(log):
            return self._bench
        rig, record = log.metadata.get(FACTS, {}), log.metadata.get(INTERVALS, {})
        key = (*rig.items(), *record.items())
        if key not in self._beyond:
            deviations = differences(self.controller, facts_of_text(rig), intervals_of_text(record))
            self._beyond[key] = self._words("the plant", deviations)
        return self._beyond[key]

    def played_beyond(self, log: Log) -> str:
        """Return text on simulated plant parameters outside the intervals of the verification.

        A scenario can set such values by its key `given` or by a drift. The text is empty if all
        parameters are within the intervals of the verification.
        """
        texts = log.metadata.get(RECORD, {}).values() if _simulated(log) else ()
        plants = [plant for plant in map(LoggedPlant.of_text, texts) if plant is not None]
        points = [point for plant in plants for point in plant.points()]
        outside = parameters_outside(self.controller, enclosing_box(points)) if points else ()
        words = (
            "simulated plants are outside the intervals for which "
            f"{self.controller.name} was verified: {'; '.join(outside)}; only margins computed for "
            "each plant are valid"
        )
        return words if outside else ""

    def _words(self, subject: str, deviations: tuple[str, ...]) -> str:
        return (
            f"{subject} {outside_message(self.controller.name, deviations)}" if deviations else ""
        )


def _simulated(log: Log) -> bool:
    return log.metadata.get("log", {}).get("kind") == "simulated"


def unstated_words(log: Log) -> str:
    """Return a message on rig and model data that a simulated log lacks; '' if it is complete."""
    facts, ranges = (
        facts_of_text(log.metadata.get(FACTS, {})),
        intervals_of_text(log.metadata.get(INTERVALS, {})),
    )
    lacking = [
        *missing_facts(facts),
        *(f"interval of {name}" for name in PARAMETERS if name not in ranges),
    ]
    if not lacking:
        return ""
    command = log.metadata.get("provenance", {}).get("command", "frictool simulate")
    return (
        f"an earlier version wrote the log without the {', '.join(lacking)}; write it again: "
        f"{command} -o {log.source}"
    )
