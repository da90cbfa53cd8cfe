"""`design.yaml`: how a controller is to be found: structure, method, weights, position law."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from frictool.documents.bench import Name, PositiveNumber
from frictool.documents.quantity import Axis, PositiveLength, PositiveVelocity
from frictool.documents.weights import Weights

Structure = Literal["position", "speed_cascade"]
Method = Literal["lpv", "lft", "lft_lpv", "lpv_grid", "minimax", "rst"]
Domain = Literal["continuous", "discrete"]
Scheduled = Literal["inertia", "viscous", "coulomb", "constant", "regime"]

BY_INEQUALITIES: tuple[Method, ...] = ("lpv", "lft", "lft_lpv", "lpv_grid")
READ_BY: dict[str, tuple[Method, ...]] = {  # what only some methods read; elsewhere it would be asked for and not done
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
}
READ_BY_TRADE = ("schedule", "vertices", "recentring")  # relax: auto finds the trade with the inequalities of lpv, whatever the method


class PositionLaw(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The square-root law (5.19), annex (5), and what happens inside its band.

    formula: `sqrt(2F/J)` is annex (5), `sqrt(F/J)` is annex 5.2 (lower by sqrt 2). virtual_coulomb replaces F by F_cv > F_c (annex 3.1).
    action: `cut` sets the drive to zero inside the band; `brake` keeps the loop closed with a speed reference of zero until the
    measured speed is below `rest_speed`, then sets the drive to zero. Either waits until the prefilter moves slower than `settled_speed`.
    """

    formula: Literal["sqrt(2F/J)", "sqrt(F/J)"]
    band: PositiveLength
    action: Literal["cut", "brake"]
    settled_speed: PositiveVelocity
    rest_speed: PositiveVelocity | None = None
    virtual_coulomb_factor: Annotated[float, msgspec.Meta(ge=1)] = 1.0
    speed_filter_rad_s: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if self.action == "brake" and (self.rest_speed is None or self.speed_filter_rad_s is None):
            raise ValueError("action brake needs rest_speed and speed_filter_rad_s")


class Prefilter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Second-order low-pass of the position reference (5.69)."""

    natural_frequency_rad_s: PositiveNumber
    damping: PositiveNumber


class Poles(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Where the closed loop's poles have to be: left of -decay_rad_s, or in a disc (in rad/s; of the z plane for domain discrete)."""

    decay_rad_s: PositiveNumber | None = None
    centre: float | None = None
    radius: PositiveNumber | None = None

    def __post_init__(self) -> None:
        if (self.decay_rad_s is None) == (self.centre is None and self.radius is None) or (self.centre is None) != (self.radius is None):
            raise ValueError("poles: give decay_rad_s, or centre and radius of a disc")


class Grid(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Of method lpv_grid: the degree of X and Y in each parameter, the bound of its motion [widths of its interval per s] (0: constant),
    and the points of the first grid along it."""

    degree: Annotated[int, msgspec.Meta(ge=0, le=2)] = 1
    speed_per_s: Annotated[float, msgspec.Meta(ge=0)] = 0.0
    points: Annotated[int, msgspec.Meta(ge=2, le=9)] = 3


class Design(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """`design.yaml`.

    structure: `position` closes one loop on the position (5.4.3), `speed_cascade` a speed loop under the square-root law (5.4.4, annex C).
    method: the table in docs/theory/synth.md says when each is right.
    domain: where the method works; a continuous controller is discretised by Tustin, exact at `prewarp_rad_s` where that is given.
    schedule: the parameters that span the polytope of an LPV method (lpv, lpv_grid, lft_lpv: without, all but regime; regime in lft_lpv);
    the others stay at their centre, or in the uncertainty channel of lft_lpv. vertices: exact, or linearised in the inertia as (5.49), or
    to first order as (5.50). frozen_at: the plant whose controller runs (5.3.4), the centre of the intervals or the identified values.
    scheduled: the vertices' controllers are stored too, to be summed with the plant's weights (5.46), (5.64) where its parameters are
    known while it runs.
    channel_effort: the unit d of the uncertainty channel [N m or N], without: the half-width of the Coulomb friction.
    order, integrator: of the controller itself (minimax, rst), or what it is reduced to, its slow pole moved to 0 (5.4.3.1).
    pole_bound_rad_s: of the controller's poles (minimax).
    recentring: the inequalities are solved at this times the least gamma, where X and Y are small. ease: how much further above it the
    controller itself is taken (lpv, lft, lft_lpv); it is softer there, and has more margin.
    relax: `auto` finds the strictest trade between disturbance rejection and effort that reaches gamma = 1.
    """

    format: Literal["design/1"]
    name: Name
    axis: Axis
    structure: Structure
    method: Method
    weights: Weights
    position_law: PositionLaw | None = None
    domain: Domain = "discrete"
    prewarp_rad_s: PositiveNumber | None = None
    schedule: Annotated[tuple[Scheduled, ...], msgspec.Meta(min_length=1, max_length=5)] | None = None
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
    prefilter: Prefilter | None = None
    recentring: Annotated[float, msgspec.Meta(gt=1, le=2)] = 1.1
    ease: Annotated[float, msgspec.Meta(ge=1, le=5)] = 1.0

    def __post_init__(self) -> None:
        if self.structure == "speed_cascade" and self.position_law is None:
            raise ValueError("structure speed_cascade needs a position_law")
        if self.structure == "position" and self.position_law is not None:
            raise ValueError("structure position has no position_law: its linear controller takes the position error")
        if self.prewarp_rad_s is not None and self.domain == "discrete":
            raise ValueError("prewarp_rad_s is for domain continuous: a discrete design is not discretised")
        if self.schedule is not None and len(set(self.schedule)) != len(self.schedule):
            raise ValueError("schedule names a parameter twice")
        self._unread()
        if self.scheduled and (self.order is not None or "regime" in (self.schedule or ())):
            raise ValueError("scheduled is without order, over inertia, viscous, coulomb and constant")
        if self.method == "rst" and self.structure != "position":
            raise ValueError("method rst is for structure position")
        if self.structure == "speed_cascade" and self.integrator:
            raise ValueError("integrator is for structure position: a speed loop measures the integral of its error already")

    def _unread(self) -> None:
        """Raises ValueError where a key is given that the method does not read."""
        for field in msgspec.structs.fields(self):
            methods = READ_BY.get(field.name, (self.method,))
            asked = getattr(self, field.name) != field.default
            if asked and self.method not in methods and not (self.relax == "auto" and field.name in READ_BY_TRADE):
                several = "methods" if len(methods) > 1 else "method"
                raise ValueError(f"{field.name} is for {several} {', '.join(methods)}, and method is {self.method}; leave it out")
