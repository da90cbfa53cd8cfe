"""Rig for fast campaigns, some milliseconds per trial: a synthetic clutch and one step."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from frictool.campaign.draws.factor_space import plant_factors, space_of
from frictool.campaign.draws.spread_factors import spread_factors
from frictool.campaign.trials.trial_player import CampaignSetting, TrialPlayer, plant_of
from frictool.documents.conditions import DriftPoint, Drifts
from frictool.documents.quantity import Span
from frictool.documents.scenario import Scenario
from frictool.documents.spread import (
    CountBand,
    FactorBand,
    GainBand,
    InstantBand,
    LastingBand,
    Spread,
    SpreadDisturbance,
    SpreadFault,
    Temperature,
    Warmth,
)
from frictool.documents.writing import to_yaml
from frictool.simulate.document_agreement import DocumentNames
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_logs import clutch_spec
from studies.rigs.step_scenario import controller, scenario
from studies.rigs.verified_controller import truthful

EVERYTHING = Spread(
    start=Span(2.0, 9.0, "rad"),
    within_count=True,
    wear=FactorBand(1.0, 1.5),
    temperature=Temperature(Warmth(viscous=1.3), Warmth(viscous=0.7, constant=0.955)),
    sensor_faults=(
        SpreadFault("lost_counts", InstantBand(0.0, 0.5), counts=CountBand(-2, 2)),
        SpreadFault("encoder_stuck", InstantBand(0.1, 0.2), LastingBand(0.01, 0.02)),
        SpreadFault("drive_offset", offset=Span(-0.5, 0.5, "A")),
        SpreadFault("drive_gain", lasts_s=LastingBand(0.1, 0.3), gain_error=GainBand(-0.05, 0.05)),
    ),
    disturbances=(
        SpreadDisturbance(
            "pulse", Span(-0.1, 0.1, "N m"), InstantBand(0.0, 0.4), LastingBand(0.01, 0.05)
        ),
        SpreadDisturbance("step", Span(0.0, 0.01, "N m")),
    ),
)
SLOW_WEAR = Drifts(friction=(DriftPoint(0.0, 1.0), DriftPoint(0.5, 1.2)))


def played(spread: Spread | None = None, **fields: object) -> Scenario:
    """Return a scenario with one step of 0.6 s and noise."""
    settings: dict[str, Any] = {"spread": spread, "drive_noise": 0.05, "seed": 3, **fields}
    return scenario(40.0, **settings)


def trial(spread: Spread | None = EVERYTHING, seed: int = 3, **fields: object) -> TrialPlayer:
    """Return a function that simulates trials of the rig in memory."""
    setting = CampaignSetting(
        clutch_model(),
        truthful(controller()),
        played(spread, **fields),
        clutch_spec(),
        None,
        DocumentNames(),
        "double",
    )
    factors = [
        *plant_factors(plant_of(setting.plant).ranges(), (spread or Spread()).parameters, {}),
        *spread_factors(setting.scenario),
    ]
    return TrialPlayer(setting, space_of(factors), seed)


def write(folder: Path, scenario: Scenario | None = None, **spec: object) -> list[str | Path]:
    """Write the documents of a campaign into `folder`; return the arguments of the command."""
    folder.mkdir(parents=True, exist_ok=True)
    documents: dict[str, msgspec.Struct] = {
        "model": clutch_model(),
        "controller": truthful(controller()),
        "scenario": scenario or played(),
        "spec": clutch_spec(**spec),
    }
    for name, document in documents.items():
        (folder / f"{name}.yaml").write_text(to_yaml(document))
    return [
        "campaign",
        folder / "model.yaml",
        folder / "controller.yaml",
        "--scenario",
        folder / "scenario.yaml",
        "--spec",
        folder / "spec.yaml",
    ]
