"""Multisine of the position, with equal speed amplitudes of the harmonics and a low crest factor.

    v(t) = V sum_k cos(2 pi k f t + phase_k)
    phase_k = -pi k (k - 1)/K      (Schroeder 1970)

V is the speed amplitude, K the number of harmonics, and f the frequency of the first harmonic. The
search starts from Schroeder's phases (Van der Ouderaa, Schoukens and Renneboog 1988). In each
iteration, the speed is clipped over time; the harmonics of the clipped speed give the next phases,
and the amplitudes are reset to V.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.excitation_sequence import check_samples
from frictool.identify.excite.half_sines import TOP_SHARE, Motion, spare_effort
from frictool.typing import Vector

HARMONICS = 10
POINTS = 64  # number of points per period and harmonic
CLIP = 0.9
SWAPS = 200
SLOWEST = 0.2  # Hz, lowest frequency if the travel is endless


def schroeder(harmonics: int) -> Vector:
    """Return Schroeder's phases (harmonics,) in rad."""
    k = np.arange(1, harmonics + 1)
    return np.asarray(-math.pi * k * (k - 1) / harmonics)


def crest(phases: Vector) -> float:
    """Return the crest factor (largest absolute value/rms) of equal cosines with `phases`."""
    speed = _period(phases)
    return float(np.abs(speed).max() / np.sqrt(np.mean(speed**2)))


def low_crest(harmonics: int) -> Vector:
    """Return the phases (harmonics,) in rad with the lowest crest factor that a search reaches."""
    phases = best = schroeder(harmonics)
    for _ in range(SWAPS):
        speed = _period(phases)
        top = CLIP * np.abs(speed).max()
        phases = np.angle(np.fft.rfft(np.clip(speed, -top, top))[1 : harmonics + 1])
        best = min(best, phases, key=crest)
    return best


def _period(phases: Vector) -> Vector:
    spectrum = np.concatenate(([0.0], np.exp(1j * phases)))
    return np.asarray(np.fft.irfft(spectrum, POINTS * phases.size) * (0.5 * POINTS * phases.size))


def _circle(phases: Vector) -> Vector:
    return np.asarray(np.linspace(0.0, 2.0 * math.pi, POINTS * phases.size, endpoint=False))


def _sums(angle: Vector, phases: Vector) -> tuple[Vector, Vector, Vector]:
    """Return position, speed and acceleration at angles (n,) [rad] of the first harmonic.

    Each harmonic has the speed amplitude 1; the first harmonic has the frequency 1 rad/s.
    """
    k = np.arange(1, phases.size + 1)
    terms = np.outer(angle, k) + phases
    return np.sin(terms) @ (1.0 / k), np.cos(terms).sum(axis=1), -np.sin(terms) @ k


def multisine(
    limits: BenchLimits,
    period: float,
    phases: Vector,
    frequency: float | None,
    amplitude: float | None,
    repetitions: int,
) -> tuple[Motion, dict[str, float]]:
    """Return position, velocity and acceleration (n,), and numbers that describe the motion.

    - period: sample period, s
    - phases: phase of each harmonic, (harmonics,), rad
    - frequency: frequency of the first harmonic, Hz; None for the frequency at which travel and
      speed both reach their limits
    - amplitude: half the range of positions, rad | m; None for the largest amplitude that the
      limits allow
    - repetitions: number of periods
    """
    coarse = _sums(_circle(phases), phases)
    reach = 0.5 * float(np.ptp(coarse[0]))
    top = float(np.abs(coarse[1]).max())
    amplitude_limit = amplitude or 0.5 * limits.travel
    if frequency is None:
        frequency = (
            TOP_SHARE * limits.speed * reach / (top * 2.0 * math.pi * amplitude_limit)
            if math.isfinite(amplitude_limit)
            else SLOWEST
        )
    samples = max(4 * phases.size, round(1.0 / (frequency * period)))
    check_samples(repetitions * samples * period, period)
    rate = 2.0 * math.pi / (samples * period)
    position, velocity, acceleration = _sums(np.asarray(rate * period * np.arange(samples)), phases)
    reach = 0.5 * float(np.ptp(position))
    top = float(np.abs(velocity).max())
    largest = min(
        amplitude_limit / reach,
        TOP_SHARE * limits.speed / (rate * top),
        _effort_bound(limits, rate * velocity, rate**2 * acceleration),
    )
    scale = amplitude_limit / reach if amplitude else largest
    start = int(np.argmin(np.abs(velocity)))  # sample closest to rest
    middle = 0.5 * (limits.low + limits.high) if math.isfinite(limits.travel) else 0.0
    centre = 0.5 * float(position.max() + position.min())
    columns = (
        middle + scale * (position - centre),
        scale * rate * velocity,
        scale * rate**2 * acceleration,
    )
    motion = tuple(np.tile(np.roll(column, -start), repetitions) for column in columns)
    return (motion[0], motion[1], motion[2]), {
        "frequency_hz": rate / (2.0 * math.pi),
        "harmonics": float(phases.size),
        "crest_factor": crest(phases),
        "crest_factor_schroeder": crest(schroeder(phases.size)),
        "amplitude": scale * reach,
    }


def _effort_bound(limits: BenchLimits, velocity: Vector, acceleration: Vector) -> float:
    """Return the largest factor on a motion for which every axis has enough effort.

    `limits` contains the worst case of all axes within the intervals in bench.yaml.
    """
    return spare_effort(limits) / float(
        np.abs(limits.inertia * acceleration + limits.viscous * velocity).max()
    )
