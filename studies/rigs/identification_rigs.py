"""Rigs that the tests identify: the clutch of the sample logs, and the mass of table 4.1."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.plant.axis import AxisParameters, rest
from frictool.runtime.kernels import kernel
from frictool.typing import Vector
from studies.rigs.engine_pointer import Advance, advance_pointer
from studies.rigs.sample_logs import TRUTH, Recording

ROOT = Path(__file__).parents[2]
CLUTCH, EMPS = ROOT / "configs" / "clutch" / "bench.yaml", ROOT / "configs" / "emps" / "bench.yaml"


def clutch() -> Bench:
    return load(CLUTCH, Bench)


def record(log: Recording, truth: AxisParameters = TRUTH, name: str = "log") -> MotionRecord:
    """Return the motion record of a log, with the encoder of `truth`."""
    position = log.encoder.astype(np.float64) * truth.encoder_step
    return make_record(
        name,
        log.time,
        position,
        log.current * truth.constant,
        resolution=truth.encoder_step,
        lag=truth.lag,
    )


MASS_BENCH = """\
format: bench/1
name: mass
axis: linear
sample_period_s: 0.001
encoder: {step: {value: 1.0e-4, unit: m}}
actuator:
  drive: current
  constant: {value: 1, unit: N/A}
  limit: {value: 20, unit: A}
mechanics:
  inertia: {value: 0.001, low: 0.0007, high: 0.0013, unit: kg}
  viscous: {value: 0.4, low: 0.2, high: 0.6, unit: N s/m}
  coulomb: {value: 1, low: 0.5, high: 1.5, unit: N}
columns:
  time: {column: time, unit: s}
  position: {column: position, unit: m}
  current: {column: current, unit: A}
"""


# table 4.1: a mass on dry friction, its encoder and its noise (0.01 N is the noise's variance)
MASS = AxisParameters(inertia=1e-3, viscous=0.4, coulomb=1.0, breakaway=1.5, encoder_step=1e-4)
MASS_PERIOD, MASS_SPEED, MASS_NOISE, MASS_POLE = 1e-3, 10.0, 0.1, 100.0
MASS_SETTLE, MASS_SAMPLES = 1000, 9000


@kernel
def position_loop(
    state: Vector,
    reference: Vector,
    gains: Vector,
    p: Vector,
    step: float,
    period: float,
    x: Vector,
    u: Vector,
    advance: Advance,
) -> int:
    """Simulate a PID on the encoder's position; fill x, u (n,) and return the engine's status."""
    integral, before = 0.0, reference[0] - math.floor(state[0] / step) * step
    for k in range(x.shape[0]):
        x[k] = math.floor(state[0] / step) * step
        error = reference[k] - x[k]
        integral += error * period
        u[k] = gains[0] * error + gains[1] * integral + gains[2] * (error - before) / period
        before = error
        status = advance(state, u[k], p, period)
        if status != 0:
            return status
    return 0


def _sine(seed: int, top_speed: float = MASS_SPEED) -> tuple[Vector, np.random.Generator]:
    """Return the reference (n,) of a seed, and the generator for further draws."""
    generator = np.random.default_rng(seed)
    angle = 2.0 * np.pi * np.arange(MASS_SETTLE + MASS_SAMPLES) * MASS_PERIOD + generator.uniform(
        0.0, 2.0 * np.pi
    )
    return -top_speed / (2.0 * np.pi) * np.cos(angle), generator


def mass_reference(seed: int) -> Vector:
    """Return the reference (n,) [m] of the position loop of `mass_sine`."""
    return _sine(seed)[0][MASS_SETTLE:]


def mass_sine(seed: int, top_speed: float = MASS_SPEED) -> MotionRecord:
    """Return the log of the thesis's test: a sine of 1 Hz, 9 s at 1 kHz.

    top_speed: m/s. The loop has three poles at -100 rad/s; the effort is held.
    """
    reference, generator = _sine(seed, top_speed)
    gains = np.array(
        [
            3.0 * MASS_POLE**2 * MASS.inertia,
            MASS_POLE**3 * MASS.inertia,
            3.0 * MASS_POLE * MASS.inertia - MASS.viscous,
        ]
    )
    time = np.arange(MASS_SETTLE + MASS_SAMPLES, dtype=np.float64) * MASS_PERIOD
    x, u = np.empty(time.size), np.empty(time.size)
    state = np.asarray(rest(reference[0] + MASS.encoder_step * generator.random()))
    assert (
        position_loop(
            state,
            reference,
            gains,
            MASS.as_array(),
            MASS.encoder_step,
            MASS_PERIOD,
            x,
            u,
            advance_pointer(),
        )
        == 0
    )
    u += MASS_NOISE * generator.standard_normal(u.size)
    kept = slice(MASS_SETTLE, None)
    return make_record("mass", time[kept], x[kept], u[kept], resolution=MASS.encoder_step, lag=0.0)


def mass_bench(folder: Path) -> Bench:
    """Write the bench of this mass into `folder`, with an inertia known to +-30 %."""
    path = folder / "bench.yaml"
    path.write_text(MASS_BENCH)
    return load(path, Bench)
