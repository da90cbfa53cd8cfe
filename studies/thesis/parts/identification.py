"""Chapter 4 on the mass of table 4.1: a-priori bounds, tables 4.2 to 4.4, the ramp of 4.3.

The figures are 4.3 and 4.6 to 4.8.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from frictool.engine.axis_motion import advance
from frictool.identify.assess.noise_filter import LARGEST_RATIO, filter_for, noise_ratio
from frictool.identify.assess.quantisation import inertia_error, viscous_error
from frictool.identify.breakaway.breakaway import breakaway
from frictool.identify.estimators.conditioned import BEST_SPEED, condition_m2
from frictool.identify.estimators.power_balance import by_speed
from frictool.identify.fit_result import Interval
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.identify.rows.difference_fit import differenced
from frictool.identify.rows.regression_samples import RegressionSamples, fit
from frictool.plant.axis import rest
from frictool.typing import Vector
from studies.rigs.identification_rigs import MASS, MASS_PERIOD, MASS_SPEED, mass_bench, mass_sine
from studies.thesis.drawing import Curve, draw
from studies.thesis.results import ComputedValue, Part

NAMES = {"inertia": "m", "viscous": "sigma_v", "coulomb": "F_c"}
TRUTH = np.array([MASS.inertia, MASS.viscous, MASS.coulomb])
SEEDS, FAST_SEEDS, RECURSIVE_SEEDS, RATE = 400, 100, 4, 0.95
FILTER, FAST, SETTLED = (
    2.5e-3,
    1e4,
    50,
)  # s, m/s, samples after which the filter has forgotten its start
SPREAD = "95 of 100 single trials"
GAIN = 1000.0  # initial F of (4.16), times the unit matrix
RAMP = MASS._replace(inertia=0.1)  # 4.3: 100 g
STEP, RAMP_SAMPLES, RAMP_START = 0.005, 4000, 0.3e-4  # xi [N], samples, the encoder's phase [m]


def identification() -> Part:
    """Return the part with all results of the mass."""
    part = Part()
    _tables_4_2_and_4_3(part)
    _table_4_4(part)
    _bounds(part)
    _ramp(part)
    _pictures(part)
    return part


def _values(samples: RegressionSamples, weight: Vector, memory: int) -> Vector:
    found = fit(samples, weight, memory, RATE, {}).parameters
    return np.array([found[name].value for name in NAMES])


def _row(kind: str, values: list[Vector]) -> dict[str, float | str | ComputedValue]:
    """Return the rms error of each parameter [%], and the range of 95 of 100 single trials.

    The published value is that of a single trial.
    """
    errors = 100.0 * np.abs(np.array(values) / TRUTH - 1.0)
    rms = np.sqrt(np.mean(errors**2, axis=0))
    low, high = np.quantile(errors, [0.025, 0.975], axis=0)
    return {
        f"{kind}.{name}": ComputedValue(float(rms[k]), float(low[k]), float(high[k]), SPREAD)
        for k, name in enumerate(NAMES.values())
    }


def _tables_4_2_and_4_3(part: Part) -> None:
    plain, weighted, filtered = [], [], []
    printed: dict[str, list[Vector]] = {
        "not weighted": [],
        "weighted": [],
        "weighted and filtered": [],
    }
    for seed in range(SEEDS):
        log = mass_sine(seed)
        for found, constant, weigh in zip(
            printed.values(), (0.0, 0.0, FILTER), (False, True, True), strict=True
        ):
            found.append(_as_printed(log, constant, weigh))
        samples, memory = differenced([log], 0.0)
        plain.append(_values(samples, np.ones(samples.velocity.size), memory))
        weighted.append(_values(samples, by_speed(samples), memory))
        samples, memory = differenced([log], FILTER)
        filtered.append(_values(samples, by_speed(samples), memory))
    part.add("table_4_2", {**_row("plain", plain), **_row("weighted", weighted)})
    part.add("table_4_3", {**_row("weighted", weighted), **_row("filtered", filtered)})
    for kind, values in printed.items():
        text = ", ".join(
            f"{key.split('.')[1]} {_rms(value):.3g} %"
            for key, value in _row("printed", values).items()
        )
        part.say(
            "table_4_3" if "filtered" in kind else "table_4_2",
            f"With (4.2)'s backward differences, each effort at its own row, {kind}: {text} (rms).",
        )
    part.say("table_4_4", f"rms over {FAST_SEEDS} trials at {FAST:g} m/s.")
    part.say(
        "table_4_2",
        f"rms over {SEEDS} trials, each with its own noise, phase of the encoder and of the sine.",
    )


def _as_printed(log: MotionRecord, time_constant: float, weigh: bool) -> Vector:
    """Return the fit of (4.2) as printed: backward differences, and the effort of the same row.

    Every signal is filtered by the filter of 4.2.2.
    """
    speed = np.diff(log.position) / MASS_PERIOD
    signals = np.column_stack(
        (np.diff(speed) / MASS_PERIOD, speed[1:], np.sign(speed[1:]), log.effort[2:])
    )
    if time_constant:
        pole = np.exp(-MASS_PERIOD / time_constant)
        signals = lfilter([1.0 - pole], [1.0, -pole], signals, axis=0)[SETTLED:]
    weight = np.abs(signals[:, 1]) if weigh else np.ones(signals.shape[0])
    rows = signals * weight[:, None]
    return np.asarray(np.linalg.lstsq(rows[:, :3], rows[:, 3], rcond=None)[0])


def _table_4_4(part: Part) -> None:
    """Add table 4.4, by QR as the product does, and by the recursion (4.16) as printed."""
    found: dict[str, list[Vector]] = {
        kind: [] for kind in ("plain", "conditioned", "recursive", "recursive_conditioned")
    }
    for seed in range(FAST_SEEDS):
        samples, memory = differenced([mass_sine(seed, FAST)], FILTER)
        scale = BEST_SPEED / FAST
        found["plain"].append(_values(samples, by_speed(samples), memory))
        found["conditioned"].append(_values(samples, scale * by_speed(samples), memory))
        if seed < RECURSIVE_SEEDS:
            found["recursive"].append(_recursion(samples, 1.0))
            found["recursive_conditioned"].append(_recursion(samples, scale))
    part.add(
        "table_4_4",
        {
            key: value
            for kind in ("plain", "conditioned")
            for key, value in _row(kind, found[kind]).items()
        },
    )
    for kind, title in (("recursive", "without"), ("recursive_conditioned", "with")):
        text = ", ".join(
            f"{key.split('.')[1]} {_rms(value):.3g} %"
            for key, value in _row(kind, found[kind]).items()
        )
        part.say(
            "table_4_4",
            f"By the recursion (4.16) as printed, its gain from {GAIN:g} I on, {title} "
            f"conditioning: {text} "
            f"(rms, {RECURSIVE_SEEDS} trials).",
        )
    sine = np.sin(2.0 * np.pi * np.arange(0.5, 1000.0) / 1000.0)
    before, after = (condition_m2(speed * sine, np.sign(sine)) for speed in (FAST, BEST_SPEED))
    part.add("table_4_4", {"condition_before": before, "condition_after": after})


def _rms(found: float | str | ComputedValue) -> float:
    assert isinstance(found, ComputedValue)
    return float(found.value)


def _recursion(samples: RegressionSamples, scale: float) -> Vector:
    """Return m, sigma_v and F_c'/scale (4.33) by the thesis's recursion (4.16).

    The rows are weighted by |v| and scaled as in (4.31).
    """
    speed = np.abs(samples.velocity)
    rows = np.column_stack((samples.acceleration, samples.velocity, samples.sign)) * speed[:, None]
    rows[:, :2] *= scale
    target = samples.effort * speed * scale
    gain, value = GAIN * np.eye(3), np.zeros(3)
    for row, aim in zip(rows, target, strict=True):
        moved = gain @ row
        moved /= 1.0 + row @ moved
        value = value + moved * (aim - row @ value)
        gain = gain - np.outer(moved, row @ gain)
    return np.asarray(value / np.array([1.0, 1.0, scale]))


def _bounds(part: Part) -> None:
    """Add the bounds of 4.2.5.4 by (4.3), (4.4) and (4.7)."""
    step, effort = MASS.encoder_step, MASS.viscous * MASS_SPEED + MASS.coulomb
    part.add(
        "section_4_2_5_4",
        {
            "inertia": 100.0 * inertia_error(MASS.inertia, step, MASS_PERIOD, effort),
            "viscous": 100.0 * viscous_error(step, MASS_PERIOD, MASS_SPEED),
            "filter": 100.0 * (1.0 - noise_ratio(FILTER, MASS_PERIOD)),
        },
    )
    part.say(
        "section_4_2_5_4",
        f"Inertia with the largest effort of the trial, sigma_v V_0 + F_c = {effort:g} N.",
    )


class Ramps(NamedTuple):
    """Signals of figures 4.6 to 4.8: time [s], position [m], effort [N], each (n,)."""

    time: Vector
    position: Vector
    effort: Vector

    @property
    def record(self) -> MotionRecord:
        return make_record("ramp", self.time, self.position, self.effort, MASS.encoder_step, 0.0)


def ramps() -> Ramps:
    """Return the ramps of 4.3 on a mass of 100 g.

    The force grows by xi per sample until the encoder moves, and then starts again at 0.
    """
    state, parameters = np.asarray(rest(RAMP_START)), RAMP.as_array()
    position, effort, command = np.empty(RAMP_SAMPLES), np.empty(RAMP_SAMPLES), 0.0
    before = int(np.floor(state[0] / MASS.encoder_step))
    for k in range(RAMP_SAMPLES):
        count = int(np.floor(state[0] / MASS.encoder_step))
        command = 0.0 if count > before else command + STEP
        before, position[k], effort[k] = count, count * MASS.encoder_step, command
        if advance(state, command, parameters, MASS_PERIOD) != 0:
            raise RuntimeError("the ramp could not be simulated")
    return Ramps(np.arange(RAMP_SAMPLES, dtype=np.float64) * MASS_PERIOD, position, effort)


def _ramp(part: Part) -> None:
    """Add 4.3: largest force as read in the thesis, and breakaway identified from the same log."""
    found = ramps()
    axis = {
        name: Interval(*[getattr(RAMP, name)] * 3)
        for name in ("inertia", "viscous", "coulomb", "offset")
    }
    with tempfile.TemporaryDirectory() as name:
        result = breakaway([found.record], mass_bench(Path(name)), axis, RATE)
    largest = float(found.effort.max())
    part.add(
        "section_4_3",
        {
            "u_max": largest,
            "breakaway": ComputedValue(
                result.interval.value, result.interval.low, result.interval.high, "95 %"
            ),
        },
    )
    part.say(
        "section_4_3",
        f"u_max is {(largest - RAMP.breakaway) / STEP:.1f} steps xi of the ramp above the "
        "simulated breakaway.",
    )
    first = found.time < 2.0
    part.draw(
        "4.6",
        "The force grows by xi per sample, and starts again at 0 when the encoder has moved.",
        draw("ramp law", "t, s", [("u, N", [Curve(found.time[first], found.effort[first])])]),
    )
    part.draw(
        "4.7",
        f"{result.onsets} breakaways in {found.time[-1]:.1f} s.",
        draw("ramp position", "t, s", [("x, m", [Curve(found.time, found.position)])]),
    )
    part.draw(
        "4.8",
        f"Largest {largest:.3f} N; identify finds {result.interval.value:.4f} N in "
        f"[{result.interval.low:.4f}, {result.interval.high:.4f}] N.",
        draw("ramp force", "t, s", [("u, N", [Curve(found.time, found.effort)])]),
    )


def _pictures(part: Part) -> None:
    """Draw figure 4.3."""
    ratios = np.linspace(0.02, LARGEST_RATIO, 200)
    constants = np.array([filter_for(float(ratio), 1.0) for ratio in ratios])
    part.draw(
        "4.3",
        f"tau over T_s by (4.7): {constants[0]:.2f} at 2 %, {filter_for(0.096, 1.0):.2f} at 9.6 "
        f"%, {constants[-1]:.3f} at 80 %.",
        draw("filter", "noise ratio rho", [("tau/T_s", [Curve(ratios, constants)])]),
    )
