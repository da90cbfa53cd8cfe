"""Factors that vary in a campaign, checked against plant, scenario and specification."""

from __future__ import annotations

from msgspec.structs import replace

from frictool.campaign.draws.drawn_scenario import nominal_of
from frictool.campaign.draws.factor_space import FactorSpace, plant_factors, space_of
from frictool.campaign.draws.spread_factors import spread_factors
from frictool.campaign.trials.trial_player import CampaignSetting, plant_of
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.spec import Spec
from frictool.documents.spread import Spread
from frictool.errors import DocumentError
from frictool.simulate.closed_loop import StepTest
from frictool.simulate.document_agreement import refuse
from frictool.simulate.spread_checks import check_spread


def space_of_setting(setting: CampaignSetting) -> FactorSpace:
    """Return the space of the factors that vary in a campaign.

    Raises DocumentError if `spread` does not fit the plant or the scenario, or if nothing varies.
    """
    plant = plant_of(setting.plant)
    scenario = setting.scenario
    reference, _ = StepTest(plant, setting.controller, setting.names).reference(
        nominal_of(scenario), setting.recorded
    )
    # checks the blocks that the scenario names
    plant.check(
        setting.controller, replace(nominal_of(scenario), spread=scenario.spread), setting.names
    )
    check_spread(
        plant,
        setting.controller,
        scenario,
        reference.size * plant.rig.sample_period_s,
        setting.names,
    )
    spread = scenario.spread or Spread()
    space = space_of(
        [
            *plant_factors(plant.ranges(), spread.parameters, scenario.given),
            *spread_factors(scenario),
        ]
    )
    if not space.factors:
        message = (
            f"nothing varies: {setting.names.model} has no ranges; add `spread` to the scenario, "
            "or low and high to values of the bench or mechanism"
        )
        refuse(setting.names.scenario, "spread", message)
    return space


def check_requirements(spec: Spec, name: str) -> None:
    """Raise DocumentError if the specification `name` has no requirement that a run can decide."""
    if all(getattr(spec, key) is None for key in REQUIREMENTS):
        raise DocumentError(
            name,
            (
                "has no requirement that a run can decide; write at least one of "
                f"{', '.join(REQUIREMENTS)}"
            ),
            line=None,
            key="",
        )
