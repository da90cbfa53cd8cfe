"""Excitation tests by name, and their settings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import NoSolutionError
from frictool.identify.excite import constant_speeds as runs
from frictool.identify.excite import multisine as harmonics
from frictool.identify.excite.bench_limits import (
    BenchLimits,
    axis_known,
    check_reference,
    limits_of,
    sensing_of,
)
from frictool.identify.excite.breakaway_ramps import breakaway_ramps
from frictool.identify.excite.cramer_rao import SLIDING, PlannedStroke, cramer_rao
from frictool.identify.excite.excitation_sequence import (
    LONGEST,
    ExcitationSequence,
    check_samples,
    reference_sequence,
)
from frictool.identify.excite.half_sines import Motion, reachable_speed
from frictool.identify.excite.sine import BEST_SPEED, best_stroke, condition, longest_distance, sine
from frictool.identify.excite.sines import DURATION, SPEEDS, plan, sines
from frictool.identify.excite.steps import steps

SINE_DURATION = 10.0  # s, default
# settings with which the user chooses the length of a test
LENGTHS = {
    "sine": ("duration", "repetitions", "frequency", "speed"),
    "sines": ("duration",),
    "speeds": ("duration",),
    "breakaway": ("rate", "repetitions"),
    "steps": ("repetitions",),
    "multisine": ("frequency", "repetitions"),
}


@dataclass(frozen=True)
class ExcitationSettings:
    """Settings of a test in SI units; None selects the default of the test.

    - amplitude: half the distance of a stroke, rad | m; for ramps the largest drive signal, A | V
    - frequency: frequency of the sine, Hz
    - speed: top speed, rad/s | m/s
    - rate: slope of the ramps, A/s | V/s
    - duration: duration of the test, s
    - repetitions, speeds, harmonics: numbers of repetitions, speeds and harmonics
    - seed: seed of the random reversal positions
    - open_loop: True to play every ramp to its top, even if the axis moves
    """

    amplitude: float | None = None
    frequency: float | None = None
    speed: float | None = None
    rate: float | None = None
    duration: float | None = None
    repetitions: int | None = None
    speeds: int | None = None
    harmonics: int | None = None
    seed: int | None = None
    open_loop: bool | None = None


def excite(kind: str, bench: Bench, settings: ExcitationSettings) -> ExcitationSequence:
    """Return an excitation test that stays within the limits of a bench.

    Parameters
    ----------
    kind
        Key of MAKERS: "sine", "sines", "speeds", "breakaway", "steps" or "multisine".
    bench
        Bench whose limits the test respects.
    settings
        Settings of the test; a field that is None selects the default.

    Returns
    -------
    ExcitationSequence
        Reference or drive command in SI units, one row per sample.

    Raises ------ NoSolutionError If the test exceeds a limit of the bench, if it has more than
    MOST_SAMPLES samples, or if a test of default length takes longer than LONGEST. The message
    names the limit.
    """
    sequence = MAKERS[kind](bench, limits_of(bench), settings)
    names = LENGTHS[kind]
    if sequence.duration > LONGEST and all(getattr(settings, name) is None for name in names):
        options = " or ".join(f"--{name}" for name in names)
        raise NoSolutionError(
            f"time: the test `{kind}` takes {sequence.duration:.4g} s ({sequence.samples} samples) "
            f"on this bench; allowed: at most {LONGEST:g} s; choose its length with `excite "
            f"--kind {kind}` and {options}"
        )
    return sequence


def _reference(
    kind: str, bench: Bench, limits: BenchLimits, motion: Motion, figures: dict[str, float]
) -> ExcitationSequence:
    check_reference(limits, *motion)
    about = {
        **figures,
        "top_speed": float(np.abs(motion[1]).max()),
        "top_acceleration": float(np.abs(motion[2]).max()),
    }
    return reference_sequence(kind, bench, motion, about)


def _sine(bench: Bench, limits: BenchLimits, settings: ExcitationSettings) -> ExcitationSequence:
    duration = settings.duration or SINE_DURATION
    stroke = _stroke(bench, limits, settings, duration)
    times = settings.repetitions or max(1, round(duration / (2.0 * stroke.duration)))
    stroke = PlannedStroke(stroke.speed, stroke.distance, times)
    check_samples(2.0 * stroke.times * stroke.duration, bench.sample_period_s)
    figures = {
        "frequency_hz": stroke.frequency,
        "amplitude": 0.5 * stroke.distance,
        "condition": condition(stroke.speed),
        "scale": BEST_SPEED / stroke.speed,
        "condition_scaled": condition(BEST_SPEED),
        **_bounds([stroke], bench),
    }
    return _reference("sine", bench, limits, sine(stroke, limits, bench.sample_period_s), figures)


def _stroke(
    bench: Bench, limits: BenchLimits, settings: ExcitationSettings, duration: float
) -> PlannedStroke:
    """Return the stroke of a sine with the frequency, amplitude and top speed in `settings`.

    Top speed is 2 pi times frequency times amplitude. A setting that is None becomes as large as
    the limits allow. If all settings are None, the stroke with the smallest Cramér-Rao bounds is
    chosen.
    """
    speed, frequency = settings.speed, settings.frequency
    if settings.amplitude is None and speed is None and frequency is None:
        return best_stroke(limits, axis_known(bench), sensing_of(bench), duration)
    distance = 2.0 * settings.amplitude if settings.amplitude is not None else None
    if frequency is not None and distance is None:
        longest = longest_distance(limits)
        choices = np.geomspace(longest, 1e-4 * longest, 500)
        distance = (
            speed / (pi * frequency)
            if speed
            else next(
                (d for d in choices if pi * frequency * d <= reachable_speed(limits, d)), None
            )
        )
        if distance is None:
            raise NoSolutionError(
                f"acceleration: even an amplitude of {0.5e-4 * longest:.3g} {limits.unit} is too "
                f"large at {frequency:g} Hz; lower the frequency"
            )
    distance = float(distance) if distance is not None else longest_distance(limits)
    if frequency is not None:
        return PlannedStroke(pi * frequency * distance, distance)
    return PlannedStroke(speed or reachable_speed(limits, distance), distance)


def _sines(bench: Bench, limits: BenchLimits, settings: ExcitationSettings) -> ExcitationSequence:
    distance = 2.0 * settings.amplitude if settings.amplitude else None
    strokes = plan(limits, settings.duration or DURATION, settings.speeds or SPEEDS, distance)
    lasting = sum(2.0 * stroke.times * stroke.duration for stroke in strokes)
    check_samples(lasting, bench.sample_period_s)
    figures = {f"speed_{number}": stroke.speed for number, stroke in enumerate(strokes, start=1)}
    motion = sines(strokes, limits, bench.sample_period_s, settings.seed or 0)
    return _reference("sines", bench, limits, motion, {**figures, **_bounds(strokes, bench)})


def _bounds(strokes: list[PlannedStroke], bench: Bench) -> dict[str, float]:
    least = cramer_rao(strokes, axis_known(bench), sensing_of(bench))
    return {
        f"least_deviation_{name}": float(bound) for name, bound in zip(SLIDING, least, strict=True)
    }


def _multisine(
    bench: Bench, limits: BenchLimits, settings: ExcitationSettings
) -> ExcitationSequence:
    phases = harmonics.low_crest(settings.harmonics or harmonics.HARMONICS)
    motion, figures = harmonics.multisine(
        limits,
        bench.sample_period_s,
        phases,
        settings.frequency,
        settings.amplitude,
        settings.repetitions or 3,
    )
    return _reference("multisine", bench, limits, motion, figures)


def _steps(bench: Bench, limits: BenchLimits, settings: ExcitationSettings) -> ExcitationSequence:
    return _reference(
        "steps",
        bench,
        limits,
        steps(limits, bench.sample_period_s, settings.amplitude, settings.repetitions or 1),
        {},
    )


def _speeds(bench: Bench, limits: BenchLimits, settings: ExcitationSettings) -> ExcitationSequence:
    period = bench.sample_period_s
    duration = settings.duration or runs.DURATION
    check_samples(duration, period)
    count = settings.speeds or runs.SPEEDS
    speeds = runs.chosen_speeds(limits, period, bench.encoder.resolution, duration, count)
    figures = {f"speed_{number}": speed for number, speed in enumerate(speeds, start=1)}
    motion = runs.constant_speeds(limits, period, speeds, duration)
    return _reference("speeds", bench, limits, motion, figures)


def _breakaway(
    bench: Bench, limits: BenchLimits, settings: ExcitationSettings
) -> ExcitationSequence:
    return breakaway_ramps(
        bench,
        limits,
        settings.amplitude,
        settings.rate,
        settings.repetitions or 1,
        bool(settings.open_loop),
    )


MAKERS: dict[str, Callable[[Bench, BenchLimits, ExcitationSettings], ExcitationSequence]] = {
    "sine": _sine,
    "sines": _sines,
    "speeds": _speeds,
    "breakaway": _breakaway,
    "steps": _steps,
    "multisine": _multisine,
}
