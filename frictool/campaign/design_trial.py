"""Test of a designed controller: simulated steps with nominal plant, vertices and drawn plants."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from msgspec import structs

from frictool.campaign.draws.default_scenario import default_scenario
from frictool.campaign.trials.controller_judge import (
    ControllerJudge,
    PlantValues,
    PlayedVerdict,
    plants_of_model,
    with_breakaway,
)
from frictool.documents.controller import Controller
from frictool.documents.key_lines import document_error
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.model import Model
from frictool.documents.quantity import Axis, si_unit
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec
from frictool.synth.search.played_tests import JudgedRuns

# number of plants drawn from the ranges in addition to the vertices; default seed of the draws
DRAWN, SEED = 40, 1
# second test of a design: number of newly drawn plants; (shift of the start, shift of the targets)
# in encoder counts
OTHERS, MOVED = 30, ((0.2, 0.15), (0.35, 0.37), (0.7, 0.6), (0.85, 0.85))
# third test of a design: number of start positions and number of targets within an encoder count;
# number of plants for each requirement
PLACES, TARGETS, WORST = 4, 5, 2
# requirements that an axis violates if it does not reach its target
REACHED = ("response_time_95_s", "rise_time_s", "static_error", "settling_after_profile")
# plants that are simulated first, as ends of the ranges: 1 is the high end, -1 the low end
EXTREMES: tuple[PlantValues, ...] = (
    {"inertia": 1, "constant": -1, "coulomb": 1, "viscous": 1},
    {"inertia": -1, "constant": 1, "coulomb": -1, "viscous": -1},
    {"inertia": 1, "constant": -1, "coulomb": -1, "viscous": -1},
    {"inertia": -1, "constant": 1, "coulomb": 1, "viscous": 1},
)
GOLDEN = 0.6180339887498949  # the multiples of this number, modulo 1, are spread evenly over 0 to 1


@dataclass(frozen=True)
class DesignTest:
    """Test that a designed controller must pass in simulation.

    `scenario`: steps that are simulated with every plant, and the seed of the drawn plants.
    `about`: description of scenario and plants for messages.
    `plants`: for each plant, the values [SI] that differ from the nominal plant.
    `names`: names of the plants by index.
    `starts`: initial positions of the plants [rad | m], at different fractions of an encoder count.
    `vertices`: number n of vertices. In this order, `plants` contains the nominal plant, the n
    vertices, the n vertices again, and drawn plants. The repeated vertices start half an encoder
    count further. If the breakaway has a range, the first n vertices have its upper end, and the
    repeated vertices have its lower end.
    `by_default`: True if `default_scenario` created the scenario.
    """

    model: Model
    spec: Spec
    scenario: Scenario
    about: str
    plants: tuple[PlantValues, ...]
    names: tuple[str, ...]
    starts: tuple[float, ...]
    vertices: int
    by_default: bool

    @cached_property
    def extremes(self) -> tuple[int, ...]:
        """Return the indices in `plants` of extreme vertices, such as the slowest and the fastest.

        EXTREMES states, for each extreme vertex, the range end of each parameter. Without vertices,
        the result is (0,), the nominal plant.
        """
        if not self.vertices:
            return (0,)
        vertices = self.plants[1 : 1 + self.vertices]
        return tuple(
            dict.fromkeys(
                1
                + max(range(len(vertices)), key=lambda k: _likeness(vertices[k], vertices, extreme))
                for extreme in EXTREMES
            )
        )

    @property
    def steps(self) -> str:
        """Return the lengths of the steps, such as "steps of 5 to 50 rad"; "" without steps."""
        lengths = step_lengths(self.scenario)
        return f"steps of {lengths_text(lengths, self.scenario.axis)}" if lengths else ""

    @cached_property
    def judge(self) -> ControllerJudge:
        """Return an object that simulates the scenario with all plants and judges each run."""
        return self.judge_of(self.scenario, self.spec)

    def judges_of_others(self, scenario: Scenario, spec: Spec) -> tuple[ControllerJudge, ...]:
        """Return judges with new random plants and shifted positions: one judge per entry of MOVED.

        An entry of MOVED shifts the start positions and the targets by fractions of an encoder
        count. Each judge simulates the nominal plant, the vertices and OTHERS new random plants. If
        the breakaway has a range, the vertices alternate between judges: upper end of the range for
        the first judge, lower end for the second, and so on.
        """
        drawn: list[PlantValues] = []
        if self.vertices:
            count = DRAWN + OTHERS * len(MOVED)
            drawn += plants_of_model(self.model, self.scenario, random=count)[
                -OTHERS * len(MOVED) :
            ]
        judges = []
        for index, (place, target) in enumerate(MOVED):
            first = 1 + index % 2 * self.vertices
            vertices = self.plants[first : first + self.vertices]
            plants = [self.plants[0], *vertices, *drawn[index :: len(MOVED)]]
            places = [math.fmod(place + k * GOLDEN, 1.0) for k in range(len(plants))]
            judges.append(self.judge_at(scenario, spec, plants, places, target))
        return tuple(judges)

    def judges_of_places(self, scenario: Scenario, spec: Spec) -> tuple[ControllerJudge, ...]:
        """Return TARGETS judges, whose targets are at different fractions of an encoder count.

        Each judge simulates each plant from PLACES initial positions, which are distributed evenly
        within an encoder count. Plant i with initial position k has the index i PLACES + k.
        """
        plants = [plant for plant in self.plants for _ in range(PLACES)]
        return tuple(
            self.judge_at(
                scenario,
                spec,
                plants,
                [(k % PLACES + offset / TARGETS) / PLACES for k in range(len(plants))],
                (offset + 0.5) / TARGETS,
            )
            for offset in range(TARGETS)
        )

    def worst_at_places(
        self,
        judges: Sequence[ControllerJudge],
        controller: Controller,
        found: JudgedRuns,
        until: Callable[[JudgedRuns], bool] | None = None,
    ) -> Iterator[PlayedVerdict]:
        """Simulate the worst plants of a controller with each of `judges`; yield the verdicts.

        The worst plants are, for each requirement, the WORST plants with the smallest reserve.
        `found`: results of the controller on all plants, which contain the reserves.
        `until`: function of the results of a judge so far; if it returns True, this judge ends.
        """
        chosen: dict[tuple[float, ...], int] = {}
        for reserves in np.transpose(found.reserves):
            worst: dict[tuple[float, ...], int] = {}
            for plant in np.argsort(reserves).tolist():
                if not math.isnan(reserves[plant]):
                    worst.setdefault(tuple(self.plants[plant].values()), plant)
            chosen = {**dict(list(worst.items())[:WORST]), **chosen}
        only = [plant * PLACES + place for plant in chosen.values() for place in range(PLACES)]
        for judge in judges:
            yield judge(controller, only, until)

    def judge_at(
        self,
        scenario: Scenario,
        spec: Spec,
        plants: Sequence[PlantValues],
        places: Sequence[float],
        target: float = 0.0,
    ) -> ControllerJudge:
        """Return a judge that simulates `plants` in `scenario` and applies `spec`.

        - places: shift of each plant's start [encoder counts]
        - target: shift of the targets [encoder counts]
        """
        moved = structs.replace(
            scenario, steps=tuple(self._moved(step, target) for step in scenario.steps)
        )
        starts = _starts(self.model, scenario, places)
        return ControllerJudge(self.model, moved, spec, plants, starts=starts)

    def _moved(self, step: Step, target: float) -> Step:
        if step.reference is None:
            return step
        (value,) = _moved_inwards(self.model, step.reference.value, [target])
        return structs.replace(step, reference=structs.replace(step.reference, value=value))

    def judge_of(self, scenario: Scenario, spec: Spec) -> ControllerJudge:
        """Return a judge that simulates this test's plants in `scenario` and applies `spec`."""
        return ControllerJudge(self.model, scenario, spec, self.plants, starts=self.starts)


