"""Pieces of a log on their way through the estimators: position and effort on the bench's uniform
clock.

    log ──sample_stream.py──▶ Piece, Piece, ... ──▶ velocity, wear   (nothing holds the log: an hour
                                                                     is many pieces)

A piece that does not follow the one before it (a gap in the log, a jump of the clock) says so;
estimators then forget where they were, and not what they have learned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class MotionBlock:
    """Samples that follow one another at the bench's period: time [s], position [rad | m], effort
    [N m | N] (the drive times its constant), all (n,) and finite. follows: whether the first sample
    is one period after the last of the piece before.

    velocity: (n,) [rad/s | m/s] where the log holds one that a simulation knows or a sensor
    measured; it is compared with and not used.
    """

    time: Vector
    position: Vector
    effort: Vector
    follows: bool
    velocity: Vector | None = None
