"""Robotised clutch of configs/clutch: model from the sample logs, controllers, and runs."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.logs.log import Log
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.synth.design import design_controller
from studies.command_line import run_checked

ROOT = Path(__file__).parents[2]
CLUTCH = ROOT / "configs/clutch"
HERE = Provenance("make thesis", "0")
FILTER = 1.5e-3  # s, table 4.5: time constant of the filtered differences of table 4.6


@cache
def spec() -> Spec:
    """Return the specification of 5.4.1."""
    return load(CLUTCH / "spec.yaml", Spec)


def identify_model(folder: Path) -> Path:
    """Identify the clutch from its sample logs as the Makefile does; return the model's path."""
    logs = []
    for name in ("sines", "ramp"):
        logs.append(folder / f"{name}.mcap")
        source = ROOT / f"sample_logs/{name}.csv"
        run_checked("ingest", source, "--bench", CLUTCH / "bench.yaml", "-o", logs[-1])
    model = folder / "model.yaml"
    run_checked("identify", *logs, "--bench", CLUTCH / "bench.yaml", "-o", model)
    return model


@cache
def identified() -> Model:
    """Return the model that `identify_model` writes."""
    with tempfile.TemporaryDirectory() as folder:
        return load(identify_model(Path(folder)), Model)


@cache
def controller(name: str) -> Controller:
    """Return the controller that is designed from designs/NAME.yaml or laws/NAME.yaml."""
    path = next(
        path
        for path in (CLUTCH / f"designs/{name}.yaml", CLUTCH / f"laws/{name}.yaml")
        if path.exists()
    )
    return design_controller(identified(), spec(), load(path, Design), HERE)


def played(name: str, scenario: str) -> Log:
    """Return a run of a controller on the clutch of 4.4 in a scenario of the rig."""
    return simulate_closed_loop(
        load(CLUTCH / "nonlinear.yaml", Model),
        controller(name),
        load(CLUTCH / f"{scenario}.yaml", Scenario),
        HERE,
    )
