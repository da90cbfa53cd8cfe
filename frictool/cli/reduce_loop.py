"""`frictool reduce --controller --scenario`: closed-loop comparison of mechanism and model."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from frictool.documents.model import Model
    from frictool.reduce.loop_comparison import LoopComparison


def compare_in_loop(
    mechanism: Path, model: Model, controller: Path, scenario: Path, play: float, tolerance: float
) -> LoopComparison:
    """Simulate the mechanism and the model under the controller; compare the logs.

    - play: width of the backlash [rad | m]
    - tolerance: largest allowed value of two relative differences: of the positions, divided by the
      step of the reference, and of the response times, divided by the mechanism's response time

    Raises InputFileError if the documents do not fit together, and NoSolutionError if the mechanism
    or the model cannot be simulated.
    """
    import msgspec

    from frictool.cli.mechanism_file import load_mechanism, mechanism_error
    from frictool.documents.controller import Controller
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario
    from frictool.plant.mechanism.element_error import ElementError
    from frictool.reduce.loop_comparison import in_loop
    from frictool.simulate.closed_loop import simulate_closed_loop
    from frictool.simulate.document_agreement import DocumentNames
    from frictool.simulate.mechanism_plant import MechanismPlant

    loaded = load(controller, Controller)
    nominal = msgspec.structs.replace(load(scenario, Scenario), variants="nominal", plants=None)
    names = DocumentNames(model=str(mechanism), controller=str(controller), scenario=str(scenario))
    try:
        plant = MechanismPlant(*load_mechanism(mechanism))
    except ElementError as wrong:
        raise mechanism_error(mechanism, wrong) from None
    whole = simulate_closed_loop(plant, loaded, nominal, model.provenance, names)
    one = msgspec.structs.replace(model, resonances=None)
    reduced = simulate_closed_loop(one, loaded, nominal, model.provenance, names)
    return in_loop(whole.main, reduced.main, model.bench.encoder.resolution, play, tolerance)
