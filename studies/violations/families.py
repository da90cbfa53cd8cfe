"""Families of violations: each changes a machine that obeys the model."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from studies.violations.machine import Machine, draw_machine, generator_of

Change = Callable[[Machine, np.random.Generator, float], Machine]
MILD = 1.0 / 3.0  # severity below which a record counts as mild


@dataclass(frozen=True)
class Family:
    """Family of violations of the model.

    - change: function that adds the violation to a machine, with a severity of 0 to 1
    - claims: claims of a model that are true for this family
    - absolute: True if the intervals are judged with the interval of the torque constant
    """

    change: Change
    claims: tuple[str, ...] = ()
    absolute: bool = False


def _within(severity: float, mild: float, gross: float) -> float:
    """Return a value between `mild` and `gross` on a logarithmic scale."""
    return float(mild * (gross / mild) ** severity)


def _physics(machine: Machine, **values: float) -> Machine:
    return replace(machine, physics=machine.physics._replace(**values))


def _instruments(machine: Machine, **values: float) -> Machine:
    return replace(machine, instruments=replace(machine.instruments, **values))


def _sign(draw: np.random.Generator) -> float:
    return float(draw.choice([-1.0, 1.0]))


def _phase(draw: np.random.Generator) -> float:
    return float(draw.uniform(0.0, 2.0 * math.pi))


def unchanged(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Return the machine without a violation."""
    return machine


def wrong_gain(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Make the torque constant differ from the bench's, within the interval of the bench."""
    share = 0.12
    true = (
        1.0 + _sign(draw) * _within(severity, 0.25, 1.0) * share
    )  # divided by the bench's constant
    return _instruments(replace(machine, constant_share=share), gain=1.0 / true)


def belt(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Put a part of the inertia behind a belt with a resonance of 80 to 25 Hz."""
    inertia = machine.physics.inertia
    behind = inertia * draw.uniform(0.2, 0.7)
    motor = inertia - behind
    rate = 2.0 * math.pi * _within(severity, 80.0, 25.0)
    reduced = motor * behind / inertia
    return _physics(
        machine,
        inertia=motor,
        belt_inertia=behind,
        belt_stiffness=reduced * rate**2,
        belt_damping=2.0 * draw.uniform(0.02, 0.08) * reduced * rate,
    )


def cogging(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Add cogging of 5 to 35 % of Coulomb friction with three harmonics."""
    size = _within(severity, 0.05, 0.35) * machine.physics.coulomb
    shares = draw.uniform(0.2, 1.0, 3) * [1.0, 0.6, 0.4]
    sizes = size * shares / float(np.sum(shares))
    return _physics(
        machine,
        cogging_rate=float(draw.integers(4, 25)),
        **{f"cogging_{k}": float(one) for k, one in enumerate(sizes, start=1)},
        **{f"cogging_phase_{k}": _phase(draw) for k in (1, 2, 3)},
    )


def delay(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Log the current up to one sample late, with jitter."""
    return _instruments(
        machine, delay=_within(severity, 0.3, 1.0), jitter=_within(severity, 0.05, 0.3)
    )


def warming(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Lower the friction along the log."""
    size = _within(severity, 0.05, 0.5)
    return _physics(machine, viscous_warming=size, coulomb_warming=size * draw.uniform(0.2, 0.8))


def drifting_offset(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Let the offset of the current drift."""
    size = _within(severity, 0.02, 0.2) * machine.physics.coulomb
    rate = 2.0 * math.pi * draw.uniform(0.4, 1.5) / machine.physics.warming_time
    return _physics(machine, offset_drift=_sign(draw) * size, drift_rate=rate)


def eccentric(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Mount the encoder's disc eccentrically."""
    return _instruments(
        machine, eccentric=_within(severity, 1e-3, 1.5e-2), eccentric_phase=_phase(draw)
    )


def by_direction(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Make the friction differ by direction."""
    return _physics(
        machine,
        coulomb_direction=_sign(draw) * _within(severity, 0.03, 0.2),
        viscous_direction=_sign(draw) * _within(severity, 0.03, 0.25),
    )


def stribeck(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Let the friction fall over speed."""
    return _physics(
        machine,
        stribeck=machine.physics.coulomb * _within(severity, 0.05, 0.5),
        stribeck_speed=machine.speed * _within(severity, 0.02, 0.12),
    )


def over_position(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Make Coulomb friction vary over the position."""
    reach = machine.speed / machine.rate
    return _physics(
        machine,
        position_share=_within(severity, 0.03, 0.3),
        position_rate=draw.uniform(0.6, 4.0) / reach,
        position_phase=_phase(draw),
    )


def transmitted(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Add friction proportional to the transmitted torque."""
    return _physics(machine, transmitted=_within(severity, 0.01, 0.1))


def gravity(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Add a pendulum that the bench does not declare."""
    size = _within(severity, 0.05, 0.5) * machine.physics.coulomb
    return _physics(machine, gravity=size, gravity_phase=_phase(draw))


def spring(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Add a spring that the bench does not declare."""
    reach = machine.speed / machine.rate
    return _physics(machine, spring=_within(severity, 0.05, 0.4) * machine.physics.coulomb / reach)


def loop_lag(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Log the command of a current loop whose lag the bench does not declare."""
    return _physics(machine, lag=_within(severity, 0.5e-3, 4e-3))


def coarse_encoder(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Use a coarse encoder."""
    reach = machine.speed / machine.rate
    return _instruments(machine, count=reach / _within(severity, 500.0, 20.0))


def coloured_noise(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Add slow noise to the measured current."""
    return _instruments(
        machine,
        noise=machine.physics.coulomb * _within(severity, 0.02, 0.15),
        noise_time=10.0 ** draw.uniform(-2.3, -1.0),
    )


def mild_mix(machine: Machine, draw: np.random.Generator, severity: float) -> Machine:
    """Apply all changes mildly, except that of the torque constant."""
    for name, family in FAMILIES.items():
        if name not in ("true_model", "wrong_gain", "coarse_encoder", "mild_mix"):
            machine = family.change(machine, draw, 0.3 * float(draw.uniform()))
    return machine


FAMILIES: Mapping[str, Family] = {
    "true_model": Family(unchanged),
    "wrong_gain": Family(wrong_gain, absolute=True),
    "belt": Family(belt, ("resonances",)),
    "cogging": Family(cogging, ("ripple",)),
    "delay": Family(delay),
    "warming": Family(warming),
    "drifting_offset": Family(drifting_offset),
    "eccentric": Family(eccentric),
    "by_direction": Family(by_direction),
    "stribeck": Family(stribeck, ("regimes",)),
    "over_position": Family(over_position),
    "transmitted": Family(transmitted),
    "gravity": Family(gravity, ("gravity",)),
    "spring": Family(spring, ("stiffness",)),
    "loop_lag": Family(loop_lag),
    "coarse_encoder": Family(coarse_encoder),
    "coloured_noise": Family(coloured_noise),
    "mild_mix": Family(mild_mix, ("regimes", "gravity", "stiffness", "ripple", "resonances")),
}


def draw_violation(seed: str, family: str, number: int) -> Machine:
    """Return machine `number` of a family; the text `seed` determines it."""
    draw = generator_of(seed, family, number)
    machine = draw_machine(draw)
    severity = float(draw.uniform())
    changed = FAMILIES[family].change(machine, draw, severity)
    return replace(changed, severity=severity)