def has_requirements(spec: Spec) -> bool:
    """Return True if the specification has a requirement."""
    return any(getattr(spec, key) is not None for key in REQUIREMENTS)


def unjudged_target(spec: Spec) -> str:
    """Return a warning if no requirement judges whether the axis reaches its target, else ""."""
    if any(getattr(spec, key) is not None for key in REACHED):
        return ""
    return (
        "no requirement judges whether the axis reaches its target; add one of "
        f"{', '.join(REACHED)} to the specification"
    )


def untested_reason(model: Model, spec: Spec) -> str:
    """Return why controllers of this model cannot be tested; "" if they can be tested."""
    if not has_requirements(spec):
        return "the specification has no requirement"
    if model.resonances is not None:
        return "a model with resonances cannot be simulated as one axis; simulate the mechanism"
    return ""


def design_test(
    model: Model, spec: Spec, scenario: Scenario | None = None, name: str = "scenario"
) -> DesignTest:
    """Return the test that controllers of a model must pass in simulation.

    Parameters
    ----------
    model : Model
        Model of the axis with its ranges.
    spec : Spec
        Requirements on the closed loop; at least one.
    scenario : Scenario, optional
        Steps to simulate; by default the steps of `default_scenario`.
    name : str
        Name of the scenario in messages.

    Raises
    ------
    DocumentError
        If the scenario replays a log.
    """
    if scenario is not None and scenario.reference is not None:
        message = "a controller test cannot replay a log; write steps, or use frictool simulate"
        raise document_error(name, "reference", message)
    steps = default_scenario(model, spec) if scenario is None else scenario
    played = structs.replace(steps, seed=steps.seed or SEED)
    nominal, *vertices = plants_of_model(model, played)
    lowest, highest = (with_breakaway(model, vertices, part) for part in (0.0, 1.0))
    drawn: list[dict[str, float]] = []
    if len(vertices) > 1 or highest != lowest:
        drawn = plants_of_model(model, played, random=DRAWN)[1 + len(vertices) :]
    else:  # without ranges, the only vertex is the nominal plant
        vertices = lowest = highest = []
    plants = [nominal, *highest, *lowest, *drawn]
    places = [0.0] * (1 + len(vertices)) + [0.5] * len(vertices)
    places += [math.fmod(index * GOLDEN, 1.0) for index in range(1, len(drawn) + 1)]
    named = [f"v{index:02d}" for index in range(1, len(vertices) + 1)]
    suffixes = ("", "") if highest == lowest else (", largest breakaway", ", smallest breakaway")
    names = ["nominal plant", *(f"{name}{suffixes[0]}" for name in named)]
    names += [f"{name}{suffixes[1]}, start moved by half an encoder count" for name in named]
    names += [f"drawn plant {index}" for index in range(1, len(drawn) + 1)]
    return DesignTest(
        model,
        spec,
        played,
        _about(played, len(vertices), len(drawn), highest != lowest),
        tuple(plants),
        tuple(names),
        tuple(_starts(model, played, places)),
        len(vertices),
        scenario is None,
    )


