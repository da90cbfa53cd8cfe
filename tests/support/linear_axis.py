"""A linear axis as `--method inverse-dynamic` wants it: a fine encoder, no backlash, long strokes;
its own servo, its current held."""

from __future__ import annotations

import math

import numpy as np

from frictool.documents.bench import Actuator, Bench, Column, Encoder, Mechanics
from frictool.documents.quantity import Quantity
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.plant.axis import AxisParameters, rest
from frictool.runtime.kernels import kernel
from frictool.typing import Vector
from studies.rigs.engine_pointer import Advance, advance_pointer

PERIOD, SAMPLES = 1e-3, 20_000
ENCODER_STEP = 1e-6  # m
CONSTANT, LIMIT = 20.0, 10.0  # N/A, A
CURRENT_NOISE = 0.02  # A, standard deviation
SERVO = np.array([2000.0, 120.0, 0.3])  # N/m, N s/m, share of the newest speed in the filtered one


def linear_bench(backlash: float = 0.0) -> Bench:
    """The rig, each parameter known to within 40 to 70 %; `backlash` is the full width in m."""
    return Bench(
        format="bench/1",
        name="carriage",
        axis="linear",
        sample_period_s=PERIOD,
        encoder=Encoder(step=Quantity(ENCODER_STEP, unit="m")),
        actuator=Actuator("current", Quantity(CONSTANT, unit="N/A"), Quantity(LIMIT, unit="A")),
        mechanics=Mechanics(
            inertia=Quantity(5.0, 3.0, 7.0, "kg"),
            viscous=Quantity(12.0, 4.0, 20.0, "N s/m"),
            coulomb=Quantity(8.0, 3.0, 13.0, "N"),
            backlash=Quantity(backlash, unit="m") if backlash else None,
        ),
        columns={
            "time": Column("time", "s"),
            "position": Column("x", "m"),
            "current": Column("i", "A"),
        },
    )


@kernel
def _servo(
    state: Vector,
    reference: Vector,
    servo: Vector,
    p: Vector,
    step: float,
    period: float,
    x: Vector,
    current: Vector,
    advance: Advance,
) -> int:
    """Plays `reference` (n + 1,); fills `x` and `current` (n,). Returns the engine's status. The
    current of a sample acts at once."""
    last, filtered = math.floor(state[0] / step) * step, 0.0
    for k in range(x.shape[0]):
        x[k] = math.floor(state[0] / step) * step
        filtered += servo[2] * ((x[k] - last) / period - filtered)
        last = x[k]
        speed = (reference[k + 1] - reference[k]) / period
        wanted = (servo[0] * (reference[k] - x[k]) + servo[1] * (speed - filtered)) / p[5]
        current[k] = min(max(wanted, -p[7]), p[7])
        status = advance(state, current[k], p, period)
        if status != 0:
            return status
    return 0


def linear_axis(seed: int) -> tuple[AxisParameters, MotionRecord]:
    """The axis of a seed and its log: 20 s of two sines, the amplitude of the slower one waxing and
    waning."""
    draw = np.random.default_rng([seed, 13])
    truth = AxisParameters(
        inertia=5.0 * draw.uniform(0.8, 1.2),
        viscous=12.0 * draw.uniform(0.6, 1.4),
        coulomb=(coulomb := 8.0 * draw.uniform(0.6, 1.4)),
        breakaway=coulomb,
        offset=draw.uniform(-1.0, 1.0),
        constant=CONSTANT,
        drive_limit=LIMIT,
        encoder_step=ENCODER_STEP,
    )
    angle = 2.0 * np.pi * np.arange(SAMPLES + 1) * PERIOD
    frequency, phase, beat = (
        draw.uniform(0.5, 0.9),
        draw.uniform(0.0, 2.0 * np.pi),
        draw.uniform(0.0, 2.0 * np.pi),
    )
    reference = 0.05 * np.sin(frequency * angle + phase) * (
        1.0 + 0.5 * np.sin(0.07 * angle + beat)
    ) + 0.03 * np.sin(2.3 * frequency * angle)
    x, current = np.empty(SAMPLES), np.empty(SAMPLES)
    state = np.asarray(rest(reference[0] + ENCODER_STEP * draw.random()))
    plant = truth.as_array()
    advance = advance_pointer()
    status = _servo(state, reference, SERVO, plant, ENCODER_STEP, PERIOD, x, current, advance)
    assert status == 0
    current += CURRENT_NOISE * draw.standard_normal(SAMPLES)
    log = make_record(
        "carriage",
        np.arange(SAMPLES) * PERIOD,
        x,
        CONSTANT * current,
        resolution=ENCODER_STEP,
        lag=0.0,
    )
    return truth, log
