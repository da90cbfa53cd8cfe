"""Blocks of position and effort on the bench's uniform clock, the input of all estimators.

    log ──sample_stream.py──▶ MotionBlock, MotionBlock, ... ──▶ velocity, wear

The log is never held in memory: an hour is many blocks. After a gap or a jump of the clock a block
has `follows` False. Estimators then forget the axis's position and motion, and keep what they have
learned.
"""

from __future__ import annotations

from dataclasses import dataclass

from frictool.typing import Vector


@dataclass(frozen=True)
class MotionBlock:
    """Consecutive samples at the bench's period.

    time [s], position [rad | m], effort [N m | N]: (n,), finite. The effort is the drive times its
    constant. follows: True if the first sample is one period after the previous block's last.
    velocity: (n,) [rad/s | m/s] from a simulation or a sensor, if the log has it; it is used for
    comparison only.
    """

    time: Vector
    position: Vector
    effort: Vector
    follows: bool
    velocity: Vector | None = None
