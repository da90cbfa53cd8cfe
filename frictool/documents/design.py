"""`design.yaml`: structure, method, weights and blocks of a controller to be synthesised."""

from __future__ import annotations

from typing import Annotated, Any, Literal, get_args

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.design_blocks import (
    FeedforwardDesign,
    FrictionCompensationDesign,
    LimiterDesign,
    PositionLawDesign,
    PrefilterDesign,
    ProfileDesign,
    VelocityDesign,
)
from frictool.documents.pid_gains import Pid
from frictool.documents.quantity import Axis
from frictool.documents.struct_fields import fields_of
from frictool.documents.synthesis_methods import METHODS, READ_BY, MethodName, readers
from frictool.documents.weights import Weights
from frictool.runtime.object_view import ObjectView

Structure = Literal["position", "speed_cascade"]
Domain = Literal["continuous", "discrete"]
Scheduled = Literal["inertia", "viscous", "coulomb", "constant", "regime"]

HoldSamples = Annotated[int, msgspec.Meta(ge=0, le=1000)]
DEFAULT_HOLD_SAMPLES = 3  # samples; bridges the loss of single telegrams

NO_STRUCTURE: Any = None  # value if the document lacks the key; the method's structure replaces it
# keys that `relax: auto` reads with every method, because it solves matrix inequalities
READ_BY_TRADE = ("schedule", "vertices", "recentring")


