"""Records for the engine that describe the smart servo of bench.yaml: firmware and pendulum."""

from __future__ import annotations

from typing import NamedTuple

from frictool.documents.bench import Bench, Pendulum
from frictool.plant.servo_firmware import FirmwareLaw

GRAVITY = 9.80665  # m/s^2


class PendulumLoad(NamedTuple):
    """Pendulum about the axis: inertia [kg m^2] and torque when the arm is horizontal [N m]."""

    inertia: float = 0.0
    torque: float = 0.0


def firmware_law(bench: Bench) -> FirmwareLaw:
    """Return the servo firmware of a bench, with nominal values; its actuator must have a servo."""
    servo = bench.actuator.servo
    assert servo is not None
    return FirmwareLaw(
        servo.duty_per_error,
        servo.duty_limit,
        servo.goal_speed.value,
        servo.delay.value,
        servo.back_emf.value,
        bench.actuator.constant.value,
        servo.loop_period_s,
    )


def pendulum_load(
    pendulum: Pendulum | None, mass: float | None = None, length: float | None = None
) -> PendulumLoad | None:
    """Return the load of a pendulum; None if its mass or length is unknown.

    `mass` [kg], `length` [m]: values of a log, which replace the values in `pendulum`.
    """
    if pendulum is not None:
        mass = pendulum.mass.value if mass is None else mass
        length = pendulum.length.value if length is None else length
    if mass is None or length is None:
        return None
    arm = pendulum.arm_mass.value if pendulum is not None and pendulum.arm_mass else 0.0
    return PendulumLoad((mass + arm / 3.0) * length**2, (mass + arm / 2.0) * GRAVITY * length)
