"""Judge of controllers: it simulates fixed plants in one scenario, and checks the requirements.

    judge = ControllerJudge(plant, scenario, spec, plants)      prepared once
    verdict = judge(controller)                                 values and reserves of each plant

A search for a controller calls the judge once per candidate. Plants, reference, disturbances and
noise are the same for all candidates, so that their results can be compared.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from msgspec.structs import replace

from frictool.campaign.draws.drawn_scenario import nominal_of
from frictool.campaign.trials.trial_player import (
    CampaignSetting,
    ScenarioJudge,
    plant_of,
)
from frictool.campaign.trials.trials import MET, UNDECIDED, Marks, MetricLimit, TrialResult
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.mechanism import Mechanism
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.model import Model
from frictool.documents.quantity import Quantity, si_unit
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.errors import FrictoolError
from frictool.report.requirement import Requirement
from frictool.report.worst_hold import limit_of
from frictool.runtime.object_view import ResultView
from frictool.simulate.axis_variants import breakaway_at, parameters_of, variants_of
from frictool.simulate.document_agreement import DocumentNames
from frictool.typing import Vector

PlantValues = Mapping[str, float]  # parameter (a key of `given` in a scenario) -> value [SI]


@dataclass(frozen=True)
class PlayedRequirement:
    """Requirement, and the worst value of its metric on the simulated plants.

    Attributes
    ----------
    metric : MetricLimit
        Name, key, unit and limit of the requirement.
    value : float
        Worst value in SI (ratios in %). The value is infinite if a plant fails without a number (an
        axis that never settles), and NaN if no plant has a value.
    reserve : float
        Relative distance of the worst value to the limit (`relative_reserve`), negative for a
        violation.
    plant : int
        Index of the plant with this value; -1 if no plant has a value.
    met : bool or None
        True if every plant meets the limit, False if a plant violates it, else None.
    """

    metric: MetricLimit
    value: float
    reserve: float
    plant: int
    met: bool | None


@dataclass(frozen=True, eq=False, repr=False)
class PlayedVerdict(ResultView):
    """Results of one controller with p plants for r requirements.

    Attributes
    ----------
    metrics : tuple of MetricLimit
        Requirements that a run can decide, in the order of the specification.
    plants : tuple of int
        Indices of the simulated plants.
    values, reserves : ndarray, shape (p, r)
        Worst value in each run in SI, and relative distance of this value to the limit; NaN if
        undecided.
    met : ndarray, shape (p, r)
        MET 1, BROKEN 0 or UNDECIDED -1.
    failed : mapping
        Reason for each plant that could not be simulated, by the plant's index. The values of such
        a plant are NaN.
    speeds : ndarray, shape (p,)
        Largest speed in each run [rad/s | m/s]; 0 if the plant could not be simulated.
    """

    metrics: tuple[MetricLimit, ...]
    plants: tuple[int, ...]
    values: Vector
    reserves: Vector
    met: Marks
    failed: Mapping[int, str]
    speeds: Vector

    @property
    def requirements(self) -> tuple[PlayedRequirement, ...]:
        """Return the worst value of each requirement, in the order of the specification."""
        return tuple(self._worst(index) for index in range(len(self.metrics)))

    @property
    def reserve(self) -> float:
        """Return the smallest reserve of all requirements.

        The reserve is -inf if a plant could not be simulated, NaN if no requirement is decided.
        """
        if self.failed:
            return -math.inf
        known = self.reserves[~np.isnan(self.reserves)]
        return float(known.min()) if known.size else math.nan

    @property
    def passed(self) -> bool:
        """Return True if all plants were simulated, and no limit is violated.

        At least one limit must be met; other requirements may be undecided.
        """
        return not self.failed and not np.any(self.met == 0) and bool(np.any(self.met == MET))

    def _worst(self, index: int) -> PlayedRequirement:
        met = self.met[:, index]
        reserves = self.reserves[:, index]
        known = ~np.isnan(reserves)
        decided = True if np.all(met == MET) else False if np.any(met == 0) else None
        if not known.any():
            return PlayedRequirement(self.metrics[index], math.nan, math.nan, -1, decided)
        row = int(np.argmin(np.where(known, reserves, np.inf)))
        value = float(self.values[row, index])
        return PlayedRequirement(
            self.metrics[index], value, float(reserves[row]), self.plants[row], decided
        )


class ControllerJudge:
    """Judge of controllers on fixed plants in one scenario.

    Parameters
    ----------
    plant : Model or Mechanism
        The nominal plant.
    scenario : Scenario
        The test; its `variants`, `plants` and `spread` are not used.
    spec : Spec
        The requirements.
    plants : sequence of mappings
        For each plant, the values [SI] that differ from the nominal plant, by name; an empty
        mapping is the nominal plant. `plants_of_model` returns vertices and random plants of a
        model.
    number : {"double", "float", "q31"}
        Number format of the controllers.
    starts : sequence of float, optional
        Initial position of each plant [rad | m]; by default the scenario's start.
    """

    def __init__(
        self,
        plant: Model | Mechanism,
        scenario: Scenario,
        spec: Spec,
        plants: Sequence[PlantValues],
        number: ProgramNumber = "double",
        starts: Sequence[float] | None = None,
    ) -> None:
        self.plant = plant
        self.spec = spec
        self.number = number
        base = nominal_of(scenario)
        units = {name: one.unit for name, one in plant_of(plant).ranges().items()}
        initial = [base.start] * len(plants)
        if starts is not None:
            unit = si_unit("position", base.axis)
            initial = [Quantity(value=start, unit=unit) for start in starts]
        self.scenarios = tuple(
            replace(
                base,
                start=initial[index],
                variants="given",
                given={
                    **base.given,
                    **{name: Quantity(value=v, unit=units[name]) for name, v in values.items()},
                },
                seed=base.seed + index,
            )
            for index, values in enumerate(plants)
        )
        self.metrics = tuple(
            MetricLimit(
                metric.requirement_name,
                key,
                metric.unit(spec),
                limit_of(spec, key),
                ">=" if key == "modulus_margin" else "<=",
            )
            for key, metric in REQUIREMENTS.items()
            if getattr(spec, key) is not None
        )

    def __call__(
        self,
        controller: Controller,
        only: Sequence[int] | None = None,
        until: Callable[[PlayedVerdict], bool] | None = None,
    ) -> PlayedVerdict:
        """Return the results of a controller on the plants.

        Parameters
        ----------
        controller : Controller
            The candidate.
        only : sequence of int, optional
            Indices of the plants to simulate, in this order; by default all.
        until : callable, optional
            Function that is called after each plant with the results up to this plant. If it
            returns True, the remaining plants are not simulated.

        Raises
        ------
        FrictoolError
            If plant, controller and scenario do not fit together.
        """
        chosen = tuple(range(len(self.scenarios)) if only is None else only)
        judge = self._judge_of(controller)
        judge.test.reference(self.scenarios[0])  # raises the errors that do not depend on the plant
        trials: list[TrialResult] = []
        speeds: list[float] = []
        for number, plant in enumerate(chosen, start=1):
            trials.append(self._played(judge, plant))
            speeds.append(0.0 if trials[-1].failed else judge.speed)
            if until is not None and until(
                verdict := self._verdict(chosen[:number], trials, speeds)
            ):
                return verdict
        return self._verdict(chosen, trials, speeds)

    def reference_range(self, controller: Controller) -> tuple[float, float]:
        """Return the lowest and the highest position [rad | m] of the reference and the start."""
        return self._judge_of(controller).reference_range

    def located(self, controller: Controller, plant: int) -> tuple[Requirement, ...]:
        """Return the requirements of one plant, with the step in which each value is worst."""
        return self._judge_of(controller).judged(self.scenarios[plant])

    def _judge_of(self, controller: Controller) -> ScenarioJudge:
        return ScenarioJudge(
            CampaignSetting(
                self.plant,
                controller,
                self.scenarios[0],
                self.spec,
                None,
                DocumentNames(),
                self.number,
            )
        )

    def _played(self, judge: ScenarioJudge, plant: int) -> TrialResult:
        try:
            return judge.trial(plant, self.scenarios[plant])
        except FrictoolError as error:
            return TrialResult(plant, (), (), str(error))

    def _verdict(
        self, plants: tuple[int, ...], trials: Sequence[TrialResult], speeds: Sequence[float]
    ) -> PlayedVerdict:
        shape = (len(plants), len(self.metrics))
        values = np.full(shape, math.nan)
        met = np.full(shape, UNDECIDED, dtype=np.int8)
        for row, trial in enumerate(trials):
            if not trial.failed:
                values[row], met[row] = trial.metric_values, trial.met
        reserves = np.array(
            [
                [relative_reserve(one, value) for one, value in zip(self.metrics, row, strict=True)]
                for row in values
            ]
        ).reshape(shape)
        failed = {trial.draw: trial.failed for trial in trials if trial.failed}
        return PlayedVerdict(self.metrics, plants, values, reserves, met, failed, np.array(speeds))


def relative_reserve(metric: MetricLimit, value: float) -> float:
    """Return the distance of a value to the metric's limit, divided by the limit.

    The distance is 0 at the limit, negative for a violation, and NaN if there is no value. If the
    limit is 0, the absolute distance is returned.
    """
    inside = metric.limit - value if metric.relation == "<=" else value - metric.limit
    return inside / metric.limit if metric.limit > 0.0 else inside


def plants_of_model(model: Model, scenario: Scenario, random: int = 0) -> list[dict[str, float]]:
    """Return the nominal plant, the vertices of the model's ranges, and random plants.

    The vertices have the model's ratio of breakaway to Coulomb friction. If the breakaway has a
    range, the random plants have a random breakaway within this range.

    Parameters
    ----------
    model : Model
        The model with its ranges.
    scenario : Scenario
        Scenario with the seed of the random plants.
    random : int
        Number of random plants. The first plants do not change when more are drawn with the same
        seed.

    Returns
    -------
    list of dict
        Values of each plant [SI] by name; empty for the nominal plant.
    """
    base = replace(scenario, variants="nominal", given={}, plants=None)
    played = variants_of(model, replace(base, variants="vertices"))
    if random:
        played += variants_of(model, replace(base, variants="random", plants=random))[1:]
    return [dict(variant.values) for variant in played]


def with_breakaway(
    model: Model, plants: Sequence[PlantValues], part: float
) -> list[dict[str, float]]:
    """Return copies of the plants with the breakaway at `part` of its range.

    `part` is 0 (low end) to 1 (high end). The range depends on the value `coulomb` of the plant,
    which each plant must contain. Without a range of the breakaway, the plants stay unchanged.
    """
    coulomb = np.array([plant["coulomb"] for plant in plants])
    breakaway = breakaway_at(parameters_of(model), coulomb, np.full(len(plants), part))
    if breakaway is None:
        return [dict(plant) for plant in plants]
    return [
        {**plant, "breakaway": float(value)} for plant, value in zip(plants, breakaway, strict=True)
    ]
