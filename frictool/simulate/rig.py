"""What a controller and a log are told of a plant: its axis, drive, timing and travel, as a bench
or a mechanism says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.quantity import Axis, Span
from frictool.verify.rig_facts import facts_of


@dataclass(frozen=True)
class Rig:
    """Actuator and encoder in SI, those of the controlled axis of a mechanism.

    owner: the document as messages name it ({} is its name). constant: effort per unit of the
    drive; effort_axis: the kind of axis on which the drive acts. facts: numbers that a controller
    is verified with (verify/rig_facts.py). examples: keys of example values in the bench.
    bench_values_only: the reason why nothing of the model was identified, or empty.
    """

    owner: str
    axis: Axis
    drive: Literal["current", "voltage", "effort"]
    constant: float
    travel: Span | None
    effort_axis: Axis
    facts: Mapping[str, float]
    examples: tuple[str, ...] = ()
    bench_values_only: str = ""

    @property
    def sample_period_s(self) -> float:
        """Return the sample period of the controller."""
        return self.facts["sample_period_s"]

    @property
    def delay_samples(self) -> int:
        """Return the computational delay."""
        return int(self.facts["delay_samples"])

    @property
    def loop_time_constant_s(self) -> float:
        """Return the time constant of the drive."""
        return self.facts["loop_time_constant_s"]

    @property
    def resolution(self) -> float:
        """Return the encoder's step [rad | m], 0 of a perfect encoder."""
        return self.facts["encoder_step"]


def rig_of(bench: Bench, model: Model | None = None) -> Rig:
    """Return the rig that a bench describes; with a model, whose bench it is, also the spring on
    its axis."""
    return Rig(
        owner="the bench of {}",
        axis=bench.axis,
        drive=bench.actuator.drive,
        constant=bench.actuator.constant.value,
        travel=bench.mechanics.travel,
        effort_axis=bench.axis,
        facts=facts_of(bench, model),
        examples=bench.examples,
        bench_values_only=(None if model is None else model.bench_values_only) or "",
    )
