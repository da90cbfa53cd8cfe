"""Smart servos on a pendulum, simulated without the product, and the bench of such a servo."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.typing import Vector

COUNT = 2.0 * np.pi / 4096  # rad, one count of the servo's encoder
STEP = 2e-4  # s, of the simulation
LOOP = 5  # steps of a firmware period
PERIOD = 0.01  # s, of the log
WEIGHT = 9.80665  # m/s^2

BENCH = """\
format: bench/1
name: smart servo
axis: rotary
sample_period_s: 0.01
encoder: {counts_per_revolution: 4096}
actuator:
  drive: voltage
  constant: {value: 0.4, low: 0.1, high: 2, unit: N m/V}
  limit: {value: 12, unit: V}
  servo:
    duty_per_error: 0.16
    duty_limit: 0.97
    goal_speed: {value: 6, low: 1, high: 20, unit: rad/s}
    delay: {value: 0.02, low: 0, high: 0.08, unit: s}
    back_emf: {value: 2.2, low: 0.5, high: 5, unit: V s/rad}
mechanics:
  inertia: {value: 0.015, low: 0.002, high: 0.2, unit: kg m^2}
  viscous: {value: 1, low: 0, high: 10, unit: N m s/rad}
  coulomb: {value: 0.1, low: 0, high: 2, unit: N m}
columns:
  time: {column: t, unit: s}
  position: {column: position, unit: rad}
  reference: {column: goal, unit: rad}
  gain: {column: kp, unit: '1'}
  supply: {column: volts, unit: V}
  torque_enabled: {column: torque_enable, unit: '1'}
  pendulum_mass: {column: mass, unit: kg}
  pendulum_length: {column: length, unit: m}
"""


@dataclass(frozen=True)
class SmartServo:
    """Servo: reflected inertia, friction without torque, constants of motor and firmware (SI)."""

    inertia: float = 0.02
    loose: float = 0.04
    coulomb: float = 0.12
    constant: float = 0.5
    back_emf: float = 2.0
    goal_speed: float = 4.8
    delay: float = 0.03
    zero: float = 0.03

    @property
    def viscous(self) -> float:
        """Viscous friction with the torque enabled, which includes the back-EMF."""
        return self.loose + self.constant * self.back_emf


def drawn_servo(generator: np.random.Generator) -> SmartServo:
    """A servo with every parameter drawn within a factor of about 1.4."""
    usual = SmartServo()
    factor = {name: float(np.exp(generator.uniform(-0.35, 0.35))) for name in vars(usual)}
    return SmartServo(**{name: value * factor[name] for name, value in vars(usual).items()})


@dataclass(frozen=True)
class ServoLogs:
    """Logs (m, n): goal, position, gain (m,), supply (m,), torque, mass and length (m,)."""

    time: Vector
    goal: Vector
    position: Vector
    gain: Vector
    supply: Vector
    enabled: Vector
    mass: Vector
    length: Vector

    def document(self, log: int) -> dict[str, object]:
        """One log as the document that a pendulum bench writes."""
        samples = [
            {"t": t, "goal": g, "position": q, "volts": self.supply[log], "torque_enable": bool(on)}
            for t, g, q, on in zip(
                self.time, self.goal[log], self.position[log], self.enabled[log], strict=True
            )
        ]
        shown = {"kp": self.gain[log], "mass": self.mass[log], "length": self.length[log]}
        return {**shown, "trajectory": str(log), "entries": samples}

    def write(self, folder: Path) -> list[Path]:
        """The files of all logs."""
        paths = []
        for log in range(self.gain.size):
            paths.append(folder / f"servo_{log}.json")
            paths[-1].write_text(json.dumps(self.document(log)), encoding="utf-8")
        return paths


def goals(seconds: float) -> tuple[Vector, Vector]:
    """Goals (8, n) and torque (8, n): steps, sums of sines, chirps, a lift with a free swing."""
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    step = np.where((t > 0.4) & (t < 0.6 * seconds), 1.4, 0.0)
    sines = 0.9 * np.sin(1.3 * t) + 0.5 * np.sin(5.1 * t)
    chirp = np.sin(0.7 * t**2)
    lift = -1.5 * np.sin(np.minimum(t / 2.0, 1.0) * np.pi / 2.0) ** 2
    every = np.array([step, sines, chirp, lift, 0.6 * step, -sines, -0.8 * chirp, 0.7 * lift])
    on = np.ones(every.shape)
    on[3::4, t > 2.2] = 0.0
    return every, on


def recorded(servo: SmartServo, generator: np.random.Generator, seconds: float = 3.5) -> ServoLogs:
    """The logs of eight moves with different gains, masses and lengths.

    Short steps of the mean speed; friction stops the axis within a step if it can. The firmware
    reads the counted position. The log states the goal at once, and the servo obeys it after the
    delay.
    """
    goal, enabled = goals(seconds)
    gain = np.array([8.0, 16.0, 16.0, 24.0, 32.0, 12.0, 24.0, 8.0])
    mass = generator.choice([0.4, 0.6, 0.9], 8)
    length = generator.choice([0.1, 0.15], 8)
    supply = generator.uniform(11.6, 12.2, 8)
    total = servo.inertia + mass * length**2
    torque = mass * WEIGHT * length
    samples = goal.shape[1]
    per = round(PERIOD / STEP)
    phase = generator.uniform(0.0, 1.0, 8)  # of the counts
    x = np.zeros(8)
    v = np.zeros(8)
    profile = goal[:, 0].copy()
    volts = np.zeros(8)
    on = np.ones(8)
    position = np.empty(goal.shape)
    for k in range(samples * per):
        if k % per == 0:
            position[:, k // per] = (np.round(x / COUNT + phase) - phase) * COUNT
        if k % LOOP == 0:
            late = max(k * STEP - servo.delay, 0.0) / PERIOD
            first = int(late)
            share = late - first
            wanted = (1.0 - share) * goal[:, first] + share * goal[:, min(first + 1, samples - 1)]
            on = enabled[:, first]
            reach = servo.goal_speed * LOOP * STEP
            profile = profile + np.clip(wanted - profile, -reach, reach)
            seen = (np.round(x / COUNT + phase) - phase) * COUNT
            volts = supply * np.clip(0.16 * gain * (profile - seen), -0.97, 0.97)
        driven = on * servo.constant * (volts - servo.back_emf * v)
        pushed = v + STEP * (driven - torque * np.sin(x + servo.zero) - servo.loose * v) / total
        after = np.sign(pushed) * np.maximum(np.abs(pushed) - STEP * servo.coulomb / total, 0.0)
        x = x + 0.5 * STEP * (v + after)
        v = after
    time = np.arange(samples) * PERIOD
    return ServoLogs(time, goal, position, gain, supply, enabled, mass, length)
