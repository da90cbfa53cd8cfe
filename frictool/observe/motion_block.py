"""Blocks of position and effort on the bench's uniform clock, the input of all estimators.

    log ──sample_stream.py──▶ MotionBlock, MotionBlock, ... ──▶ velocity, wear

The block after a gap or a jump of the clock has `follows` False. Estimators then forget the
position and the motion of the axis, and keep the estimated parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.typing import Vector


@dataclass(frozen=True)
class MotionBlock:
    """Consecutive samples at the bench's period.

    - time, position, effort: finite samples, (n,), s, rad | m, N m | N. The effort is the drive
      times the actuator constant
    - follows: True if the first sample is one period after the last sample of the previous block
    - velocity: velocity of a simulation or a sensor, for comparison only, (n,), rad/s | m/s; None
      if the log has no velocity
    - temperature: temperature, (n,), degC; None if the log has none
    """

    time: Vector
    position: Vector
    effort: Vector
    follows: bool
    velocity: Vector | None = None
    temperature: Vector | None = None
