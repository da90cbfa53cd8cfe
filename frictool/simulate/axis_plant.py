"""Single axis of a model as a simulated plant (simulate/simulated_plant.py)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from frictool.adapters.axis_dynamic_law import assumed_fall, dynamic_law_of
from frictool.adapters.axis_model import axis_of, load_of
from frictool.adapters.parameter_intervals import intervals
from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.scenario import Scenario
from frictool.engine import closed_loop
from frictool.engine.disturbances_and_faults import CONSTANT_FACTOR, VISCOUS_FACTOR, extremes
from frictool.simulate.axis_runs import play
from frictool.simulate.axis_variants import (
    AxisVariant,
    count,
    nominal_levels,
    parameters_of,
    variants_of,
)
from frictool.simulate.document_agreement import DocumentNames, disturbances_of, refuse
from frictool.simulate.rig import rig_of
from frictool.simulate.scenario_plant_values import check_given
from frictool.simulate.scenario_temperature import friction_factors
from frictool.simulate.simulated_plant import SimulatedLoop, VariantRun, VariedParameter
from frictool.typing import Vector
from frictool.verify.logged_plant import LoggedPlant


class AxisPlant:
    """Model of one axis that implements `SimulatedPlant`, where the methods are documented."""

    width = 1.0

    def __init__(self, model: Model) -> None:
        self.model = model
        self.name = model.name
        self.rig = rig_of(model.bench, model)

    def check(
        self, controller: Controller | None, scenario: Scenario, names: DocumentNames
    ) -> None:
        if self.model.resonances is not None:
            links = ", ".join(self.model.resonances.links)
            refuse(
                names.model,
                "resonances",
                f"found resonances of {links}; a simulation as one axis cannot contain resonances; "
                "simulate the mechanism, or the result of `frictool reduce --reduced`",
            )
        for key in ("sources", "duration_s"):
            if getattr(scenario, key):
                refuse(
                    names.scenario,
                    key,
                    f"belongs to a mechanism, but {names.model} is one axis with a controller; "
                    "leave the key out",
                )
        for key, disturbance in disturbances_of(scenario):
            if disturbance.on is not None:
                refuse(
                    names.scenario,
                    f"{key}.on",
                    f"names a block of a mechanism, but {names.model} is one axis; "
                    "leave the key out",
                )
        if self.model.presliding is not None:
            try:
                dynamic_law_of(self.model, axis_of(self.model))
            except ValueError as error:
                refuse(names.model, "presliding", f"cannot be simulated: {error}")
        check_given(scenario, self.ranges(), names)

    def count(self, controller: Controller, scenario: Scenario) -> int:
        return count(self.model, scenario)

    def variants(self, controller: Controller, scenario: Scenario, owner: str) -> list[AxisVariant]:
        return variants_of(self.model, scenario, owner, self.ranges())

    def ranges(self) -> Mapping[str, VariedParameter]:
        return self._ranges

    @cached_property
    def _ranges(self) -> dict[str, VariedParameter]:
        return parameters_of(self.model)

    def known(self, variant: AxisVariant) -> dict[str, float]:
        return {name: variant.values.get(name, value) for name, value in self._levels.items()}

    @cached_property
    def _levels(self) -> dict[str, float]:
        return nominal_levels(self.model)

    def play(
        self, variants: Sequence[AxisVariant], loop: SimulatedLoop
    ) -> Iterator[tuple[AxisVariant, VariantRun]]:
        assumed = assumed_fall(self.model)
        for variant, record in play(variants, loop, load_of(self.model)):
            remarks = [assumed] if assumed and variant is variants[0] else []
            warnings = (*remarks, *self._against_stops(variant, record))
            yield variant, VariantRun(record, warnings=warnings)

    def linear(self, variant: AxisVariant, conditions: Vector) -> LoggedPlant:
        axis = variant.axis
        levels = self.known(variant)
        backward = axis.laws.backward
        slopes = [axis.viscous, *([backward.viscous] if backward else [])]
        slopes += [
            slope for regime in axis.laws.regimes for slope in (regime.forward, regime.backward)
        ]
        constants = [axis.constant]
        if conditions.size:
            slopes = _drifted(slopes, conditions[:, VISCOUS_FACTOR])
            constants = _drifted(constants, conditions[:, CONSTANT_FACTOR])
        return LoggedPlant(
            **levels, slopes=tuple(dict.fromkeys(slopes)), constants=tuple(dict.fromkeys(constants))
        )

    def intervals(self, scenario: Scenario) -> Mapping[str, tuple[float, float]]:
        return intervals(self.model, friction_factors(scenario, self.rig.temperature))

    def described(self, variant: AxisVariant) -> str:
        units = {name: one.unit for name, one in self.ranges().items()}
        return ", ".join(
            f"{name} {value:.6g} {units[name]}" for name, value in variant.values.items()
        )

    def _against_stops(self, variant: AxisVariant, record: Vector) -> Iterator[str]:
        travel = self.rig.travel
        if travel is None:
            return
        position = record[:, closed_loop.TRUE_POSITION]
        lowest, highest = extremes(position)
        if travel.low < lowest and highest < travel.high:
            return
        for wall, against in (
            (travel.low, position <= travel.low),
            (travel.high, position >= travel.high),
        ):
            arrivals = np.flatnonzero(against[1:] & ~against[:-1])
            if arrivals.size:
                first = (arrivals[0] + 1) * self.rig.sample_period_s
                yield (
                    f"{variant.topic} runs against its end stop at {wall:g} {travel.unit}, first "
                    f"at {first:.3f} s"
                )


def _drifted(values: list[float], factors: Vector) -> list[float]:
    return [value * factor for value in values for factor in extremes(factors)]
