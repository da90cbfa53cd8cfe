"""One number of a model or its bench is changed at a time: every change is refused, named, or of a
part that is known to be played only."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest
import yaml

from frictool.documents.laws import Backward, Gravity, Laws, Load, Regime
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate, Quantity
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.errors import FrictoolError
from frictool.verify.model_check import check_model
from studies.command_line import run
from studies.rigs.campaign_rig import played
from studies.rigs.clutch_model import clutch_model
from tests.cli.controller_rig import CONTROLLER, ControllerRig, margin_of
from tests.support.controller_edits import Edit, edits_of_keys

SEED, DRAWN = 20261123, 2
# keys of the four parameters, in the model, its bench and its laws: each end that moves outwards
# leaves the certificate
PARAMETERS = (
    "parameters.inertia", "parameters.viscous", "parameters.coulomb", "bench.mechanics.inertia",
    "bench.mechanics.viscous",
    "bench.mechanics.coulomb", "bench.actuator.constant", "laws.backward",
    "laws.regimes[0].viscous",
)  # fmt: skip
# keys of which every other value is named or refused
FACTS = (
    "bench.sample_period_s", "bench.delay_samples", "bench.actuator.loop_time_constant_s",
    "bench.actuator.limit",
    "bench.encoder.counts_per_revolution", "laws.load.stiffness",
)  # fmt: skip
# keys that the simulation plays and no margin contains, or that say how the model was made and how
# a log is read
PLAYED = (
    "confidence", "parameters.breakaway", "parameters.offset", "laws.regimes[0].above",
    "laws.load.gravity", "bench.mechanics.breakaway",
    "bench.mechanics.backlash", "bench.mechanics.travel", "bench.mechanics.top_speed",
    "bench.columns", "laws.stribeck_exponent",
    "laws.restitution",
)  # fmt: skip


def estimate(low: float, value: float, high: float, unit: str) -> Estimate:
    return Estimate(value=value, low=low, high=high, unit=unit, source="identified")


def model() -> Model:
    """The clutch with friction by direction and regime at the ends of the certificate's intervals,
    and an arm that is not balanced."""
    laws = Laws(
        backward=Backward(
            viscous=estimate(1e-5, 3e-4, 7.62e-4, "N m s/rad"),
            coulomb=estimate(0.018, 0.1, 0.18, "N m"),
        ),
        regimes=(
            Regime(Quantity(value=200.0, unit="rad/s"), estimate(1e-5, 2e-4, 7.62e-4, "N m s/rad")),
        ),
        load=Load(
            gravity=Gravity(estimate(0.0, 0.001, 0.002, "N m"), estimate(0.0, 0.001, 0.002, "N m"))
        ),
    )
    return msgspec.structs.replace(clutch_model(), laws=laws)


def changes() -> Iterator[Edit]:
    """Return the edits that scale each number of the model by 1.5 and by 0.5."""
    return (
        edit
        for edit in edits_of_keys(yaml.safe_load(to_yaml(model())))
        if edit.label.endswith((" x1.5", " x0.5"))
    )


def matters(label: str) -> bool:
    """Return whether the change leaves what the controller was verified for. Raises LookupError for
    a key that nobody has judged."""
    key, _, factor = label.partition(" ")
    if key.startswith(FACTS):
        return True
    if key.startswith(PARAMETERS):
        return (key.endswith(".high") and factor == "x1.5") or (
            key.endswith(".low") and factor == "x0.5" and "viscous" not in key
        )
    if key.startswith(PLAYED):
        return False
    raise LookupError(key)


def answer(folder: Path, edit: Edit) -> str:
    """Return `refused`, `named` or `silent`."""
    path = folder / "model.yaml"
    path.write_text(yaml.safe_dump(edit.document, sort_keys=False))
    try:
        return "named" if check_model(CONTROLLER, load(path, Model)).beyond else "silent"
    except FrictoolError:
        return "refused"


def test_no_single_change_that_matters_is_silent(tmp_path: Path) -> None:
    found = {edit.label: answer(tmp_path, edit) for edit in changes()}
    assert len(found) > 80
    assert [
        label for label, outcome in found.items() if matters(label) and outcome == "silent"
    ] == []
    assert [
        label for label, outcome in found.items() if not matters(label) and outcome == "named"
    ] == []
    assert {"silent", "named", "refused"} == set(found.values())


def test_the_unchanged_model_is_what_the_controller_was_verified_for() -> None:
    assert check_model(CONTROLLER, model()).holds


@pytest.mark.parametrize("index", range(DRAWN))
def test_a_change_that_matters_is_named_by_simulate_and_report(tmp_path: Path, index: int) -> None:
    """Drawn from all of them by a seed, and played from the command line."""
    named = [
        edit for edit in changes() if matters(edit.label) and answer(tmp_path, edit) == "named"
    ]
    edit = named[np.random.default_rng(SEED).choice(len(named), DRAWN, replace=False)[index]]
    rig = ControllerRig(tmp_path)
    rig.write(model(), played(), 0.1)
    (tmp_path / "model.yaml").write_text(yaml.safe_dump(edit.document, sort_keys=False))
    assert "is outside the range " in rig.simulate().stderr, edit.label
    shown = rig.report("--json")
    assert margin_of(shown.stdout)["met"] is None, edit.label
    assert any(
        "is outside the range for which speed was verified" in line
        for line in json.loads(shown.stdout)["warnings"]
    )
    told = run("verify", tmp_path / "controller.yaml", "--model", tmp_path / "model.yaml", "--json")
    assert json.loads(told.stdout)["model"]["holds"] is False
