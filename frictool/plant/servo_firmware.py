"""Firmware of a smart servo, and the voltage that it applies.

goal -> [speed limit] -> [delay] -> profile
duty = duty_per_error gain (profile - position), limited to +-duty_limit
voltage = duty supply
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictool.typing import Vector


class FirmwareLaw(NamedTuple):
    """Parameters of a servo's firmware, and constants of the motor.

    - duty_per_error: duty cycle per rad and unit of the gain
    - goal_speed: speed limit of the profile [rad/s]
    - delay: time after which goal, gain and torque switch act [s]
    - back_emf [V s/rad], constant [N m/V]: constants of the motor
    - loop_period: sample period of the firmware [s]
    """

    duty_per_error: float
    duty_limit: float
    goal_speed: float
    delay: float
    back_emf: float
    constant: float
    loop_period: float

    def steps(self, period: float) -> int:
        """Return the number of firmware periods in a sample period [s] of the log."""
        return max(1, round(period / self.loop_period))

    def volts(self, profile: Vector, position: Vector, gain: Vector, supply: Vector) -> Vector:
        """Return the applied voltage (n,) for a profile (n,) and a position (n,), both in rad."""
        duty = self.duty_per_error * gain * (profile - position)
        return np.asarray(supply * np.clip(duty, -self.duty_limit, self.duty_limit))


class ServoDrive(NamedTuple):
    """Gain [firmware units], supply voltage [V] and torque switch, (n,) each, of a log."""

    gain: Vector
    supply: Vector
    enabled: Vector
