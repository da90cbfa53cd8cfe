"""Descriptions of a controller's blocks, in the order of the signal path."""

from __future__ import annotations

from frictool.documents.controller import (
    Controller,
    Feedforward,
    FrictionCompensation,
    Limiter,
    PositionLaw,
    Profile,
    Velocity,
)
from frictool.documents.observer import Observer
from frictool.documents.quantity import si_unit
from frictool.report.requirement import number

ORDERS = {1: "first", 2: "second"}
INPUTS = {
    "eta": "eta = (integral of the speed reference) - position",
    "speed_error": "the speed's error",
}


def block_descriptions(controller: Controller) -> list[tuple[str, str]]:
    """Return (name, description) of each block of the controller, along the signal path."""
    unit = si_unit("position", controller.axis)
    drive = si_unit(controller.drive, controller.axis)
    law, filtered = controller.position_law, controller.prefilter
    blocks = (
        []
        if filtered is None
        else [("Prefilter", _prefilter(filtered.natural_frequency_rad_s, filtered.damping))]
    )
    if controller.profile is not None:
        blocks.append(("Profile", _profile(controller.profile, unit)))
    if _sees_velocity(controller):
        blocks.append(("Velocity", _velocity(controller.velocity)))
    if law is not None:
        blocks.append(("Position law", _law(law, unit)))
    blocks.append(("Linear", _linear(controller)))
    if controller.schedule is not None:
        blocks.append(
            (
                "Schedule",
                f"over {', '.join(controller.schedule.parameters)}; "
                f"{len(controller.schedule.corners)} corners",
            )
        )
    if controller.feedforward is not None:
        blocks.append(("Feedforward", _feedforward(controller.feedforward, unit)))
    if controller.friction_compensation is not None:
        blocks.append(("Friction compensation", _compensation(controller.friction_compensation)))
    if controller.limiter is not None:
        blocks.append(("Limit-cycle limiter", _limiter(controller.limiter, unit)))
    blocks.append(
        (
            "Drive",
            f"{controller.drive} limited to {number(controller.drive_limit)} "
            f"{drive}{_winding(controller)}",
        )
    )
    return blocks


def _prefilter(frequency: float, damping: float) -> str:
    return (
        f"second-order low-pass of the reference, {number(frequency)} rad/s, damping "
        f"{number(damping)}"
    )


def _profile(limits: Profile, unit: str) -> str:
    return (
        f"at most {number(limits.speed)} {unit}/s and {number(limits.acceleration)} {unit}/s², "
        f"jerk limited by a moving average of {limits.smoothing_samples} samples"
    )


def _feedforward(fed: Feedforward, unit: str) -> str:
    source = (
        f", derivatives of the reference filtered at {number(fed.filter_rad_s)} rad/s"
        if fed.filter_rad_s
        else ""
    )
    return (
        f"inertia {number(fed.inertia)}, viscous {number(fed.viscous)}, Coulomb "
        f"{number(fed.coulomb)} above {number(fed.switch_on_speed)} {unit}/s{source}"
    )


def _sees_velocity(controller: Controller) -> bool:
    law = controller.position_law
    cascade = controller.structure == "speed_cascade"
    brakes = law is not None and law.action == "brake"
    by_speed = cascade and controller.linear.input == "speed_error"
    return (
        brakes
        or by_speed
        or controller.limiter is not None
        or controller.friction_compensation is not None
    )


def _velocity(velocity: Velocity) -> str:
    if velocity.observer is not None:
        return _observer(velocity.observer)
    if velocity.source == "measured":
        return "from a separate sensor"
    if velocity.bandwidth_rad_s == 0.0:
        return "the encoder's difference, not filtered"
    return (
        f"the encoder's difference through a {ORDERS[velocity.order]}-order low-pass at "
        f"{number(velocity.bandwidth_rad_s)} rad/s"
    )


def _observer(observer: Observer) -> str:
    if observer.tracking is not None:
        return (
            f"from a tracking observer of {number(observer.tracking.bandwidth_rad_s)} rad/s, with "
            "model, drive and encoder"
        )
    return f"from the switched observer of {observer.kind} wear"


def _law(law: PositionLaw, unit: str) -> str:
    kind = "square root" if law.kind == "square_root" else "proportional"
    gain = f"{kind}, gain {number(law.gain)}" + (f" by {law.formula}" if law.formula else "")
    if law.action == "none":
        return f"{gain}; the loop stays closed everywhere"
    action = {
        "cut": "drive 0",
        "brake": f"speed reference 0, drive 0 below {number(law.rest_speed)} {unit}/s",
    }[law.action]
    wait = (
        f", once the prefilter is slower than {number(law.settled_speed)} {unit}/s"
        if law.settled_speed
        else ""
    )
    return f"{gain}; inside the band of {number(law.band)} {unit}: {action}{wait}"


def _linear(controller: Controller) -> str:
    linear = controller.linear
    entering = (
        "the position's error" if controller.structure == "position" else INPUTS[linear.input]
    )
    form = "second-order sections" if linear.form == "sos" else "state space"
    conditional = ", integrators held while the drive is limited" if linear.conditional else ""
    return f"order {linear.order} from {entering}, runs as {form}{conditional}"


def _compensation(block: FrictionCompensation) -> str:
    part = f"adds {100.0 * block.gain:.3g} % of the friction"
    if block.source == "observer":
        return (
            f"{part} that an observer of {number(block.observer_rad_s)} rad/s estimates; a "
            "baseline for comparison"
        )
    tables = f", as a table of {len(block.speeds)} speeds" if block.speeds else ""
    if block.positions:
        tables += f", with a table of {len(block.positions)} positions"
    return f"{part} of the model{tables}, at the {block.velocity} speed; a baseline for comparison"


def _limiter(limiter: Limiter, unit: str) -> str:
    where = "||e| - J v²/2F|" if limiter.condition == "energy" else "|e|"
    source = "" if limiter.condition == "energy" else " (the usual cut-off)"
    brake = (
        f", with a virtual friction of {number(limiter.virtual_coulomb)}"
        if limiter.virtual_coulomb > 0.0
        else ""
    )
    wait = (
        f", once the prefilter is slower than {number(limiter.settled_speed)} {unit}/s"
        if limiter.settled_speed
        else ""
    )
    return (
        f"drive released where {where} < {number(limiter.band)} {unit}{source}, the "
        f"integral frozen{brake}{wait}"
    )


def _winding(controller: Controller) -> str:
    winding = controller.bench.actuator.winding
    return (
        ""
        if winding is None
        else (
            f", and by {number(winding.voltage_v)} V over {number(winding.resistance_ohm)} "
            "Ω and the back-EMF"
        )
    )
