"""One trial of a campaign: a draw played and judged as `simulate` and `report` do."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from frictool.campaign.draws.drawn_scenario import nominal_of, scenario_of
from frictool.campaign.draws.space import FactorSpace, Vector
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, MetricLimit, TrialResult
from frictool.documents.controller import Controller, Number
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError, NoSolutionError
from frictool.logs.log import Log
from frictool.plant.mechanism.assembly import assemble
from frictool.report.judged_loop import JudgedLoop
from frictool.report.requirement import Requirement
from frictool.report.verdict import log_requirements
from frictool.simulate.axis_plant import AxisPlant
from frictool.simulate.closed_loop import StepTest
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.mechanism_plant import MechanismPlant
from frictool.simulate.simulated_plant import SimulatedPlant


class CampaignSetting(NamedTuple):
    """What all trials have in common; it travels to whoever plays them. recorded: the log of a
    scenario that replays one."""

    plant: Model | Mechanism
    controller: Controller
    scenario: Scenario
    spec: Spec
    recorded: Log | None
    names: DocumentNames
    number: Number


class TrialPlayer:
    """Plays draws of `space`, with the noise of `seed`; called with a draw's number and its place
    in the unit cube."""

    def __init__(self, setting: CampaignSetting, space: FactorSpace, seed: int) -> None:
        self.setting, self.space, self.seed = setting, space, seed

    def __getstate__(self) -> dict[str, Any]:
        return {
            "setting": self.setting,
            "space": self.space,
            "seed": self.seed,
        }  # what is made of them is made where it is used

    def __call__(self, job: tuple[int, tuple[float, ...]]) -> TrialResult:
        draw, unit = job
        return self.played(np.array(unit), draw)

    @cached_property
    def test(self) -> StepTest[Any]:
        """The plant under its controller."""
        return StepTest(
            plant_of(self.setting.plant),
            self.setting.controller,
            self.setting.names,
            self.setting.number,
        )

    @cached_property
    def _loop(self) -> JudgedLoop:
        """Return the judge of the margin that the controller's loop has in each trial."""
        return JudgedLoop(self.setting.controller)

    def scenario(self, unit: Vector, noise: int) -> Scenario:
        """What is played at `unit` (d,), with the noise of draw number `noise`."""
        values = self.space.values(unit[None, :])[0]
        return scenario_of(
            self.setting.scenario,
            self.space,
            values,
            (self.seed, noise),
            self.test.plant.rig.resolution,
        )

    def played(self, unit: Vector, draw: int) -> TrialResult:
        """The trial at `unit` (d,); why it could not be simulated is in it, a mistake of ours too:
        it must not take the others along."""
        try:
            return trial_of(draw, self.judged(self.scenario(unit, draw)))
        except FrictoolError as error:
            return TrialResult(draw, (), (), str(error))
        except (ArithmeticError, ValueError, TypeError, LookupError) as error:
            return TrialResult(draw, (), (), f"{type(error).__name__}: {error}")

    def nominal(self) -> tuple[Requirement, ...]:
        """What is found with nothing varied. Raises FrictoolError where that cannot be simulated,
        or the documents do not fit."""
        return self.judged(nominal_of(self.setting.scenario))

    def judged(self, scenario: Scenario) -> tuple[Requirement, ...]:
        """The requirements, in the order of the specification, of a scenario that is played."""
        setting = self.setting
        log = self.test.log(scenario, recorded=setting.recorded, with_speed=False)
        return log_requirements(setting.spec, log, setting.controller.bench, self._loop)


def plant_of(document: Model | Mechanism) -> SimulatedPlant[Any]:
    """What is simulated of a document. Raises WrongElement where a mechanism has no source or no
    sensor for a controller."""
    return (
        AxisPlant(document)
        if isinstance(document, Model)
        else MechanismPlant(document, assemble(document))
    )


def metrics_of(requirements: tuple[Requirement, ...]) -> tuple[MetricLimit, ...]:
    """What trials are judged by."""
    return tuple(
        MetricLimit(one.name, one.key, one.unit, one.limit, one.relation) for one in requirements
    )


def trial_of(draw: int, requirements: tuple[Requirement, ...]) -> TrialResult:
    """Return draw number `draw` with these outcomes."""
    met = tuple(
        UNDECIDED if one.met is None else MET if one.met else BROKEN for one in requirements
    )
    return TrialResult(draw, tuple(_value(one) for one in requirements), met)


def _value(one: Requirement) -> float:
    """inf, or -inf of what has to be large, where it is broken by what is no value of it; nan where
    there is none."""
    within = one.value is None or (
        one.value <= one.limit if one.relation == "<=" else one.value >= one.limit
    )
    if one.met is False and within:
        return math.inf if one.relation == "<=" else -math.inf
    return math.nan if one.value is None else float(one.value)


def check_nominal(
    requirements: tuple[Requirement, ...], names: DocumentNames
) -> tuple[Requirement, ...]:
    """The same. Raises NoSolutionError where the nominal run decides nothing, so that no trial
    would."""
    if all(one.met is None for one in requirements):
        reason = next((one.reason for one in requirements if one.reason), "it has no step")
        raise NoSolutionError(f"{names.scenario}: decides none of the requirements: {reason}")
    return requirements
