"""`design.yaml`: how a controller is to be found: structure, method, weights, and the blocks that
it is composed of."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.design_blocks import (
    FrictionCompensationDesign,
    LimiterDesign,
    Pid,
    PositionLawDesign,
    PrefilterDesign,
    VelocityDesign,
)
from frictool.documents.quantity import Axis
from frictool.documents.weights import Weights

Structure = Literal["position", "speed_cascade"]
Method = Literal["lpv", "lft", "lft_lpv", "lpv_grid", "minimax", "rst", "pid"]
Domain = Literal["continuous", "discrete"]
Scheduled = Literal["inertia", "viscous", "coulomb", "constant", "regime"]

HoldSamples = Annotated[int, msgspec.Meta(ge=0, le=1000)]
HELD = 3  # samples, where a design says nothing: losses of single telegrams are bridged

BY_INEQUALITIES: tuple[Method, ...] = ("lpv", "lft", "lft_lpv", "lpv_grid")
SOUGHT: tuple[Method, ...] = (
    *BY_INEQUALITIES,
    "minimax",
    "rst",
)  # whose controller is searched for, and not given
READ_BY: dict[
    str, tuple[Method, ...]
] = {  # what only some methods read; elsewhere it would be asked for and not done
    "schedule": ("lpv", "lft_lpv", "lpv_grid"),
    "vertices": ("lpv", "lpv_grid"),
    "frozen_at": ("lpv", "lpv_grid"),
    "scheduled": ("lpv", "lft_lpv", "lpv_grid"),
    "grid": ("lpv_grid",),
    "channel_effort": ("lft", "lft_lpv"),
    "poles": BY_INEQUALITIES,  # lpv_grid says itself what to take instead
    "pole_bound_rad_s": ("minimax",),
    "recentring": BY_INEQUALITIES,
    "ease": ("lpv", "lft", "lft_lpv"),
    "domain": SOUGHT,
    "order": SOUGHT,
    "integrator": SOUGHT,
    "relax": SOUGHT,
    "pid": ("pid",),
}
READ_BY_TRADE = (
    "schedule",
    "vertices",
    "recentring",
)  # relax: auto finds the trade with the inequalities of lpv, whatever the method


class Poles(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Where the closed loop's poles have to be: left of -decay_rad_s, or in a disc (in rad/s; of
    the z plane for domain discrete)."""

    decay_rad_s: PositiveNumber | None = None
    centre: float | None = None
    radius: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if (self.decay_rad_s is None) == (self.centre is None and self.radius is None) or (
            self.centre is None
        ) != (self.radius is None):
            raise ValueError("poles: give decay_rad_s, or centre and radius of a disc")