def _starts(model: Model, scenario: Scenario, places: Sequence[float]) -> list[float]:
    assert scenario.start is not None
    return _moved_inwards(model, scenario.start.value, places)


def _moved_inwards(model: Model, start: float, places: Sequence[float]) -> list[float]:
    """Return one position for each of `places`: `start`, shifted towards the middle of the travel.

    `places` contains the shifts in encoder counts. On a bench without a travel, the shift is in the
    positive direction.
    """
    travel = model.bench.mechanics.travel
    inwards = -1.0 if travel is not None and start > 0.5 * (travel.low + travel.high) else 1.0
    return [start + inwards * place * model.bench.encoder.resolution for place in places]


def _likeness(plant: PlantValues, plants: Sequence[PlantValues], extreme: PlantValues) -> float:
    total = 0.0
    for name, sign in extreme.items():
        values = [one[name] for one in plants]
        low, high = min(values), max(values)
        total += 0.0 if high == low else sign * (plant[name] - low) / (high - low)
    return total


def _about(scenario: Scenario, vertices: int, drawn: int, ranged: bool) -> str:
    lengths = step_lengths(scenario)
    count = f"{len(lengths)} step{'s' * (len(lengths) > 1)}"
    steps = f"{count} of {lengths_text(lengths, scenario.axis)}, " if lengths else ""
    on = (
        f"nominal plant, {vertices} vertices {'with largest and smallest breakaway ' * ranged}"
        f"from 2 positions within an encoder count, {drawn} drawn plants (seed {scenario.seed})"
    )
    return f"{scenario.name}, {steps}{scenario.seconds:.4g} s; " + (
        on if drawn > 0 else "nominal plant"
    )


def step_lengths(scenario: Scenario) -> list[float]:
    """Return the length of each step of the reference [rad | m]."""
    place = None if scenario.start is None else scenario.start.value
    lengths: list[float] = []
    for step in scenario.steps:
        if step.reference is not None:
            if place is not None and step.reference.value != place:
                lengths.append(abs(step.reference.value - place))
            place = step.reference.value
        elif step.ramp_to is not None:
            place = step.ramp_to.value
        elif step.sine is not None:
            place = None  # the reference ends somewhere in the sine
    return lengths


def lengths_text(lengths: Sequence[float], axis: Axis) -> str:
    """Return the smallest and the largest of `lengths` [rad | m] as text, such as "5 to 50 rad"."""
    low, high = (f"{extreme(lengths):.4g}" for extreme in (min, max))
    return f"{low if low == high else f'{low} to {high}'} {si_unit('position', axis)}"


def longest_step_of(scenario: Scenario) -> float:
    """Return the length of the longest step of a scenario [rad | m]."""
    return max(step_lengths(scenario), default=0.0)
