"""A load on a compliant drive train oscillates after each stop; a rigid axis does so only if an
effort or a load drives it."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.documents.bench import Column, Encoder
from frictool.documents.laws import Laws, Load
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.identify.from_logs import identify
from frictool.identify.measurement.ringing import ringing
from frictool.identify.motion_record import MotionRecord, make_record
from frictool.logs import log_of
from frictool.typing import Vector
from studies.rigs.clutch_model import clutch_model
from tests.support.loaded_axis import rotary_bench

PERIOD, PARTS = 0.002, 10  # s; steps of the simulation in a sample
COUNT = 2.0 * math.pi / 2**21
INERTIA, COULOMB, VISCOUS = 5.0, 20.0, 12.0  # kg m^2, N m, N m s/rad
MOTOR = 0.4 * INERTIA
PULSE = 60.0  # N m
BENCH = msgspec.structs.replace(
    rotary_bench(None),
    sample_period_s=PERIOD,
    encoder=Encoder(counts_per_revolution=2**21),
    columns={
        "time": Column("t", "s"),
        "position": Column("x", "rad"),
        "effort": Column("u", "N m"),
    },
)
FREQUENCIES = (8.0, 13.0, 21.0, 34.0, 55.0)  # Hz
STOPS = 6


def model(stiffness: float = 0.0) -> Model:
    """Return a model of the axis; stiffness: of a spring, N m/rad."""
    spring = Estimate(stiffness, unit="N m/rad", source="identified")
    laws = None if stiffness == 0.0 else Laws(load=Load(stiffness=spring))
    plain = clutch_model()
    known = Estimate(INERTIA, 0.8 * INERTIA, 1.2 * INERTIA, "kg m^2", source="identified")
    parameters = msgspec.structs.replace(plain.parameters, inertia=known)
    return msgspec.structs.replace(plain, bench=BENCH, parameters=parameters, laws=laws)


def steps(draw: np.random.Generator, reach: float) -> Vector:
    """Return values of both signs, each held for 0.2 s, with 1 s of zero after each."""
    sizes = reach * draw.uniform(0.6, 1.0, STOPS) * (-1.0) ** np.arange(STOPS)
    parts = [np.repeat((size, 0.0), (round(0.2 / PERIOD), round(1.0 / PERIOD))) for size in sizes]
    return np.concatenate(parts)


def moved(
    seed: int, frequency: float, damping: float = 0.02, crossover: float = 0.0
) -> MotionRecord:
    """Return a log of the load's position and the motor's effort.

    frequency: of the load on a motor at rest [Hz]; inf for a rigid axis. Coulomb friction acts on
    the motor. The effort is a sequence of pulses or, if crossover > 0, that of a speed loop with
    this crossover [rad/s] on an axis with little friction.
    """
    draw = np.random.default_rng(seed)
    rigid, closed = math.isinf(frequency), crossover > 0.0
    goal = steps(draw, 0.5 if closed else PULSE)
    coulomb = 0.01 * COULOMB if closed else COULOMB
    load = INERTIA - MOTOR
    rate = 0.0 if rigid else 2.0 * math.pi * frequency
    stiffness, damper = load * rate**2, 2.0 * damping * load * rate
    moving = INERTIA if rigid else MOTOR
    step = PERIOD / PARTS
    motor = motor_speed = position = speed = last = command = 0.0
    measured, efforts = np.empty(goal.size), np.empty(goal.size)
    for k, wanted in enumerate(goal):
        seen = math.floor(position / COUNT) * COUNT
        measured[k], efforts[k], effort = seen, command, command
        error = crossover * (wanted - seen) / 3.0 - (seen - last) / PERIOD
        command = INERTIA * crossover * error if closed else wanted
        last = seen
        for _ in range(PARTS):
            twist = stiffness * (motor - position) + damper * (motor_speed - speed)
            push = effort - twist
            if motor_speed != 0.0 or abs(push) > coulomb:
                side = math.copysign(1.0, motor_speed or push)
                push -= side * coulomb + VISCOUS * motor_speed
                faster = motor_speed + step * push / moving
                motor_speed = faster if faster * side > 0.0 else 0.0
            motor += step * motor_speed
            speed = motor_speed if rigid else speed + step * twist / load
            position = motor if rigid else position + step * speed
    efforts += 0.2 * draw.standard_normal(goal.size)
    return make_record("log", PERIOD * np.arange(goal.size), measured, efforts, COUNT, 0.0)


@pytest.mark.parametrize(
    ("frequency", "damping"),
    [
        (8.0, 0.01),
        (21.0, 0.04),
        (55.0, 0.01),
        *(
            pytest.param(frequency, damping, marks=pytest.mark.accept)
            for frequency in FREQUENCIES
            for damping in (0.01, 0.04)
            if (frequency, damping) not in ((8.0, 0.01), (21.0, 0.04), (55.0, 0.01))
        ),
    ],
)
def test_the_frequency_is_that_of_the_load_on_a_motor_at_rest(
    frequency: float, damping: float
) -> None:
    found = ringing([moved(round(frequency), frequency, damping)], model())
    assert found is not None
    assert found.interval_rad_s is not None
    low, high = np.array(found.interval_rad_s) / (2.0 * math.pi)
    assert 0.99 * frequency < low < 1.001 * frequency
    assert 0.999 * frequency < high < 1.01 * frequency
    assert found.damping == pytest.approx(damping, rel=0.05)


@pytest.mark.parametrize(
    "seed",
    [
        seed if seed in (0, 4, 9) else pytest.param(seed, marks=pytest.mark.accept)
        for seed in range(10)
    ],
)
def test_a_rigid_axis_does_not_ring(seed: int) -> None:
    """Pulses, and a speed loop between much and no phase margin."""
    assert ringing([moved(seed, math.inf)], model()) is None
    assert ringing([moved(seed, math.inf, crossover=50.0 + 30.0 * seed)], model()) is None


@pytest.mark.parametrize("crossover", [260.0, 280.0, 300.0])
def test_the_effort_distinguishes_a_loop_near_its_limit_from_a_resonance(crossover: float) -> None:
    """With little friction and nearly no phase margin, the loop of a rigid axis oscillates. The
    same position without the effort that drives it is a free oscillation."""
    log = moved(1, math.inf, crossover=crossover)
    assert ringing([log], model()) is None
    silent = replace(log, effort=np.zeros_like(log.effort))
    assert ringing([silent], model()) is not None


def decaying(rate: float, decays: tuple[float, ...]) -> MotionRecord:
    """Return a log without effort, with an oscillation after each of several stops."""
    parts = []
    time = PERIOD * np.arange(round(1.0 / PERIOD))
    centre = 0.0
    for decay in decays:
        end = 0.5 - centre
        moving = np.linspace(centre, end, 200)
        parts += [moving, end + 20.0 * COUNT * np.exp(-decay * time) * np.sin(rate * time)]
        centre = end
    position = np.floor(np.concatenate(parts) / COUNT) * COUNT
    noise = np.random.default_rng(3).standard_normal(position.size)
    return make_record("log", PERIOD * np.arange(position.size), position, 0.1 * noise, COUNT, 0.0)


def test_a_spring_of_the_model_explains_the_oscillation_of_a_rigid_axis() -> None:
    rate = 2.0 * math.pi * 4.0
    log = decaying(rate, (1.0, 1.2, 0.8))
    assert ringing([log], model()) is not None
    assert ringing([log], model(stiffness=INERTIA * rate**2)) is None


def test_an_oscillation_that_also_grows_is_no_resonance() -> None:
    rate = 2.0 * math.pi * 20.0
    assert ringing([decaying(rate, (2.0, 2.0, 2.0))], model()) is not None
    assert ringing([decaying(rate, (2.0, -1.0, 2.0))], model()) is None
    assert ringing([decaying(rate, (0.0, 0.0, 0.0))], model()) is None


def test_one_stop_proves_nothing() -> None:
    rate = 2.0 * math.pi * 20.0
    assert ringing([decaying(rate, (2.0,))], model()) is None
    assert ringing([decaying(rate, (2.0, 2.0))], model()) is not None
    assert ringing([decaying(rate, (2.0,)), decaying(1.5 * rate, (2.0,))], model()) is None


def test_identify_names_the_resonance() -> None:
    logs = [moved(seed, 15.0) for seed in (1, 2)]
    signals = [{"position": one.position, "effort": one.effort} for one in logs]
    read = [
        log_of(one.time, signal, axis="rotary") for one, signal in zip(logs, signals, strict=True)
    ]
    outcome = identify(read, BENCH)
    assert outcome.model.ringing is not None
    assert any("rings at 15" in one and len(one) <= 190 for one in outcome.result.warnings)
