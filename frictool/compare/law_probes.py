"""Probes of the laws for table 2.1: every property is measured, none is declared.

velocity-driven    friction along a prescribed velocity: Stribeck effect, viscous friction,
                   frictional memory
force-driven       ramps of two rates: rising static friction
fixed step         the printed law, integrated by Euler's method: test if the mass comes to rest

Presliding, non-local memory and non-drift come from the four tests
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

SLIDE = 40.0  # z_max, sliding distance to the steady state
STEPS_PER_Z_MAX = 50
SPEEDS = np.logspace(-1.0, 2.0, 13)  # in v_s
FAST = 1.0  # unit of speed, far above the Stribeck effect
# smallest difference that counts, relative to F_c; for effects of the fall, relative to 2 (F_s -
# F_c), which equals F_c in table 3.1
NOTICEABLE = 0.01
MEMORY_MEAN, MEMORY_SWING, MEMORY_FREQUENCY = 3.0, 2.0, 10.0  # v_s, v_s, cycles per unit of time
MEMORY_STEPS = 4000  # steps per cycle
EULER_STEPS = 20_000
EULER_STEP, EULER_SPEED, EULER_FORCE = 1e-4, 1e-2, 0.5  # units of time, speed and force


def _noticeable(setting: ComparisonSetting) -> float:
    """Return the smallest difference [N | N m] that counts as an effect of F_s > F_c."""
    return NOTICEABLE * setting.scales.fall * setting.coulomb


def steady_friction(follow: Follow, setting: ComparisonSetting, speed: float) -> float:
    """Return the friction of a steady slide at `speed` [m/s]."""
    steps = int(SLIDE * STEPS_PER_Z_MAX)
    dt = setting.presliding / (STEPS_PER_Z_MAX * speed)
    return float(follow(np.full(steps, speed), np.full(steps, dt))[-1])


def stribeck_effect(follow: Follow, setting: ComparisonSetting) -> str:
    """Return `+` if friction falls with increasing speed anywhere between 0.1 and 100 v_s."""
    curve = np.array(
        [steady_friction(follow, setting, speed * setting.stribeck_velocity) for speed in SPEEDS]
    )
    falls = float(np.max(np.maximum.accumulate(curve) - curve))
    return "+" if falls > _noticeable(setting) else "-"


def viscous_friction(follow: Follow, setting: ComparisonSetting) -> str:
    """Return `+` if friction grows with speed far above the Stribeck velocity."""
    speed = FAST * setting.scales.speed
    grown = steady_friction(follow, setting, 2.0 * speed) - steady_friction(follow, setting, speed)
    return "+" if grown > NOTICEABLE * setting.coulomb else "-"


def frictional_memory(follow: Follow, setting: ComparisonSetting) -> str:
    """Return `±` if friction at one speed depends on whether the speed grows or falls, else `-`.

    The test is a slide with oscillating speed. `+` would need the delay of 3.4.2.3 as a parameter,
    which no law here has.
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

    `slow`, `fast`: the largest friction at two rates [N]. `+` would need the dwell time as a
    parameter, which no law here has.
    """
    return "±" if abs(slow - fast) > _noticeable(setting) else "-"


def stiction(compliance: bool, holds: bool, settles: bool) -> str:
    """Return `-`, `±` or `+`.

    `-`: the contact yields, or does not hold at rest below breakaway. `±`: it holds in an exact
    simulation only. `+`: it holds in any simulation.
    """
    if compliance or not holds:
        return "-"
    return "+" if settles else "±"


def settles(law: Callable[[float, float], tuple[float, float]], setting: ComparisonSetting) -> bool:
    """Return True if a slide under half the Coulomb friction comes to rest with a fixed step.

    The mass must not move at all in the second half. `law(v, u)` is the law as printed; it returns
    the friction and the speed that counts as motion. Euler's method steps over v = 0, so that a law
    that sticks only there never comes to rest.
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
