"""Rig of a bench or mechanism: axis, drive, timing and travel, for controllers and logs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from frictool.documents.bench import Bench
from frictool.documents.laws import FrictionOverTemperature
from frictool.documents.missing_effects import missing_effects, refuse_sensor_lag
from frictool.documents.model import Model
from frictool.documents.quantity import Axis, Span, TimeEstimate
from frictool.documents.valid_side import ValidSide
from frictool.verify.rig_facts import facts_of


@dataclass(frozen=True)
class Rig:
    """Axis, drive, timing and travel of a bench, or of the controlled axis of a mechanism.

    - owner: pattern of the rig's name in messages; {} stands for the name of the document
    - constant: effort per unit of the drive [N m/A, N m/V, N/A, N/V or 1]
    - effort_axis: kind of axis (rotary or linear) on which the drive acts
    - facts: data of the rig in SI, with the names in verify/rig_facts.py
    - examples: keys of the bench that still have the example values of `frictool init`
    - bench_values_only: reason why no parameter of the model was identified, or empty
    - presliding: name of the model's presliding law, or empty
    - missing: warnings about effects that the model lacks
    - valid_side: side of a position on which the model is valid; None if it is valid everywhere
    - logged_positions: positions of the logs from which the model was identified, or None
    - late_position: lag of the position [s] that the logs show and the bench lacks, or None
    - temperature: dependence of the friction on the temperature; None if the model states none
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
    presliding: str = ""
    missing: tuple[str, ...] = ()
    valid_side: ValidSide | None = None
    logged_positions: Span | None = None
    late_position: TimeEstimate | None = None
    temperature: FrictionOverTemperature | None = None

    @property
    def sample_period_s(self) -> float:
        """Return the sample period of the controller [s]."""
        return self.facts["sample_period_s"]

    @property
    def delay_samples(self) -> int:
        """Return the computational delay [samples]."""
        return int(self.facts["delay_samples"])

    @property
    def loop_time_constant_s(self) -> float:
        """Return the time constant of the drive's current or voltage loop [s]."""
        return self.facts["loop_time_constant_s"]

    @property
    def resolution(self) -> float:
        """Return the encoder step [rad | m], 0 for a perfect encoder."""
        return self.facts["encoder_step"]


def rig_of(bench: Bench, model: Model | None = None) -> Rig:
    """Return the rig of a bench; with a model, the rig includes the model's spring on the axis.

    Raises NoSolutionError if the bench has a position sensor with a lag.
    """
    refuse_sensor_lag(bench, "simulations and proofs are valid")
    laws = None if model is None else model.laws
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
        presliding="" if model is None or model.presliding is None else model.presliding.law,
        missing=() if model is None else tuple(missing_effects(model)),
        valid_side=None if model is None else model.valid_side,
        logged_positions=None if model is None else model.logged_positions,
        late_position=None if model is None else model.late_position,
        temperature=None if laws is None else laws.temperature,
    )
