"""`frictool reduce --controller --scenario`: the scenario played to the mechanism and to its one inertia."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from frictool.documents.model import Model
    from frictool.reduce.in_loop import InLoop


def played_in_loop(mechanism: Path, model: Model, controller: Path, scenario: Path, play: float, tolerance: float) -> InLoop:
    """Both logs compared. Raises InputFileError where the documents do not fit, NoSolutionError where one cannot be simulated."""
    import msgspec

    from frictool.cli.mechanism_file import load_mechanism, wrong_in_file
    from frictool.documents.controller import Controller
    from frictool.documents.registry import load
    from frictool.documents.scenario import Scenario
    from frictool.plant.mechanism.wrong import WrongElement
    from frictool.reduce.in_loop import in_loop
    from frictool.simulate.agreement import Names
    from frictool.simulate.mechanism_plant import MechanismPlant
    from frictool.simulate.step_test import step_test

    loaded = load(controller, Controller)
    asked = msgspec.structs.replace(load(scenario, Scenario), variants="nominal", plants=None)
    names = Names(model=str(mechanism), controller=str(controller), scenario=str(scenario))
    try:
        plant = MechanismPlant(*load_mechanism(mechanism))
    except WrongElement as wrong:
        raise wrong_in_file(mechanism, wrong) from None
    whole = step_test(plant, loaded, asked, model.provenance, names)
    one = msgspec.structs.replace(model, resonances=None)
    reduced = step_test(one, loaded, asked, model.provenance, names)
    return in_loop(whole.main, reduced.main, model.bench.encoder.resolution, play, tolerance)
