"""What a controller and a log are told of a plant: its axis, drive, timing and travel, as a bench or a mechanism says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from frictool.documents.bench import Bench
from frictool.documents.quantity import Axis, Span


@dataclass(frozen=True)
class Rig:
    """Actuator and encoder in SI, those of the controlled axis of a mechanism.

    owner: the document as messages name it ({} is its name). loop_time_constant_s: lag of the drive. constant: effort per unit
    of the drive; resolution: the encoder's step, 0 of a perfect one [rad | m]; effort_axis: the kind of axis on which the drive acts.
    examples: keys of example values in the bench.
    """

    owner: str
    axis: Axis
    drive: Literal["current", "voltage", "effort"]
    sample_period_s: float
    delay_samples: int
    loop_time_constant_s: float
    constant: float
    resolution: float
    travel: Span | None
    effort_axis: Axis
    examples: tuple[str, ...] = ()


def rig_of(bench: Bench) -> Rig:
    """The rig that a bench describes."""
    return Rig(
        owner="the bench of {}",
        axis=bench.axis,
        drive=bench.actuator.drive,
        sample_period_s=bench.sample_period_s,
        delay_samples=bench.delay_samples,
        loop_time_constant_s=bench.actuator.loop_time_constant_s,
        constant=bench.actuator.constant.value,
        resolution=bench.encoder.resolution,
        travel=bench.mechanics.travel,
        effort_axis=bench.axis,
        examples=bench.examples,
    )
