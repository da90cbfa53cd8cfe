"""A scenario played to a model or a mechanism: what `frictool simulate` does, on values in
memory."""

from __future__ import annotations

from collections.abc import Callable

from frictool.documents.controller import Controller, Number
from frictool.documents.key_lines import document_error
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.documents.scenario import Scenario
from frictool.errors import DocumentError
from frictool.logs.log import Log
from frictool.plant.mechanism.assembly import assemble
from frictool.plant.mechanism.element_error import ElementError
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.simulate.compiled_target import CompiledTarget
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.mechanism_plant import MechanismPlant
from frictool.simulate.open_loop import simulate_open_loop
from frictool.simulate.simulated_plant import SimulatedPlant, V

DOCUMENTS = DocumentNames()


def simulate(
    plant: Model | Mechanism | SimulatedPlant[V],
    controller: Controller | None,
    scenario: Scenario,
    *,
    recorded: Log | None = None,
    number: Number = "double",
    target: CompiledTarget | None = None,
    provenance: Provenance | None = None,
    names: DocumentNames = DOCUMENTS,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Log:
    """What a bench would have logged: a stream for each variant of the plant, with what only a
    simulation knows.

    controller: None for a mechanism whose sources follow the scenario. recorded: the log that a
    scenario replays. number: the format that the controller runs in; target: compiled code in its
    place. names: what messages call the documents. `progress` is told (done, total). Raises
    InputFileError, DocumentError where the documents do not fit together, LogError where a log
    cannot be replayed, NoSolutionError where a variant cannot be simulated.
    """
    documents = {
        "model": plant if isinstance(plant, Model | Mechanism) else None,
        "controller": controller,
        "scenario": scenario,
    }
    origin = provenance or provenance_of_call("frictool.simulate.simulate", **documents)
    try:
        if controller is None:
            if not isinstance(plant, Mechanism):
                raise DocumentError(
                    names.model,
                    "a model is one axis, which a controller drives; give one",
                    line=None,
                    key="",
                )
            return simulate_open_loop(plant, assemble(plant), scenario, origin, names, progress)
        if isinstance(plant, Mechanism):
            driven = MechanismPlant(plant, assemble(plant), lambda moved: None)
            return simulate_closed_loop(
                driven, controller, scenario, origin, names, progress, recorded, number, target
            )
    except ElementError as wrong:
        raise document_error(names.model, wrong.key, str(wrong)) from None
    return simulate_closed_loop(
        plant, controller, scenario, origin, names, progress, recorded, number, target
    )
