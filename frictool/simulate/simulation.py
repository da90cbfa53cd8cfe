"""Python function that simulates documents in memory, as `frictool simulate` does with files."""

from __future__ import annotations

from collections.abc import Callable

from frictool.documents.controller import Controller
from frictool.documents.key_lines import document_error
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.documents.scenario import Scenario
from frictool.errors import DocumentError
from frictool.logs.log import Log
from frictool.simulate.closed_loop import PLAIN, SimulationRequest, simulate_closed_loop
from frictool.simulate.document_agreement import DOCUMENTS, DocumentNames
from frictool.simulate.simulated_plant import SimulatedPlant, V


def simulate(
    plant: Model | Mechanism | SimulatedPlant[V],
    controller: Controller | None,
    scenario: Scenario,
    request: SimulationRequest = PLAIN,
    *,
    provenance: Provenance | None = None,
    names: DocumentNames = DOCUMENTS,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Log:
    """Simulate a scenario and return its log.

    The log has one stream per variant of the plant, with the channels of a bench and true signals.

    Parameters
    ----------
    plant : Model, Mechanism or SimulatedPlant
        Plant of the simulation.
    controller : Controller or None
        Controller document; None for a mechanism whose sources follow the scenario.
    scenario : Scenario
        Scenario document. With a controller, the scenario has a reference; without a controller,
        it has signals of the sources.
    request : SimulationRequest
        Log to replay, number format of the controller, and compiled code; allowed only with a
        controller.
    provenance : Provenance, optional
        Origin that the log states; by default, the call of this function.
    names : DocumentNames
        Names of the documents in messages.
    progress : callable
        Function that receives the completed and the total number of variants, or of samples if a
        mechanism has a single variant.

    Returns
    -------
    Log
        Simulated log with warnings.

    Raises
    ------
    InputFileError, DocumentError
        If the documents do not fit together.
    LogError
        If a log cannot be replayed.
    NoSolutionError
        If a variant cannot be simulated.
    """
    documents = {
        "model": plant if isinstance(plant, Model | Mechanism) else None,
        "controller": controller,
        "scenario": scenario,
    }
    origin = provenance or provenance_of_call("frictool.simulate.simulate", **documents)
    if isinstance(plant, Mechanism):
        return _simulate_mechanism(plant, controller, scenario, request, origin, names, progress)
    if controller is None:
        raise DocumentError(
            names.model,
            "a model cannot be simulated without a controller; give a controller",
            line=None,
            key="",
        )
    return simulate_closed_loop(plant, controller, scenario, origin, names, progress, request)


def _simulate_mechanism(
    plant: Mechanism,
    controller: Controller | None,
    scenario: Scenario,
    request: SimulationRequest,
    origin: Provenance,
    names: DocumentNames,
    progress: Callable[[int, int], None],
) -> Log:
    # imported here, because an axis does not need the engine of mechanisms
    from frictool.adapters.mechanism.assembly import assemble
    from frictool.plant.mechanism.element_error import ElementError
    from frictool.simulate.mechanism_plant import MechanismPlant
    from frictool.simulate.open_loop import simulate_open_loop

    try:
        assembled = assemble(plant)
        if controller is None:
            return simulate_open_loop(plant, assembled, scenario, origin, names, progress)
        driven = MechanismPlant(plant, assembled, lambda outcome: None)
        return simulate_closed_loop(driven, controller, scenario, origin, names, progress, request)
    except ElementError as wrong:
        raise document_error(names.model, wrong.key, str(wrong)) from None
