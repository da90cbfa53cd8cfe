"""Warnings that a campaign gives before its trials."""

from __future__ import annotations

from typing import Any

from frictool.adapters.temperature_factors import temperature_words
from frictool.campaign.draws.factor_space import FactorSpace
from frictool.campaign.trials.trial_player import CampaignSetting, TrialPlayer, plant_of
from frictool.documents.bench_values import bench_values_words
from frictool.documents.conditions import DriftPoint, Drifts
from frictool.documents.digests import changed_words
from frictool.documents.example_values import examples_words
from frictool.documents.mechanism import Mechanism
from frictool.documents.missing_effects import intolerable_lag
from frictool.documents.model import Model
from frictool.documents.presliding import presliding_words
from frictool.documents.scenario import Scenario
from frictool.documents.spread import Spread
from frictool.simulate.scenario_temperature import friction_factors, simulated_temperature
from frictool.simulate.simulated_plant import SimulatedPlant
from frictool.verify.certified_intervals import (
    MARGIN_PARAMETERS,
    differences,
    outside_message,
    parameters_outside,
)

Interval = tuple[float, float]


def remarks_of(setting: CampaignSetting, space: FactorSpace) -> tuple[str, ...]:
    """Return the warnings about plants, controller, model and scenario.

    There is a warning for

    - plants outside the intervals for which the controller was verified,
    - a controller with blocks that were changed after its verification,
    - a model whose parameters were not identified,
    - a model with a presliding law,
    - a scenario with a temperature,
    - effects that the model lacks,
    - documents with example values.
    """
    plant = plant_of(setting.plant)
    controller = setting.controller
    bench = plant.rig.examples or controller.bench.examples
    reason = plant.rig.bench_values_only
    law = plant.rig.presliding
    warmth = simulated_temperature(setting.scenario, plant.rig.temperature)
    changed = changed_words(controller)
    words = (
        f"{controller.name}: {changed}" if changed else "",
        bench_values_words(f"the model {plant.name}", reason) if reason else "",
        temperature_words(f"the model {plant.name}", warmth) if warmth else "",
        presliding_words(f"the model {plant.name}", law) if law else "",
        *(f"the model {plant.name}: {text}" for text in plant.rig.missing),
        examples_words(
            {"spec": setting.spec.examples, "bench": bench, "scenario": setting.scenario.examples}
        ),
    )
    return (*_uncertified(setting, space), *filter(None, words))


def doubt_of(trial: TrialPlayer) -> str:
    """Return why the axis may fail although the trials pass; "" if there is no reason.

    The possible reasons are:

    - The steps leave the side of a position on which the model is valid.
    - The logs show a lag that the bench does not state and the loop does not tolerate.
    - The axis rings after it stops. This reason is left out if the specification has a modulus
      margin, since the requirement `modulus_margin` then states it.
    """
    setting = trial.setting
    side = plant_of(setting.plant).rig.valid_side
    if side is not None:
        path = trial.reference_range
        if left := side.left_words(setting.spec.axis, *path, "steps"):
            return left
    if isinstance(setting.plant, Model) and (
        reason := intolerable_lag(setting.plant.late_position, setting.controller)
    ):
        return reason
    return trial.margin_doubt if setting.spec.modulus_margin is None else ""


def _uncertified(setting: CampaignSetting, space: FactorSpace) -> tuple[str, ...]:
    plant = plant_of(setting.plant)
    controller = setting.controller
    if deviations := differences(controller, plant.rig.facts, plant.intervals(setting.scenario)):
        return (f"the plant {outside_message(controller.name, deviations)}",)
    if isinstance(setting.plant, Mechanism):
        return ()
    if deviations := parameters_outside(controller, _drawn(plant, space, setting.scenario)):
        return (
            f"draws are outside the intervals for which {controller.name} was verified: "
            f"{'; '.join(deviations)}; only margins computed for each plant are valid",
        )
    return ()


def _drawn(
    plant: SimulatedPlant[Any], space: FactorSpace, scenario: Scenario
) -> dict[str, Interval]:
    varied = {
        factor.name: (factor.low, factor.high) for factor in space.factors if factor.kind == "plant"
    }
    fixed = {
        name: (quantity.value, quantity.value)
        for name, quantity in scenario.given.items()
        if name in MARGIN_PARAMETERS
    }
    ranges = plant.ranges()
    known = {name: (ranges[name].nominal, ranges[name].nominal) for name in MARGIN_PARAMETERS}
    box = known | fixed | {name: ends for name, ends in varied.items() if name in MARGIN_PARAMETERS}
    drifts = scenario.drifts or Drifts()
    temperature = (scenario.spread or Spread()).temperature
    for name, points in (("viscous", drifts.viscous), ("constant", drifts.constant)):
        warm = (
            (1.0,)
            if temperature is None
            else (getattr(temperature.cold, name), getattr(temperature.hot, name))
        )
        box[name] = _times(_times(box[name], _factors(points)), warm)
    factor = friction_factors(scenario, plant.rig.temperature).get("viscous", 1.0)
    box["viscous"] = _times(box["viscous"], (factor,))
    return box


def _factors(points: tuple[DriftPoint, ...]) -> tuple[float, ...]:
    return tuple(point.factor for point in points) or (1.0,)


def _times(ends: Interval, factors: tuple[float, ...]) -> Interval:
    products = [end * factor for end in ends for factor in factors]
    return min(products), max(products)
