"""Mechanism as a simulated plant (simulate/simulated_plant.py), and checks of its scenarios."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from frictool.adapters.mechanism.sources_and_sensors import DRIVE_UNITS
from frictool.documents.controller import Controller
from frictool.documents.mechanism import Mechanism
from frictool.documents.quantity import si_unit
from frictool.documents.scenario import Scenario
from frictool.engine.mechanism.closed_loop import ControlPorts, MechanismInputs
from frictool.errors import FrictoolError
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.plant.mechanism.fastest_link import fastest_link
from frictool.simulate.document_agreement import DocumentNames, disturbances_of, refuse
from frictool.simulate.mechanism_channels import MechanismChannels
from frictool.simulate.mechanism_inputs import inputs_of, mean_efforts
from frictool.simulate.mechanism_parameters import ranges
from frictool.simulate.mechanism_report import metadata_of, warnings_of
from frictool.simulate.mechanism_rig import ControlledAxis, block_positions, rig_of_mechanism
from frictool.simulate.mechanism_runs import MechanismOutcome, MechanismTask, play_all
from frictool.simulate.mechanism_variants import MechanismVariant, mechanism_variants
from frictool.simulate.parameter_order import check_least
from frictool.simulate.scenario_plant_values import check_given
from frictool.simulate.simulated_plant import SimulatedLoop, VariantRun, VariedParameter
from frictool.typing import Vector

FASTEST = 1e4  # largest rate of a link [rad/s] times the sample period
# largest rate of a link [rad/s] times the duration [s]; 1 rad takes some microseconds to simulate
MOST_TURNS = 1e8


class MechanismPlant:
    """Mechanism that implements `SimulatedPlant`, where the methods are documented.

    `watch` is called with the outcome of each variant. Raises ElementError if the mechanism has no
    source or no sensor that a controller can use.
    """

    def __init__(
        self,
        document: Mechanism,
        assembled: AssembledMechanism,
        watch: Callable[[MechanismOutcome], None] = lambda outcome: None,
    ) -> None:
        self.watch = watch
        self.document = document
        self.assembled = assembled
        self.name = document.name
        self.rig, self.controlled = rig_of_mechanism(document, assembled)
        self.width = width_of(assembled)

    def check(
        self, controller: Controller | None, scenario: Scenario, names: DocumentNames
    ) -> None:
        if scenario.is_open:
            refuse(
                names.scenario,
                "duration_s",
                "belongs to a test without a controller; allowed with a controller: steps, or "
                "reference",
            )
        check_mechanism_scenario(
            self.document,
            self.assembled,
            scenario,
            names,
            self.assembled.sources[self.controlled.source],
        )
        if scenario.start is not None:
            try:
                block_positions(
                    self.document,
                    self.assembled,
                    self.controlled.sensor_block,
                    scenario.start.value,
                )
            except ValueError as error:
                refuse(names.scenario, "start", str(error))

    def count(self, controller: Controller, scenario: Scenario) -> int:
        return 1 + (scenario.plants or 0)

    def variants(
        self, controller: Controller, scenario: Scenario, owner: str
    ) -> list[MechanismVariant]:
        return mechanism_variants(self.document, self.assembled, scenario, owner)

    def ranges(self) -> dict[str, VariedParameter]:
        return ranges(self.document)

    def known(self, variant: MechanismVariant) -> Mapping[str, float]:
        """Return an empty mapping, because only a single axis has scheduled parameters."""
        return {}

    def play(
        self, variants: Sequence[MechanismVariant], loop: SimulatedLoop
    ) -> Iterator[tuple[MechanismVariant, VariantRun]]:
        inputs = scenario_inputs(
            self.assembled,
            loop.scenario,
            loop.reference.size,
            self.rig.sample_period_s,
            self.controlled.source_block,
        )
        named = {
            self.assembled.blocks.index(one.on)
            for one in loop.scenario.disturbances
            if one.on is not None
        }
        disturbances = {
            block: effort for block, effort in mean_efforts(inputs).items() if block in named
        }
        channels = MechanismChannels(
            np.arange(loop.reference.size, dtype=np.float64) * self.rig.sample_period_s,
            disturbances,
        )
        tasks = []
        for variant in variants:
            try:
                start = block_positions(
                    variant.document, variant.assembled, self.controlled.sensor_block, loop.start
                )
            except ValueError as error:
                raise FrictoolError(
                    f"{self.name}, plant {variant.name}: the start {error}"
                ) from None
            rig = rig_of_mechanism(variant.document, variant.assembled)[1]
            ports = ports_of(self.controlled.source, rig, self.rig.resolution, start)
            running = loop.running if loop.target is None else None
            common = (
                inputs,
                loop.conditions,
                loop.reference,
                loop.controller.delay_samples,
                running,
                loop.target,
            )
            tasks.append((MechanismTask(loop.reference.size, ports, *common), start))
        for outcome in play_all(variants, tasks, loop.progress):
            self.watch(outcome)
            yield (
                outcome.variant,
                run_of(outcome, channels, [*self._scheduled(loop.controller, outcome)]),
            )

    def linear(self, variant: MechanismVariant, conditions: Vector) -> None:
        """Return None, because margins are defined for a single axis only."""

    def intervals(self, scenario: Scenario) -> Mapping[str, tuple[float, float]]:
        """Return the interval of the drive's constant; other intervals are unknown."""
        constant = self.document.sources[self.assembled.sources[self.controlled.source]].constant
        return {} if constant is None else {"constant": constant.interval}

    def described(self, variant: MechanismVariant) -> str:
        return variant.described()

    def _scheduled(self, controller: Controller, outcome: MechanismOutcome) -> Iterator[str]:
        if controller.schedule is not None and not outcome.variant.name:
            names = ", ".join(controller.schedule.parameters)
            yield (
                f"the controller is scheduled by {names}, which a mechanism does not provide; "
                "the middle of each range is used"
            )


