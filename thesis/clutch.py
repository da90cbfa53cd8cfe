"""The robotised clutch as configs/clutch has it: its model from the sample logs, controllers of its
designs, and runs of them."""

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
from tests.cli.run import run

ROOT = Path(__file__).parents[1]
RIG = ROOT / "configs/clutch"
HERE = Provenance("make thesis", "0")
FILTER = 1.5e-3  # s, table 4.5: of the differences that table 4.6 is found with


@cache
def spec() -> Spec:
    """The specification of 5.4.1."""
    return load(RIG / "spec.yaml", Spec)


@cache
def identified() -> Model:
    """The model that the rig's Makefile identifies from its sample logs, by the commands
    themselves."""
    with tempfile.TemporaryDirectory() as name:
        folder, logs = Path(name), []
        for log in ("sines", "ramp"):
            logs.append(folder / f"{log}.mcap")
            done(
                "ingest",
                ROOT / f"sample_logs/{log}.csv",
                "--bench",
                RIG / "bench.yaml",
                "-o",
                logs[-1],
            )
        done("identify", *logs, "--bench", RIG / "bench.yaml", "-o", folder / "model.yaml")
        return load(folder / "model.yaml", Model)


def done(*words: str | Path) -> str:
    """What a frictool command says. Raises RuntimeError where it does not end with 0."""
    result = run(*words)
    if result.code != 0:
        raise RuntimeError(f"frictool {words[0]} ended with {result.code}: {result.stderr}")
    return result.stdout


@cache
def controller(name: str) -> Controller:
    """Of designs/NAME.yaml, or of laws/NAME.yaml."""
    path = next(
        path for path in (RIG / f"designs/{name}.yaml", RIG / f"laws/{name}.yaml") if path.exists()
    )
    return design_controller(identified(), spec(), load(path, Design), HERE)


def played(name: str, scenario: str) -> Log:
    """A controller on the clutch of 4.4 in a scenario of the rig."""
    return simulate_closed_loop(
        load(RIG / "nonlinear.yaml", Model),
        controller(name),
        load(RIG / f"{scenario}.yaml", Scenario),
        HERE,
    )
