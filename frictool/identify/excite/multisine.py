"""A multisine of the position: harmonics of one frequency with equal speeds, their phases chosen
for a low crest factor of the speed.

    v(t) = V sum_k cos(2 pi k f t + phase_k)         phase_k = -pi k (k - 1)/K      (Schroeder 1970)

A lower crest factor lets more speed into the same top speed. Schroeder's phases are the start; then
time and frequency are swapped (Van der Ouderaa, Schoukens and Renneboog 1988): the speed is
clipped, its phases are kept, its amplitudes put right again.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.identify.excite.bench_limits import BenchLimits
from frictool.identify.excite.cramer_rao import Vector
from frictool.identify.excite.half_sines import TOP_SHARE, Motion, spare_effort

HARMONICS = 10
POINTS = 64  # of a period, for each harmonic
CLIP, SWAPS = 0.9, 200
SLOWEST = 0.2  # Hz, where there is no travel to fill


def schroeder(harmonics: int) -> Vector:
    """Phases (harmonics,) in rad."""
    k = np.arange(1, harmonics + 1)
    return np.asarray(-math.pi * k * (k - 1) / harmonics)


def crest(phases: Vector) -> float:
    """Largest over rms value of the sum of equal cosines with these phases."""
    speed = _period(phases)
    return float(np.abs(speed).max() / np.sqrt(np.mean(speed**2)))


def low_crest(harmonics: int) -> Vector:
    """Phases (harmonics,) in rad: of the best crest factor that swapping passes through, never
    above Schroeder's."""
    phases = best = schroeder(harmonics)
    for _ in range(SWAPS):
        speed = _period(phases)
        top = CLIP * np.abs(speed).max()
        phases = np.angle(np.fft.rfft(np.clip(speed, -top, top))[1 : harmonics + 1])
        best = min(best, phases, key=crest)
    return best


def _period(phases: Vector) -> Vector:
    """One period of the sum, POINTS for each harmonic."""
    spectrum = np.concatenate(([0.0], np.exp(1j * phases)))
    return np.asarray(np.fft.irfft(spectrum, POINTS * phases.size) * (0.5 * POINTS * phases.size))


def _circle(phases: Vector) -> Vector:
    """Angles of one period, rad."""
    return np.asarray(np.linspace(0.0, 2.0 * math.pi, POINTS * phases.size, endpoint=False))


def _sums(angle: Vector, phases: Vector) -> tuple[Vector, Vector, Vector]:
    """Position, speed and acceleration over the angle of the first harmonic, for V = 1 and 1
    rad/s."""
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
    """The motion, and its figures: as large as the limits allow, or of this amplitude (half the way
    from end to end).

    Without a frequency that at which travel and speed bind together.
    """
    coarse = _sums(_circle(phases), phases)
    reach, top = 0.5 * float(np.ptp(coarse[0])), float(np.abs(coarse[1]).max())
    room = amplitude or 0.5 * limits.travel
    if frequency is None:
        frequency = (
            TOP_SHARE * limits.speed * reach / (top * 2.0 * math.pi * room)
            if math.isfinite(room)
            else SLOWEST
        )
    samples = max(4 * phases.size, round(1.0 / (frequency * period)))
    rate = 2.0 * math.pi / (samples * period)
    position, velocity, acceleration = _sums(np.asarray(rate * period * np.arange(samples)), phases)
    reach, top = 0.5 * float(np.ptp(position)), float(np.abs(velocity).max())
    largest = min(
        room / reach,
        TOP_SHARE * limits.speed / (rate * top),
        _effort_bound(limits, rate * velocity, rate**2 * acceleration),
    )
    scale = room / reach if amplitude else largest
    start = int(np.argmin(np.abs(velocity)))  # as near to rest as the samples come
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
    """The largest scale of a motion that the worst axis follows."""
    return spare_effort(limits) / float(
        np.abs(limits.inertia * acceleration + limits.viscous * velocity).max()
    )
