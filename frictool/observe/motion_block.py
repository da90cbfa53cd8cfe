"""Blocks of position and effort on the bench's uniform clock, the input of all estimators.

    log ──sample_stream.py──▶ MotionBlock, MotionBlock, ... ──▶ velocity, wear

After a gap or a jump of the clock, the next block has `follows` False. Estimators then forget the
position and the motion of the axis, and keep the estimated parameters.
"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.typing import Vector


@dataclass(frozen=True)
class MotionBlock:
    """Consecutive samples at the bench's sample period.

    - time, position, effort: finite samples, (n,), s, rad | m, N m | N. The effort is the drive
      signal times the actuator constant.
    - follows: True if the first sample is one period after the last sample of the previous block
    - velocity: velocity from a simulation or a sensor, for comparison only, (n,), rad/s | m/s; None
      if the log contains no velocity
    - temperature: temperature, (n,), degC; None if the log contains no temperature
    """

    time: Vector
    position: Vector
    effort: Vector
    follows: bool
    velocity: Vector | None = None
    temperature: Vector | None = None
