"""`model.yaml`: identified parameters with intervals, the bench, and reasons for missing values."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Annotated, Literal

import msgspec

from frictool.documents.bench import Bench, Name
from frictool.documents.laws import Laws
from frictool.documents.measurement import Measurement
from frictool.documents.presliding import Presliding
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import (
    Axis,
    EffortEstimate,
    InertiaEstimate,
    NonNegativeEffortEstimate,
    PositionSpan,
    PositiveVelocityEstimate,
    TimeEstimate,
    ViscousEstimate,
)
from frictool.documents.resonances import Resonances, Ringing
from frictool.documents.valid_side import ValidSide
from frictool.runtime.object_view import ObjectView

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# module that draws a model; it is above the documents and is imported when a figure is drawn
FIGURE = "frictool.identify.model_page.model_figure"
AxisLaw = Literal["coulomb", "stribeck"]


class Parameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Parameters of J dv/dt = u - offset - viscous v - coulomb sign(v).

    u is the effort and v is the speed. The axis starts to move when |u - offset| exceeds
    `breakaway`. With a Stribeck velocity, the friction decreases from `breakaway` to `coulomb` as
    the speed rises.

    - `inertia`: Total inertia J that the actuator moves.
    - `offset`: Constant effort that opposes a positive drive.
    - `stribeck_velocity`: Speed scale over which the friction decreases from the breakaway to the
      Coulomb friction.
    """

    # (4.17), (4.43); the fall is (2.34)
    inertia: InertiaEstimate
    viscous: ViscousEstimate
    coulomb: NonNegativeEffortEstimate
    breakaway: NonNegativeEffortEstimate
    offset: EffortEstimate
    stribeck_velocity: PositiveVelocityEstimate | None = None

    @property
    def law(self) -> AxisLaw:
        """Return the name of the law that has these parameters: `stribeck` or `coulomb`."""
        return "coulomb" if self.stribeck_velocity is None else "stribeck"


class Fit(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Quality of the fit of the model to the logs of the identification.

    - `force_error`: Rms value of the residual effort, divided by the rms value of the measured
      effort.
    - `condition`: Condition number of the regression.
    - `samples`: Number of samples of the fit.
    - `held_out_force_error`: This key occurs only in models of earlier versions.
    """

    force_error: float | None
    condition: float
    samples: int
    held_out_force_error: float | None = None


class Model(
    ObjectView, msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True
):
    """Identified parameters with intervals, bench, reasons for missing values: `model.yaml`.

    - `law`: `coulomb`, or `stribeck` if `parameters` has a `stribeck_velocity`.
    - `method`: Identification method.
    - `confidence`: Confidence level of the intervals.
    - `parameters`: Parameters of the axis.
    - `not_identified`: Reason for each parameter that the logs do not determine.
    - `fit`: Quality of the fit.
    - `laws`: Friction by direction, speed, position and time at rest, and position-dependent loads.
    - `presliding`: Friction before breakaway, from `identify --loops`. A simulation includes its
      law.
    - `measurement`: Properties of the rig, from `identify --measurement`.
    - `resonances`: Modes of compliant links, from `frictool reduce`. A controller is verified with
      these modes. A model with modes cannot be simulated as a single axis.
    - `ringing`: Oscillation of the position in the logs, after stops or in motion. Margins and
      simulations do not include this oscillation. `synth` and `verify` test each controller with
      plants that consist of two inertias and have this oscillation.
    - `valid_side`: Side of a position on which the model is valid. On the other side, the logs show
      another load.
    - `late_position`: Lag or delay of the position behind the effort, as the logs show it, in
      addition to the lags and delays in the bench. Margins and simulations do not include this
      additional lag. `synth` tests each controller with a drive that has this lag in addition.
    - `logged_positions`: Positions of the logs of sliding motion, if the bench states the travel.
      Elsewhere, load and friction are extrapolated.
    - `bench_values_only`: Reason why no parameter was identified (`identify --keep-bench-values`).
      Every parameter then has the value in bench.yaml, and `synth` does not accept the model.
    """

    format: Literal["model/1"]
    name: Name
    axis: Axis
    law: AxisLaw
    method: str
    confidence: Annotated[float, msgspec.Meta(gt=0, lt=1)]
    bench: Bench
    parameters: Parameters
    provenance: Provenance
    not_identified: dict[str, str] = {}
    fit: Fit | None = None
    laws: Laws | None = None
    presliding: Presliding | None = None
    measurement: Measurement | None = None
    resonances: Resonances | None = None
    ringing: Ringing | None = None
    valid_side: ValidSide | None = None
    late_position: TimeEstimate | None = None
    logged_positions: PositionSpan | None = None
    bench_values_only: str | None = None

    def plot(self) -> Figure:
        """Return a figure of the friction over speed and, if identified, over position."""
        view = importlib.import_module(FIGURE)
        figure: Figure = view.model_figure(self)
        return figure

    def __post_init__(self) -> None:
        if self.law != self.parameters.law:
            raise ValueError(
                f"law: found {self.law}; parameters.stribeck_velocity is required with law "
                "stribeck, and allowed with no other law"
            )
