"""A scenario played to a model or a mechanism: what `frictool simulate` does, on values in memory."""

from __future__ import annotations

from collections.abc import Callable

from frictool.documents.controller import Controller, Number
from frictool.documents.lines import complaint
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, called
from frictool.documents.scenario import Scenario
from frictool.errors import DocumentError
from frictool.logs.log import Log
from frictool.plant.mechanism.assembly import assemble
from frictool.plant.mechanism.wrong import WrongElement
from frictool.simulate.agreement import Names
from frictool.simulate.mechanism_plant import MechanismPlant
from frictool.simulate.open_test import open_test
from frictool.simulate.plant import Plant, V
from frictool.simulate.step_test import step_test
from frictool.simulate.target import Target

DOCUMENTS = Names()


def simulate(
    plant: Model | Mechanism | Plant[V],
    controller: Controller | None,
    scenario: Scenario,
    *,
    recorded: Log | None = None,
    number: Number = "double",
    target: Target | None = None,
    provenance: Provenance | None = None,
    names: Names = DOCUMENTS,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Log:
    """What a bench would have logged: a stream for each variant of the plant, with what only a simulation knows.

    controller: None for a mechanism whose sources follow the scenario. recorded: the log that a scenario replays. number: the format that
    the controller runs in; target: compiled code in its place. names: what messages call the documents. `progress` is told (done, total).
    Raises InputFileError, DocumentError where the documents do not fit together, LogError where a log cannot be replayed, NoSolutionError
    where a variant cannot be simulated.
    """
    documents = {"model": plant if isinstance(plant, Model | Mechanism) else None, "controller": controller, "scenario": scenario}
    origin = provenance or called("frictool.simulate.simulate", **documents)
    try:
        if controller is None:
            if not isinstance(plant, Mechanism):
                raise DocumentError(names.model, "a model is one axis, which a controller drives; give one", line=None, key="")
            return open_test(plant, assemble(plant), scenario, origin, names, progress)
        if isinstance(plant, Mechanism):
            driven = MechanismPlant(plant, assemble(plant), lambda moved: None)
            return step_test(driven, controller, scenario, origin, names, progress, recorded, number, target)
    except WrongElement as wrong:
        raise complaint(names.model, wrong.key, str(wrong)) from None
    return step_test(plant, controller, scenario, origin, names, progress, recorded, number, target)
