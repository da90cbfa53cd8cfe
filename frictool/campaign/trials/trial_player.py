"""Simulation of one draw of a campaign (a trial), and judgement of the run by the specification."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from frictool.adapters.mechanism.assembly import assemble
from frictool.campaign.draws.drawn_scenario import nominal_of, scenario_of
from frictool.campaign.draws.factor_space import FactorSpace
from frictool.campaign.trials.trials import BROKEN, MET, UNDECIDED, MetricLimit, TrialResult
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.engine.closed_loop import TRUE_VELOCITY
from frictool.errors import FrictoolError, NoSolutionError
from frictool.logs.log import Log
from frictool.report.requirement import Requirement
from frictool.report.run_metrics import RunRecord
from frictool.report.verdict import RunJudge
from frictool.simulate.axis_plant import AxisPlant
from frictool.simulate.closed_loop import StepTest
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.mechanism_plant import MechanismPlant
from frictool.simulate.simulated_plant import SimulatedPlant
from frictool.typing import Vector
from frictool.verify.ringing_loop import ringing_doubt


class CampaignSetting(NamedTuple):
    """Data that all trials share; every worker process receives this data once.

    `recorded`: log that the scenario replays; None if the scenario replays no log.
    """

    plant: Model | Mechanism
    controller: Controller
    scenario: Scenario
    spec: Spec
    recorded: Log | None
    names: DocumentNames
    number: ProgramNumber


class ScenarioJudge:
    """Simulation and judgement of scenarios with one plant and one controller.

    `speed`: largest true speed in the last trial [rad/s | m/s].
    """

    speed = 0.0

    def __init__(self, setting: CampaignSetting) -> None:
        self.setting = setting

    @cached_property
    def test(self) -> StepTest[Any]:
        """Return the closed loop of plant and controller, prepared for any scenario."""
        return StepTest(
            plant_of(self.setting.plant),
            self.setting.controller,
            self.setting.names,
            self.setting.number,
        )

    @property
    def reference_range(self) -> tuple[float, float]:
        """Return the lowest and the highest position [rad | m] of the reference and the start."""
        reference, start = self.test.reference(self.setting.scenario, self.setting.recorded)
        return min(start, float(reference.min())), max(start, float(reference.max()))

    @cached_property
    def _judge(self) -> RunJudge:
        records = self.test.rig_records(self.setting.scenario)
        return RunJudge(self.setting.spec, self.setting.controller, records, self.margin_doubt)

    @cached_property
    def margin_doubt(self) -> str:
        """Return "": this class knows no reason why the modulus margins may be wrong."""
        return ""

    def judged(self, scenario: Scenario) -> tuple[Requirement, ...]:
        """Simulate a scenario; return the judged requirements in the order of the specification."""
        (run,) = self.test.runs(scenario, self.setting.recorded)
        return self._judge(scenario.name, self.test.stream(run), run.plant)

    def trial(self, index: int, scenario: Scenario) -> TrialResult:
        """Simulate a scenario; return the result with `index` as the index of the draw."""
        (run,) = self.test.runs(scenario, self.setting.recorded)
        self.speed = float(np.abs(run.record[:, TRUE_VELOCITY]).max())
        sensors = run.prepared.sensors
        outcomes = None
        if self._is_plain and not scenario.commands:
            record = RunRecord(
                sensors.time,
                run.prepared.loop.reference,
                run.record,
                run.prepared.conditions,
                sensors.drive_noise(run.number),
            )
            outcomes = self._judge.outcomes(record, run.plant)
        if outcomes is None:
            return trial_of(index, self._judge(scenario.name, self.test.stream(run), run.plant))
        return TrialResult(
            index,
            tuple([value for value, _ in outcomes]),
            tuple([_mark(met) for _, met in outcomes]),
        )

    @cached_property
    def _is_plain(self) -> bool:
        rig, spec = self.test.plant.rig, self.setting.spec
        return rig.axis == spec.axis and rig.drive == spec.drive


class TrialPlayer(ScenarioJudge):
    """Simulation and judgement of draws of `space`, with noise from `seed`."""

    def __init__(self, setting: CampaignSetting, space: FactorSpace, seed: int) -> None:
        super().__init__(setting)
        self.space, self.seed = space, seed

    @cached_property
    def margin_doubt(self) -> str:
        """Return the reason why the modulus margins may be wrong (ringing); "" without a reason."""
        return ringing_doubt(self.setting.controller)

    def __getstate__(self) -> dict[str, Any]:
        return {
            "setting": self.setting,
            "space": self.space,
            "seed": self.seed,
        }  # each process builds the cached objects again

    def __call__(self, job: tuple[int, tuple[float, ...]]) -> TrialResult:
        """Simulate the draw `job` = (index, point (d,) of the unit cube); return the result."""
        draw, unit = job
        return self.played(np.array(unit), draw)

    def scenario(self, unit: Vector, noise: int) -> Scenario:
        """Return the scenario at `unit` (d,) in the unit cube, with the noise of draw `noise`."""
        values = self.space.values(unit[None, :])[0]
        return scenario_of(
            self.setting.scenario,
            self.space,
            values,
            (self.seed, noise),
            self.test.plant.rig.resolution,
        )

    def played(self, unit: Vector, draw: int) -> TrialResult:
        """Simulate the plant at the point `unit` (d,) of the unit cube, with the noise of `draw`.

        Return the result. An error does not stop the campaign; its message is stored in `failed` of
        the result.
        """
        try:
            return self.trial(draw, self.scenario(unit, draw))
        except FrictoolError as error:
            return TrialResult(draw, (), (), str(error))
        except (ArithmeticError, ValueError, TypeError, LookupError) as error:
            return TrialResult(draw, (), (), f"{type(error).__name__}: {error}")

    def nominal(self) -> tuple[Requirement, ...]:
        """Simulate the scenario without its `spread`; return the judged requirements.

        The plant is the nominal plant, changed by the values `given` of the scenario. Raises
        FrictoolError if the plant cannot be simulated, or if the documents do not fit together.
        """
        return self.judged(nominal_of(self.setting.scenario))


def plant_of(document: Model | Mechanism) -> SimulatedPlant[Any]:
    """Return the plant that a document describes, for simulation.

    Raises ElementError if a mechanism has no source or no sensor for a controller.
    """
    return (
        AxisPlant(document)
        if isinstance(document, Model)
        else MechanismPlant(document, assemble(document))
    )


def metrics_of(requirements: tuple[Requirement, ...]) -> tuple[MetricLimit, ...]:
    """Return the metric and the limit of each requirement."""
    return tuple(
        MetricLimit(one.name, one.key, one.unit, one.limit, one.relation) for one in requirements
    )


def trial_of(draw: int, requirements: tuple[Requirement, ...]) -> TrialResult:
    """Return the judged requirements of the draw with the index `draw` as a TrialResult."""
    met = tuple(_mark(one.met) for one in requirements)
    return TrialResult(draw, tuple(_value(one) for one in requirements), met)


def _mark(met: bool | None) -> int:
    return UNDECIDED if met is None else MET if met else BROKEN


def _value(one: Requirement) -> float:
    """Return the value of a requirement; NaN if there is no value.

    If the requirement failed, but its value is missing or within the limit, return +inf (-inf for
    a requirement with a lower limit).
    """
    within = one.value is None or (
        one.value <= one.limit if one.relation == "<=" else one.value >= one.limit
    )
    if one.met is False and within:
        return math.inf if one.relation == "<=" else -math.inf
    return math.nan if one.value is None else float(one.value)


def check_nominal(
    requirements: tuple[Requirement, ...], names: DocumentNames
) -> tuple[Requirement, ...]:
    """Return the nominal plant's `requirements`; raise NoSolutionError if all are undecided."""
    if all(one.met is None for one in requirements):
        reason = next((one.reason for one in requirements if one.reason), "it has no step")
        raise NoSolutionError(
            f"{names.scenario}: every requirement is undecided on the nominal plant: {reason}"
        )
    return requirements
