"""Warnings of a campaign: plants for which its controller was not verified, and example values left in place."""

from __future__ import annotations

from collections.abc import Mapping

from frictool.campaign.drawing.space import Space
from frictool.campaign.playing.playing import Setting, plant_of
from frictool.documents.conditions import DriftPoint, Drifts
from frictool.documents.examples import examples_words
from frictool.documents.scenario import Scenario
from frictool.documents.spread import Spread
from frictool.simulate.plant import Range
from frictool.verify.certified_box import MARGIN_PARAMETERS, outside_message, parameters_outside

Interval = tuple[float, float]


def remarks_of(setting: Setting, space: Space) -> tuple[str, ...]:
    """Return the warnings of a campaign: plants outside the controller's intervals, and example values left in place."""
    bench = plant_of(setting.plant).rig.examples or setting.controller.bench.examples
    words = examples_words({"spec": setting.spec.examples, "bench": bench, "scenario": setting.scenario.examples})
    return (*_uncertified(setting, space), *([words] if words else []))


def _uncertified(setting: Setting, space: Space) -> tuple[str, ...]:
    """Return a warning if the model lies outside the controller's intervals, else one if the draws reach beyond them."""
    plant, controller = plant_of(setting.plant), setting.controller
    intervals = plant.intervals()
    if not intervals:
        return ()
    if found := parameters_outside(controller, intervals):
        return (f"the model {outside_message(controller.name, found)}",)
    if found := parameters_outside(controller, _drawn(plant.ranges(), space, setting.scenario)):
        return (f"draws reach beyond the intervals of {controller.name}, where only their own margins hold: {'; '.join(found)}",)
    return ()


def _drawn(ranges: Mapping[str, Range], space: Space, scenario: Scenario) -> dict[str, Interval]:
    """Return the intervals [SI] of the plants that are drawn, widened by the scenario's drifts and the spread of temperature."""
    varied = {factor.name: (factor.low, factor.high) for factor in space.factors if factor.kind == "plant"}
    given = {name: (quantity.value, quantity.value) for name, quantity in scenario.given.items() if name in MARGIN_PARAMETERS}
    known = {name: (ranges[name].nominal, ranges[name].nominal) for name in MARGIN_PARAMETERS}
    found = known | given | {name: ends for name, ends in varied.items() if name in MARGIN_PARAMETERS}
    drifts, temperature = scenario.drifts or Drifts(), (scenario.spread or Spread()).temperature
    for name, points in (("viscous", drifts.viscous), ("constant", drifts.constant)):
        warm = (1.0,) if temperature is None else (getattr(temperature.cold, name), getattr(temperature.hot, name))
        found[name] = _times(_times(found[name], _factors(points)), warm)
    return found


def _factors(points: tuple[DriftPoint, ...]) -> tuple[float, ...]:
    return tuple(point.factor for point in points) or (1.0,)


def _times(ends: Interval, factors: tuple[float, ...]) -> Interval:
    products = [end * factor for end in ends for factor in factors]
    return min(products), max(products)
