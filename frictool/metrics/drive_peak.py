"""Largest drive in a hold (phase of constant reference)."""

from __future__ import annotations

import numpy as np

from frictool.metrics.drive_noise import WhiteNoise, ordered_noise, white_noise
from frictool.typing import Vector


def drive_peak(measured: Vector) -> float:
    """Return the smallest true peak [A | V] that is consistent with a noisy drive signal (n,)."""
    return least_peak(measured, white_noise(measured))


def least_peak(measured: Vector, noise: WhiteNoise) -> float:
    """Return the smallest true peak [A | V] of the drive that is consistent with `measured` (n,).

    `noise` is the noise on `measured`. The k-th largest |measured| exceeds the true peak by at most
    the k-th largest |noise|.
    """
    sizes = np.sort(np.abs(measured))[::-1]
    return max(0.0, float((sizes - noise.deviation * ordered_noise(sizes.size)).max()))


def command_peak(command: Vector) -> float:
    """Return the largest |command| [A | V] of the samples (n,)."""
    return float(np.abs(command).max())


def larger_peak(command: Vector | None, measured: Vector | None) -> float:
    """Return the larger peak [A | V] of the command (n,) and the measured drive (n,).

    If one signal is None, return the peak of the other signal.
    """
    peaks = [] if command is None else [command_peak(command)]
    return max(peaks if measured is None else [*peaks, drive_peak(measured)])


def rest_drive(rest_command: Vector | None, rest_measured: Vector | None) -> float:
    """Return the peak [A | V] of the command at rest, or of the measured drive without a command.

    Both signals (n,) contain the samples at rest only.
    """
    return larger_peak(rest_command, rest_measured if rest_command is None else None)
