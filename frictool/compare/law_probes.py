"""Probes that measure the properties of each law in thesis table 2.1.

velocity-driven    Stribeck effect, viscous friction and frictional memory, from the friction along
                   a prescribed velocity
force-driven       rising static friction, from force ramps at two rates
fixed step         stiction, from a simulation of the law as printed in the thesis by Euler's
                   method: the mass must come to rest

The other rows of the table, presliding, non-local memory and non-drift, follow from the four tests
(compare/presliding_criterion.py, drift_criterion.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from frictool.compare.comparison_setting import ComparisonSetting
from frictool.typing import Vector

# velocities (n,) [m/s], time steps (n,) [s] -> friction (n,) [N], from a fresh contact
Follow = Callable[[Vector, Vector], Vector]

SLIDE = 40.0  # sliding distance after which the friction is steady, units of z_max
STEPS_PER_Z_MAX = 50
SPEEDS = np.logspace(-1.0, 2.0, 13)  # in v_s
FAST = 1.0  # speed far above the Stribeck velocity, units of speed
# smallest difference of friction that counts, relative to F_c; for the Stribeck effect, relative to
# 2 (F_s - F_c), which equals F_c in table 3.1
NOTICEABLE = 0.01
MEMORY_MEAN, MEMORY_SWING, MEMORY_FREQUENCY = 3.0, 2.0, 10.0  # v_s, v_s, cycles per unit of time
MEMORY_STEPS = 4000  # steps per cycle
EULER_STEPS = 20_000
EULER_STEP, EULER_SPEED, EULER_FORCE = 1e-4, 1e-2, 0.5  # units of time, speed and force


def _noticeable(setting: ComparisonSetting) -> float:
    return NOTICEABLE * setting.scales.fall * setting.coulomb


def steady_friction(follow: Follow, setting: ComparisonSetting, speed: float) -> float:
    """Return the friction of steady sliding at `speed` [m/s]."""
    steps = int(SLIDE * STEPS_PER_Z_MAX)
    dt = setting.presliding / (STEPS_PER_Z_MAX * speed)
    return float(follow(np.full(steps, speed), np.full(steps, dt))[-1])


def stribeck_effect(follow: Follow, setting: ComparisonSetting) -> str:
    """Return `+` if friction falls with rising speed at any tested speed, else `-`.

    The tested speeds are 0.1 to 100 times the Stribeck velocity.
    """
    curve = np.array(
        [steady_friction(follow, setting, speed * setting.stribeck_velocity) for speed in SPEEDS]
    )
    falls = float(np.max(np.maximum.accumulate(curve) - curve))
    return "+" if falls > _noticeable(setting) else "-"


def viscous_friction(follow: Follow, setting: ComparisonSetting) -> str:
    """Return `+` if friction rises with speed far above the Stribeck velocity, else `-`."""
    speed = FAST * setting.scales.speed
    grown = steady_friction(follow, setting, 2.0 * speed) - steady_friction(follow, setting, speed)
    return "+" if grown > NOTICEABLE * setting.coulomb else "-"


def frictional_memory(follow: Follow, setting: ComparisonSetting) -> str:
    """Return `±` if friction differs between rising and falling speed, else `-`.

    The mass slides at an oscillating speed. If the document declares a lag of the friction
    (`film`), `law_simulator.py` sets `+` without this function.
    """
    period = setting.scales.time / MEMORY_FREQUENCY
    phase = 2.0 * math.pi * (np.arange(2 * MEMORY_STEPS) + 0.5) / MEMORY_STEPS
    velocity = setting.stribeck_velocity * (MEMORY_MEAN - MEMORY_SWING * np.cos(phase))
    friction = follow(velocity, np.full(phase.size, period / MEMORY_STEPS))[MEMORY_STEPS:]
    rising = friction[: MEMORY_STEPS // 2]
    falling = friction[MEMORY_STEPS // 2 :][::-1]
    return "±" if float(np.max(np.abs(rising - falling))) > _noticeable(setting) else "-"


def rising_static_friction(slow: float, fast: float, setting: ComparisonSetting) -> str:
    """Return `±` if the largest friction before slip depends on the rate of the force, else `-`.

    If the document declares a breakaway that rises with the time at rest (`dwell`),
    `law_simulator.py` sets `+` without this function.

    `slow`, `fast`: largest friction [N] in a slow and in a fast ramp of the force.
    """
    return "±" if abs(slow - fast) > _noticeable(setting) else "-"


def stiction(compliance: bool, holds: bool, settles: bool) -> str:
    """Return the symbol of stiction.

    `-`: the contact is compliant, or the mass moves below breakaway.
    `±`: the mass rests below breakaway, but only in an exact simulation.
    `+`: the mass also rests in a simulation with a fixed step.

    - compliance: True if the contact is compliant
    - holds: True if the mass rests in the exact simulation
    - settles: True if the mass rests in a simulation with a fixed step
    """
    if compliance or not holds:
        return "-"
    return "+" if settles else "±"


def settles(law: Callable[[float, float], tuple[float, float]], setting: ComparisonSetting) -> bool:
    """Return True if a sliding mass comes to rest in a simulation with a fixed step.

    The effort is half the Coulomb friction. The mass is at rest if it does not move in the second
    half of the simulation. Euler's method never gives exactly v = 0. Under a law that sticks only
    at v = 0, the mass therefore never comes to rest.

    `law`: the law as printed in the thesis (`law_as_printed`).
    """
    scales = setting.scales
    h = EULER_STEP * scales.time
    u = EULER_FORCE * scales.force
    x = 0.0
    v = EULER_SPEED * scales.speed
    halfway = math.nan
    for k in range(EULER_STEPS):
        if k == EULER_STEPS // 2:
            halfway = x
        force, moving = law(v, u)
        v += h * (u - force) / setting.mass
        x += h * moving
    return x == halfway