class Poles(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Region in which the closed loop's poles must lie: left of -decay_rad_s, or inside a disc.

    The disc is in the s plane [rad/s] for domain `continuous`, and in the z plane for domain
    `discrete`.

    - `decay_rad_s`: Smallest decay rate of the poles (continuous time).
    - `centre`: Centre of the disc, which lies on the real axis.
    - `radius`: Radius of the disc.
    """

    decay_rad_s: PositiveNumber | None = None
    centre: float | None = None
    radius: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if (self.decay_rad_s is None) == (self.centre is None and self.radius is None) or (
            self.centre is None
        ) != (self.radius is None):
            raise ValueError("poles: give decay_rad_s, or centre and radius of a disc")


class Grid(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Settings of a synthesis whose inequalities are imposed on a grid of parameters.

    - `degree`: Degree of the Lyapunov matrices X and Y in each parameter.
    - `speed_per_s`: Bound of each parameter's rate, in widths of its interval per second; 0 for
      constant parameters.
    - `points`: Initial number of grid points along each parameter.
    """

    degree: Annotated[int, msgspec.Meta(ge=0, le=2)] = 1
    speed_per_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    points: Annotated[int, msgspec.Meta(ge=2, le=9)] = 3


class Design(
    ObjectView,
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    omit_defaults=True,
    kw_only=True,
):
    """Structure, method, weights and blocks of a controller to be synthesised: `design.yaml`.

    An unused key is an error. A key is unused if the method or the structure does not read it. A
    key is also unused if it describes a block without an input, or a block whose output is not
    used.

    - `structure`: `position` is a single loop of the position. `speed_cascade` is a speed loop
      whose reference comes from a position law. Method `auto` needs no structure.
    - `method`: Synthesis method; docs/theory/synth.md compares them.
    - `weights`: Weights of the closed-loop norm. With `{}`, every weight is derived from the
      specification and bench.yaml, and `synth` prints each weight with its origin.
    - `position_law`: Speed reference from the position error; structure `speed_cascade` needs it.
    - `domain`: `discrete`: the controller is designed at the sample period of bench.yaml, with its
      computational delay. `continuous`: the controller is designed in continuous time and
      discretised by Tustin's rule.
    - `prewarp_rad_s`: Frequency at which the discretisation of domain `continuous` is exact. The
      default is 0.
    - `schedule`: Parameters that span the polytope; `regime` is the speed regime (`laws.regimes` of
      the model). The default is only `regime` for a method with an uncertainty channel, and all
      parameters except `regime` for other methods. Parameters that are not listed are at the
      centres of their intervals, or belong to the uncertainty channel.
    - `vertices`: Computation of the plants at the vertices. `exact`: without approximation.
      `inertia`: linearised in the inertia. `first_order`: linearised in all parameters.
    - `frozen_at`: Parameters of the plant for which the controller on the target hardware is
      computed. `centre`: the centres of the intervals. `identified`: the identified values.
    - `scheduled`: True to store also the controllers at the vertices. If the target hardware knows
      the parameters at run time, it can then interpolate between these controllers.
    - `grid`: Settings of a synthesis whose inequalities are imposed on a grid of parameters.
    - `channel_effort`: Effort [N m | N] that corresponds to the signal 1 in the uncertainty
      channel, the second input and output of the plant. The default is half the width of the
      Coulomb friction interval.
    - `poles`: Region in which the closed loop's poles must lie.
    - `order`: Order of the controller. A method that solves matrix inequalities reduces its
      controller to this order.
    - `pole_bound_rad_s`: Largest magnitude of the controller's poles.
    - `integrator`: True for a controller with an integrator. A method that solves matrix
      inequalities then moves the slowest pole of the reduced controller to 0.
    - `relax`: `auto` reduces the weights on disturbance and effort until the bound gamma of the
      norm is 1, but not further. `synth --plot` draws this trade-off.
    - `prefilter`: Low-pass filter of the position reference.
    - `profile`: Profile with bounded jerk from the present position to the reference. A profile
      replaces a prefilter.
    - `feedforward`: Effort that the modelled axis needs to follow its reference; it is added to the
      drive.
    - `velocity`: Source of the speed signal.
    - `limiter`: Block that switches the drive off near the target, for structure `position`.
    - `friction_compensation`: Friction effort that is added to the drive.
    - `pid`: Gains of the PID controller, for method `pid`.
    - `form`: Form of the difference equation that runs on the target hardware: matrices or
      second-order sections.
    - `recentring`: Factor above 1. The matrix inequalities are solved for the bound `recentring`
      times the smallest gamma. Near the smallest gamma itself, the Lyapunov matrices X and Y become
      very large.
    - `ease`: Factor by which the bound gamma is increased, in addition to `recentring`, when the
      controller is computed. A larger factor gives lower gains and more margin.
    - `measurement_hold_samples`: Number of successive samples at which an invalid input is replaced
      by its last valid value. After more invalid samples, the drive becomes 0 and the fault flag is
      set.
    """

    # structures 5.4.3, 5.4.4 and annex C; scheduled: weights (5.46) of the plant (5.64);
    # vertices (5.49), (5.50); frozen_at 5.3.4; integrator 5.4.3.1
    format: Literal["design/1"]
    name: Name
    axis: Axis
    structure: Structure = NO_STRUCTURE
    method: MethodName
    weights: Weights
    position_law: PositionLawDesign | None = None
    domain: Domain = "discrete"
    prewarp_rad_s: PositiveNumber | None = None
    schedule: Annotated[tuple[Scheduled, ...], msgspec.Meta(min_length=1, max_length=5)] | None = (
        None
    )
    vertices: Literal["exact", "inertia", "first_order"] = "exact"
    frozen_at: Literal["centre", "identified"] = "centre"
    scheduled: bool = False
    grid: Grid | None = None
    channel_effort: PositiveNumber | None = None
    poles: Poles | None = None
    order: Annotated[int, msgspec.Meta(ge=1, le=20)] | None = None
    pole_bound_rad_s: PositiveNumber | None = None
    integrator: bool = False
    relax: Literal["no", "auto"] = "no"
    prefilter: PrefilterDesign | None = None
    profile: ProfileDesign | None = None
    feedforward: FeedforwardDesign | None = None
    velocity: VelocityDesign | None = None
    limiter: LimiterDesign | None = None
    friction_compensation: FrictionCompensationDesign | None = None
    pid: Pid | None = None
    form: Literal["state_space", "sos"] = "state_space"
    recentring: Annotated[float, msgspec.Meta(gt=1, le=2)] = 1.1
    ease: Annotated[float, msgspec.Meta(ge=1, le=5)] = 1.0
    measurement_hold_samples: HoldSamples = DEFAULT_HOLD_SAMPLES
    examples: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        searched = METHODS[self.method].searched
        if self.structure is NO_STRUCTURE:
            if not searched:
                raise ValueError(f"structure: missing; allowed: {', '.join(get_args(Structure))}")
            msgspec.structs.force_setattr(self, "structure", METHODS[self.method].structures[0])
        if self.structure == "speed_cascade" and self.position_law is None and not searched:
            raise ValueError("`structure: speed_cascade` needs `position_law`")
        if self.structure == "position" and self.position_law is not None:
            raise ValueError(
                "remove position_law: with `structure: position`, the linear controller takes "
                "the position error"
            )
        if self.prewarp_rad_s is not None and self.domain == "discrete":
            raise ValueError(
                "prewarp_rad_s belongs to domain continuous; a discrete design is not discretised"
            )
        if self.schedule is not None and len(set(self.schedule)) != len(self.schedule):
            raise ValueError("`schedule` names a parameter twice")
        self._unread()
        if self.scheduled and (self.order is not None or "regime" in (self.schedule or ())):
            raise ValueError(
                "`scheduled` cannot be combined with `order`, or with regime in `schedule`"
            )
        structures = METHODS[self.method].structures
        if self.structure not in structures:
            raise ValueError(f"method {self.method} belongs to structure {', '.join(structures)}")
        if self.structure == "speed_cascade" and self.integrator:
            raise ValueError(
                "`integrator` belongs to `structure: position`; in a cascade the linear "
                "controller already receives the integral of the speed error"
            )
        METHODS[self.method].check(self)
        self._blocks()

    @property
    def speed_input(self) -> bool:
        """Return True if the linear controller's input is the speed error.

        Otherwise, the input is eta, a position error.
        """
        return METHODS[self.method].provided_gains and self.structure == "speed_cascade"

    @property
    def reads_speed(self) -> bool:
        """Return True if a block of the controller reads the measured speed."""
        law, limiter, compensation = self.position_law, self.limiter, self.friction_compensation
        return (
            self.speed_input
            or (law is not None and law.action == "brake")
            or (
                limiter is not None
                and (limiter.condition == "energy" or limiter.virtual_coulomb is not None)
            )
            or (compensation is not None and compensation.velocity != "reference")
        )

    def _blocks(self) -> None:
        law, limiter, compensation = self.position_law, self.limiter, self.friction_compensation
        if limiter is not None and self.structure != "position":
            raise ValueError(
                "`limiter` belongs to `structure: position`; in a cascade use position_law.action"
            )
        waits = [
            name
            for name, block in (("position_law", law), ("limiter", limiter))
            if block is not None and block.settled_speed is not None
        ]
        if waits and not self.filters_reference:
            raise ValueError(
                f"{waits[0]}.settled_speed needs a filtered reference, but there is no "
                "`prefilter` and no `profile`; add one of them, or remove settled_speed"
            )
        self._tracking_blocks()
        if (
            law is not None
            and law.action != "none"
            and law.settled_speed is None
            and self.filters_reference
        ):
            raise ValueError(
                f"position_law.settled_speed: missing; action {law.action} waits until the "
                "prefilter is slower than settled_speed"
            )
        if (
            compensation is not None
            and compensation.velocity == "reference"
            and not self.filters_reference
        ):
            raise ValueError(
                "friction_compensation: `velocity: reference` is the speed of the filtered "
                "reference; add `prefilter`"
            )
        if self.form == "sos" and self.scheduled:
            raise ValueError(
                "`form: sos` cannot be combined with `scheduled`; only matrices can be interpolated"
            )
        if self.form == "sos" and limiter is not None:
            raise ValueError(
                "`form: sos` cannot be combined with `limiter`, which keeps the integrator's "
                "state; sections have no such state"
            )

    @property
    def filters_reference(self) -> bool:
        """Return True if a prefilter or a profile filters the reference of the loop."""
        return self.prefilter is not None or self.profile is not None

    def _tracking_blocks(self) -> None:
        if self.profile is not None and self.prefilter is not None:
            raise ValueError("`profile` replaces `prefilter`; remove one of them")
        if self.feedforward is None:
            return
        if self.friction_compensation is not None:
            raise ValueError(
                "feedforward and friction_compensation would both compensate the friction; remove "
                "one of them"
            )
        if self.filters_reference != (self.feedforward.filter_rad_s is None):
            raise ValueError(
                "feedforward.filter_rad_s: needed without prefilter and profile, and not allowed "
                "with one of them"
            )

    def _unread(self) -> None:
        for field in fields_of(type(self)):
            methods = READ_BY.get(field.name, (self.method,))
            present = getattr(self, field.name) != field.default
            if (
                present
                and self.method not in methods
                and not (self.relax == "auto" and field.name in READ_BY_TRADE)
            ):
                several = "methods" if len(methods) > 1 else "method"
                raise ValueError(
                    f"{field.name} belongs to {several} {', '.join(methods)}, not to method "
                    f"{self.method}; remove the key"
                )


Design.__doc__ = f"{Design.__doc__}\n    Keys that only some methods read: {readers()}.\n    "