class Grid(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Of method lpv_grid: the degree of X and Y in each parameter, the bound of its motion [widths
    of its interval per s] (0: constant), and the points of the first grid along it."""

    degree: Annotated[int, msgspec.Meta(ge=0, le=2)] = 1
    speed_per_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    points: Annotated[int, msgspec.Meta(ge=2, le=9)] = 3


class Design(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`design.yaml`.

    structure: `position` closes one loop on the position (5.4.3), `speed_cascade` a speed loop
    under a position law (5.4.4, annex C). method: the table in docs/theory/synth.md says when each
    is right. domain: where the method works; a continuous controller is discretised by Tustin,
    exact at `prewarp_rad_s` where that is given. schedule: the parameters that span the polytope of
    an LPV method (lpv, lpv_grid, lft_lpv: without, all but regime; regime in lft_lpv); the others
    stay at their centre, or in the uncertainty channel of lft_lpv. vertices: exact, or linearised
    in the inertia as (5.49), or to first order as (5.50). frozen_at: the plant whose controller
    runs (5.3.4), the centre of the intervals or the identified values. scheduled: the vertices'
    controllers are stored too, to be summed with the plant's weights (5.46), (5.64) where its
    parameters are known while it runs. channel_effort: the unit d of the uncertainty channel [N m
    or N], without: the half-width of the Coulomb friction. order, integrator: of the controller
    itself (minimax, rst), or what it is reduced to, its slow pole moved to 0 (5.4.3.1).
    pole_bound_rad_s: of the controller's poles (minimax). recentring: the inequalities are solved
    at this times the least gamma, where X and Y are small. ease: how much further above it the
    controller itself is taken (lpv, lft, lft_lpv); it is softer there, and has more margin. relax:
    `auto` finds the strictest trade between disturbance rejection and effort that reaches gamma =
    1. pid: the gains of method pid. form: of the difference equation on the target.
    measurement_hold_samples: of the controller document. velocity, limiter, friction_compensation,
    prefilter: blocks around the linear controller. examples: as in bench.yaml.
    """

    format: Literal["design/1"]
    name: Name
    axis: Axis
    structure: Structure
    method: Method
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
    velocity: VelocityDesign | None = None
    limiter: LimiterDesign | None = None
    friction_compensation: FrictionCompensationDesign | None = None
    pid: Pid | None = None
    form: Literal["state_space", "sos"] = "state_space"
    recentring: Annotated[float, msgspec.Meta(gt=1, le=2)] = 1.1
    ease: Annotated[float, msgspec.Meta(ge=1, le=5)] = 1.0
    measurement_hold_samples: HoldSamples = HELD
    examples: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.structure == "speed_cascade" and self.position_law is None:
            raise ValueError("structure speed_cascade needs a position_law")
        if self.structure == "position" and self.position_law is not None:
            raise ValueError(
                "structure position has no position_law: its linear controller takes the position error"
            )
        if self.prewarp_rad_s is not None and self.domain == "discrete":
            raise ValueError(
                "prewarp_rad_s is for domain continuous: a discrete design is not discretised"
            )
        if self.schedule is not None and len(set(self.schedule)) != len(self.schedule):
            raise ValueError("schedule names a parameter twice")
        self._unread()
        if self.scheduled and (self.order is not None or "regime" in (self.schedule or ())):
            raise ValueError(
                "scheduled is without order, over inertia, viscous, coulomb and constant"
            )
        if self.method == "rst" and self.structure != "position":
            raise ValueError("method rst is for structure position")
        if self.structure == "speed_cascade" and self.integrator:
            raise ValueError(
                "integrator is for structure position: a speed loop measures the integral of its error already"
            )
        self._pid()
        self._blocks()

    @property
    def reads_speed(self) -> bool:
        """Whether a block of it sees the measured speed."""
        law, limiter, compensation = self.position_law, self.limiter, self.friction_compensation
        return (
            (self.method == "pid" and self.structure == "speed_cascade")
            or (law is not None and law.action == "brake")
            or (
                limiter is not None
                and (limiter.condition == "energy" or limiter.virtual_coulomb is not None)
            )
            or (compensation is not None and compensation.velocity != "reference")
        )

    def _pid(self) -> None:
        """Raises ValueError where the gains are not those of the structure."""
        if self.method != "pid":
            return
        if self.pid is None:
            raise ValueError("method pid needs pid, the gains that it is given")
        if (self.structure == "position") != (self.pid.gain is not None):
            raise ValueError(
                "pid: structure position takes gain (effort per position), structure speed_cascade speed_gain (effort per speed)"
            )
        if self.structure == "speed_cascade" and self.weights != Weights():
            raise ValueError(
                "weights: method pid weighs no speed loop, what is verified is its sensitivity; write weights: {}"
            )

    def _blocks(self) -> None:
        """Raises ValueError where a block is asked for that nothing reads, or that the structure
        has no place for."""
        law, limiter, compensation = self.position_law, self.limiter, self.friction_compensation
        if limiter is not None and self.structure != "position":
            raise ValueError(
                "limiter is for structure position: in a cascade position_law.action does its work"
            )
        waits = [
            name
            for name, block in (("position_law", law), ("limiter", limiter))
            if block is not None and block.settled_speed is not None
        ]
        if waits and self.prefilter is None:
            raise ValueError(
                f"{waits[0]}.settled_speed is the prefilter's: give prefilter too, or leave it out"
            )
        if (
            law is not None
            and law.action != "none"
            and law.settled_speed is None
            and self.prefilter is not None
        ):
            raise ValueError(
                f"position_law.settled_speed: missing; action {law.action} waits until the prefilter moves slower than it"
            )
        if (
            compensation is not None
            and compensation.velocity == "reference"
            and self.prefilter is None
        ):
            raise ValueError(
                "friction_compensation.velocity reference is the filtered reference's speed: give prefilter too"
            )
        if self.form == "sos" and self.scheduled:
            raise ValueError(
                "form sos is without scheduled: only matrices are summed with weights (5.64)"
            )
        if self.form == "sos" and limiter is not None:
            raise ValueError(
                "form sos is without limiter: in sections no state is the integrator's alone, to be frozen meanwhile (5.2.2)"
            )

    def _unread(self) -> None:
        """Raises ValueError where a key is given that the method does not read."""
        for field in msgspec.structs.fields(self):
            methods = READ_BY.get(field.name, (self.method,))
            asked = getattr(self, field.name) != field.default
            if (
                asked
                and self.method not in methods
                and not (self.relax == "auto" and field.name in READ_BY_TRADE)
            ):
                several = "methods" if len(methods) > 1 else "method"
                raise ValueError(
                    f"{field.name} is for {several} {', '.join(methods)}, and method is {self.method}; leave it out"
                )