def width_of(assembled: AssembledMechanism) -> float:
    """Return the size of a mechanism's logged data divided by the size for one axis."""
    return 1.0 + len(assembled.blocks) / 3.0


def ports_of(
    source: int, controlled: ControlledAxis, resolution: float, start: Vector
) -> ControlPorts:
    """Return the source, the sensor's block and the load of a controlled mechanism.

    The result also contains the encoder step, the initial positions of sensor's block and load, and
    the speed of the load divided by the speed of the sensor's block.

    - resolution: encoder step [rad | m]
    - start (n,): initial positions of the blocks
    """
    sensor, load = controlled.sensor_block, controlled.load
    return ControlPorts(
        source,
        sensor,
        load,
        resolution,
        float(start[sensor]),
        float(start[load]),
        controlled.load_ratio,
    )


def run_of(
    outcome: MechanismOutcome, channels: MechanismChannels, warnings: Sequence[str]
) -> VariantRun:
    """Return the result of a variant for `SimulatedPlant.play`, with the stream `/mechanism`."""
    stream = channels.stream(outcome.variant, outcome.out.motion, outcome.out.modes)
    return VariantRun(
        outcome.out.record, (stream,), (*warnings_of(outcome), *warnings), metadata_of(outcome)
    )


def scenario_inputs(
    assembled: AssembledMechanism,
    scenario: Scenario,
    samples: int,
    period: float,
    driven: int | None,
) -> MechanismInputs:
    """Return the source signals and block efforts of a scenario.

    Disturbances that name no block act on the block with index `driven`.
    """
    signals = {assembled.sources.index(name): of for name, of in scenario.sources.items()}
    blocks = [
        driven if one.on is None else assembled.blocks.index(one.on)
        for one in scenario.disturbances
    ]
    pairs = [
        (block, one)
        for block, one in zip(blocks, scenario.disturbances, strict=True)
        if block is not None
    ]
    return inputs_of(signals, pairs, len(assembled.sources), samples, period)


def check_pace(assembled: AssembledMechanism, seconds: float, period: float, owner: str) -> None:
    """Raise DocumentError if a link is so stiff that the simulation would take too long.

    - seconds: duration of the scenario [s]
    - period: sample period [s]
    - owner: name of the document in messages
    """
    pace = fastest_link(assembled, explicit=True)
    if pace.rate * period > FASTEST or pace.rate * seconds > MOST_TURNS:
        allowed = (
            f"at most {min(FASTEST / period, MOST_TURNS / seconds):.3g} rad/s in a test of "
            f"{seconds:g} s sampled at {period:g} s"
        )
        refuse(
            owner,
            f"links.{pace.link}",
            f"too stiff or too damped, with a rate of {pace.rate:.3g} rad/s; allowed: {allowed}; "
            "remove its compliance to make the link rigid",
        )


def check_mechanism_scenario(
    document: Mechanism,
    assembled: AssembledMechanism,
    scenario: Scenario,
    names: DocumentNames,
    commanded: str | None,
) -> None:
    """Raise DocumentError if sources, blocks or units of a scenario do not fit the mechanism.

    `commanded`: name of the source that the controller drives; None without a controller.
    """
    check_pace(assembled, scenario.seconds, document.sample_period_s, names.model)
    if scenario.variants == "vertices":
        message = (
            "found vertices, which only a single axis has; allowed for a mechanism: nominal, "
            "random, given"
        )
        refuse(names.scenario, "variants", message)
    if scenario.commands:
        refuse(names.scenario, "commands", "works only with a model of one axis (frictool reduce)")
    check_given(scenario, ranges(document), names)
    if scenario.variants == "random":
        check_least(ranges(document), {}, {}, names, drawn=True)
    for name, signals in scenario.sources.items():
        key = f"sources.{name}"
        if name not in document.sources:
            refuse(
                names.scenario,
                key,
                f"{names.model} has no such source; allowed: "
                f"{', '.join(document.sources) or 'none'}",
            )
        if name == commanded:
            refuse(
                names.scenario,
                key,
                "is commanded by the controller; allowed: signals of other sources, or "
                f"disturbances on {document.sources[name].on}",
            )
        block = assembled.packed.sources.block[assembled.sources.index(name)]
        drive = document.sources[name].drive
        unit = DRIVE_UNITS.get(drive) or si_unit("effort", assembled.kinds[int(block)])
        for index, signal in enumerate(signals):
            if signal.level.unit != unit:
                message = (
                    f"found a multiple of {signal.level.unit}; allowed: {unit} and its multiples, "
                    f"because the drive of {name} is {drive}"
                )
                refuse(names.scenario, f"{key}[{index}].level.unit", message)
    for key, disturbance in disturbances_of(scenario):
        if disturbance.on is None:
            continue
        if disturbance.on not in assembled.blocks:
            refuse(
                names.scenario,
                f"{key}.on",
                f"{names.model} has no block {disturbance.on!r}; allowed: "
                f"{', '.join(assembled.blocks)}",
            )
        unit = si_unit("effort", assembled.kinds[assembled.blocks.index(disturbance.on)])
        if disturbance.effort.unit != unit:
            message = (
                f"found a multiple of {disturbance.effort.unit}; allowed: {unit} and its "
                f"multiples, the units of an effort on {disturbance.on}"
            )
            refuse(names.scenario, f"{key}.effort.unit", message)
