"""Documents of a controller in a folder, and commands on them."""

from __future__ import annotations

import json
from pathlib import Path

from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.documents.writing import to_yaml
from studies.command_line import CommandResult, run
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller
from studies.rigs.verified_controller import truthful

CONTROLLER = truthful(controller())


class ControllerRig:
    """Documents in a folder, and the commands on them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, model: Model, scenario: Scenario, limit: float) -> None:
        spec = clutch_spec(
            modulus_margin=limit,
            rest=None,
            static_error=None,
            oscillations=None,
            overshoot_percent=1e4,
            response_time_95_s=0.55,
        )
        for name, document in {
            "model": model,
            "controller": CONTROLLER,
            "scenario": scenario,
            "spec": spec,
        }.items():
            (self.folder / f"{name}.yaml").write_text(to_yaml(document))

    def simulate(self) -> CommandResult:
        files = [self.folder / f"{name}.yaml" for name in ("model", "controller", "scenario")]
        done = run(
            "simulate",
            files[0],
            "--controller",
            files[1],
            "--scenario",
            files[2],
            "-o",
            self.folder / "run.mcap",
        )
        assert done.code == 0, done.stderr
        return done

    def report(self, *more: str | Path) -> CommandResult:
        paths = [self.folder / name for name in ("run.mcap", "spec.yaml", "controller.yaml")]
        return run("report", paths[0], "--spec", paths[1], "--controller", paths[2], *more)

    def campaign(self, *more: str | Path) -> CommandResult:
        paths = [
            self.folder / f"{name}.yaml" for name in ("model", "controller", "scenario", "spec")
        ]
        return run(
            "campaign",
            *paths[:2],
            "--scenario",
            paths[2],
            "--spec",
            paths[3],
            "--cores",
            "1",
            "-n",
            "12",
            *more,
        )


def margin_of(text: str) -> dict[str, object]:
    (found,) = [one for one in json.loads(text)["requirements"] if one["name"] == "modulus_margin"]
    return found
