"""One plant by its parameters: the one that was drawn, the model where nothing is given, and what
is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of
from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.mechanism import Mechanism
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml
from frictool.errors import DocumentError, FrictoolError
from frictool.logs.log import Log
from frictool.plant.polytope import PARAMETERS
from frictool.simulate.axis_plant import AxisPlant
from frictool.simulate.axis_variants import (
    AxisVariant,
    parameters_of,
    variants_of,
)
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.mechanism_plant import MechanismPlant
from studies.command_line import run
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_scenario import controller, scenario, write_rig
from tests.support.command_line import refused
from tests.support.simulated_mechanisms import GEARED

UNITS = {name: one.unit for name, one in parameters_of(clutch_model()).items()}
HERE = Provenance("a test", "0")


def given(**values: float) -> Log:
    """The run of the clutch with these parameters [SI]."""
    quantities = {name: Quantity(value=value, unit=UNITS[name]) for name, value in values.items()}
    return simulate_closed_loop(
        clutch_model(), controller(), scenario(variants="given", given=quantities), HERE
    )


def test_a_drawn_plant_that_is_given_runs_as_among_the_others() -> None:
    """Alone and without threads, to the last bit."""
    plants = scenario(variants="random", plants=5, seed=2)
    log = simulate_closed_loop(clutch_model(), controller(), plants, HERE)
    for variant, stream in zip(
        variants_of(clutch_model(), plants)[1:], log.streams[1:], strict=True
    ):
        (alone,) = given(**variant.values).streams
        assert alone.topic == "/axis/given"
        for name in ("position", "command", "velocity", "load_position"):
            np.testing.assert_array_equal(alone.signals[name], stream.signals[name])


def test_what_is_not_given_is_the_model_s() -> None:
    model = clutch_model()
    nothing, itself = (
        given().streams[0],
        simulate_closed_loop(model, controller(), scenario(), HERE).streams[0],
    )
    np.testing.assert_array_equal(nothing.signals["position_true"], itself.signals["position_true"])
    parameters = parameters_of(model)
    for name in ("breakaway", "offset", "backlash"):
        value = 1.5 * parameters[name].nominal + 1e-3
        log = given(**{name: value})
        assert log.metadata["plants"] == {"/axis/given": f"{name} {value:.6g} {UNITS[name]}"}
        one = scenario(variants="given", given={name: Quantity(value=value, unit=UNITS[name])})
        assert getattr(variants_of(model, one)[0].axis, name) == value


def test_a_scheduled_controller_is_told_what_is_given_and_else_the_middle() -> None:
    model = clutch_model()
    plant = AxisPlant(model)
    middle = plant.known(AxisVariant("", axis_of(model)))
    given_values = {"coulomb": 0.05, "offset": 1e-3}
    assert plant.known(AxisVariant("given", axis_of(model), given_values)) == middle | {
        "coulomb": 0.05
    }
    assert set(middle) == set(PARAMETERS)


def test_units_are_converted_and_what_is_wrong_is_named(tmp_path: Path) -> None:
    in_millis = scenario(variants="given", given={"coulomb": Quantity(value=50.0, unit="mN m")})
    (found,) = variants_of(clutch_model(), in_millis)
    assert found.values == {"coulomb": pytest.approx(0.05)}
    rig = write_rig(tmp_path)
    for quantity, words in (
        (
            "coulom: {value: 0.1, unit: N m}",
            ("given.coulom", "did you mean 'coulomb'?", "allowed: inertia, viscous"),
        ),
        ("coulomb: {value: 0.1, unit: kg}", ("given.coulomb.unit", "allowed: N m")),
        ("inertia: {value: -1, unit: kg m^2}", ("as given", "inertia is -1; allowed: >= 0")),
        (
            "coulomb: {value: 0.1, unit: N m}, breakaway: {value: 50, unit: mN m}",
            (
                "given.breakaway: found 0.05 N m, below Coulomb friction of 0.1 N m; "
                "allowed: at least the Coulomb friction; if left out, breakaway keeps its ratio",
            ),
        ),
    ):
        text = to_yaml(scenario()).replace(
            "name: steps", f"name: steps\nvariants: given\ngiven: {{{quantity}}}"
        )
        rig["scenario"].write_text(text)
        words_of = [
            "--controller",
            rig["controller"],
            "--scenario",
            rig["scenario"],
            "-o",
            tmp_path / "run.mcap",
        ]
        refused(run("simulate", rig["model"], *words_of), 3, *words)


def test_given_belongs_to_its_variants() -> None:
    with pytest.raises(ValueError, match="belongs to `variants: given`"):
        Scenario(
            "scenario/1",
            "s",
            "rotary",
            start=Quantity(value=0.0, unit="rad"),
            steps=scenario().steps,
            given={"coulomb": Quantity(value=1.0, unit="N m")},
        )


def test_a_mechanism_s_values_are_held_to_what_its_keys_allow(tmp_path: Path) -> None:
    (tmp_path / "geared.yaml").write_text(GEARED)
    document = load(tmp_path / "geared.yaml", Mechanism)
    plant = MechanismPlant(document, assemble(document))
    key = "links.bearing.parameters.coulomb"
    (found,) = plant.variants(
        controller(),
        scenario(variants="given", given={key: Quantity(value=45.0, unit="mN m")}),
        "geared",
    )
    assert found.document.links["bearing"].parameters["coulomb"].value == pytest.approx(0.045)
    assert found.document.blocks == document.blocks
    assert found.document.links["bearing"].parameters["breakaway"].value == pytest.approx(
        1.1 * 0.045
    )  # of which it is a multiple
    both = {
        key: Quantity(value=0.045, unit="N m"),
        key.replace("coulomb", "breakaway"): Quantity(value=44.0, unit="mN m"),
    }
    with pytest.raises(
        DocumentError,
        match=r"breakaway: found 0.044 N m, below links.bearing.parameters.coulomb of 0.045 N m",
    ):
        plant.check(None, scenario(variants="given", given=both), DocumentNames("geared"))
    wrong = scenario(variants="given", given={key: Quantity(value=-0.01, unit="N m")})
    with pytest.raises(
        FrictoolError,
        match=r"geared as given: .*coulomb is -0.01 N m; allowed: a finite number >= 0",
    ):
        plant.variants(controller(), wrong, "geared")
    with pytest.raises(DocumentError, match="geared has no such parameter, did you mean"):
        plant.check(
            None,
            scenario(variants="given", given={key + "b": Quantity(value=0.01, unit="N m")}),
            DocumentNames("geared"),
        )
