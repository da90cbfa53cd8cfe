"""Controller and scenario of the clutch, for tests of the step test."""

from __future__ import annotations

from pathlib import Path

import msgspec

from frictool.documents.controller import Controller
from frictool.documents.quantity import Quantity
from frictool.documents.scenario import Scenario, Step
from frictool.documents.writing import to_yaml
from studies.rigs.clutch_model import clutch_model
from studies.rigs.example_controllers import clutch_controller, speed_controller


def controller() -> Controller:
    """Return the example's PI without anti-windup, with two vertices.

    The vertices are opposite corners of the clutch model's ranges.
    """
    made = clutch_controller(
        speed=msgspec.structs.replace(speed_controller(), anti_windup=(0.0, 0.0))
    )
    light = made.verified.vertices[0]
    heavy = msgspec.structs.replace(
        light, name="heavy", inertia=1.53e-5, viscous=7.62e-4, coulomb=0.18, constant=12.8e-3
    )
    light = msgspec.structs.replace(
        light, name="light", inertia=1.11e-5, viscous=0.0, coulomb=0.018, constant=14.0e-3
    )
    verified = msgspec.structs.replace(made.verified, vertices=(light, heavy))
    return msgspec.structs.replace(made, verified=verified)


def scenario(
    *targets: float, seconds: float = 0.6, start: float = 5.0, **fields: object
) -> Scenario:
    """Return a scenario with steps of equal duration to `targets` [rad]."""
    steps = tuple(
        Step(Quantity(value=target, unit="rad"), seconds) for target in targets or (40.0, 10.0)
    )
    made = Scenario(
        format="scenario/1",
        name="steps",
        axis="rotary",
        start=Quantity(value=start, unit="rad"),
        steps=steps,
    )
    return msgspec.structs.replace(made, **fields)


def write_rig(folder: Path) -> dict[str, Path]:
    """Write model.yaml, controller.yaml and scenario.yaml into `folder`."""
    documents: dict[str, msgspec.Struct] = {
        "model": clutch_model(),
        "controller": controller(),
        "scenario": scenario(variants="vertices", drive_noise=0.05),
    }
    paths = {name: folder / f"{name}.yaml" for name in documents}
    for name, document in documents.items():
        paths[name].write_text(to_yaml(document))
    return paths
