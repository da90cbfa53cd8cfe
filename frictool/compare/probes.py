"""Table 2.1 from measurements: each property is a probe of the law and a criterion, none is typed.

    velocity-driven    the friction along a prescribed velocity: Stribeck effect, viscous friction,
                       frictional memory
    force-driven       ramps of two rates: rising static friction
    fixed step         the law as it is printed, stepped by Euler's method: does it come to rest

Presliding, non-local memory and non-drift are those of the four tests
(compare/presliding_criterion.py, drift_criterion.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from frictool.compare.comparison_setting import ComparisonSetting
from frictool.compare.trajectory import Vector

Follow = Callable[
    [Vector, Vector], Vector
]  # velocities (n,) [m/s], time steps (n,) [s] -> friction (n,) [N], from a fresh contact

SLIDE = 40.0  # z_max: a contact that slides this far is in its steady state
STEPS_PER_Z_MAX = 50
SPEEDS = np.logspace(-1.0, 2.0, 13)  # in v_s
FAST = 1.0  # in units of speed: the Stribeck effect is over
# of F_c; of 2 (F_s - F_c), the same with table 3.1, for what the fall causes: below, a difference
# counts as none
NOTICEABLE = 0.01
MEMORY_MEAN, MEMORY_SWING, MEMORY_FREQUENCY = 3.0, 2.0, 10.0  # v_s, v_s, cycles in a unit of time
MEMORY_STEPS = 4000  # a cycle
EULER_STEPS, EULER_STEP, EULER_SPEED, EULER_FORCE = (
    20_000,
    1e-4,
    1e-2,
    0.5,
)  # in units of time, speed, force


def _noticeable(setting: ComparisonSetting) -> float:
    """The least difference [N | N m] that the fall of the friction from F_s to F_c is said to
    cause."""
    return NOTICEABLE * setting.scales.fall * setting.coulomb


def steady_friction(follow: Follow, setting: ComparisonSetting, speed: float) -> float:
    """The friction of a steady slide at `speed` [m/s]."""
    steps = int(SLIDE * STEPS_PER_Z_MAX)
    dt = setting.presliding / (STEPS_PER_Z_MAX * speed)
    return float(follow(np.full(steps, speed), np.full(steps, dt))[-1])


def stribeck_effect(follow: Follow, setting: ComparisonSetting) -> str:
    """`+`: somewhere between 0.1 and 100 v_s friction falls while the speed grows."""
    curve = np.array(
        [steady_friction(follow, setting, speed * setting.stribeck_velocity) for speed in SPEEDS]
    )
    falls = float(np.max(np.maximum.accumulate(curve) - curve))
    return "+" if falls > _noticeable(setting) else "-"


def viscous_friction(follow: Follow, setting: ComparisonSetting) -> str:
    """`+`: far above the Stribeck velocity friction grows with the speed."""
    speed = FAST * setting.scales.speed
    grown = steady_friction(follow, setting, 2.0 * speed) - steady_friction(follow, setting, speed)
    return "+" if grown > NOTICEABLE * setting.coulomb else "-"


def frictional_memory(follow: Follow, setting: ComparisonSetting) -> str:
    """`±`: in a slide whose speed swings, friction at one speed depends on whether it grows or
    falls; `-`: it does not.

    No law here has the delay of 3.4.2.3 as a parameter, which would be `+`.
    """
    period = setting.scales.time / MEMORY_FREQUENCY
    phase = 2.0 * math.pi * (np.arange(2 * MEMORY_STEPS) + 0.5) / MEMORY_STEPS
    velocity = setting.stribeck_velocity * (MEMORY_MEAN - MEMORY_SWING * np.cos(phase))
    friction = follow(velocity, np.full(phase.size, period / MEMORY_STEPS))[MEMORY_STEPS:]
    rising, falling = friction[: MEMORY_STEPS // 2], friction[MEMORY_STEPS // 2 :][::-1]
    return "±" if float(np.max(np.abs(rising - falling))) > _noticeable(setting) else "-"


def rising_static_friction(slow: float, fast: float, setting: ComparisonSetting) -> str:
    """`±`: the greatest friction before slip depends on how fast the force grows, `slow` and `fast`
    [N]; `-`: it does not.

    No law here has the dwell time as a parameter, which would be `+`.
    """
    return "±" if abs(slow - fast) > _noticeable(setting) else "-"


def stiction(compliance: bool, held: bool, settles: bool) -> str:
    """`-`: the contact yields, or is not held at rest below breakaway; `±`: held, but by an exact
    simulator only; `+`: by any."""
    if compliance or not held:
        return "-"
    return "+" if settles else "±"


def settles(law: Callable[[float, float], tuple[float, float]], setting: ComparisonSetting) -> bool:
    """Whether a slide under half the Coulomb friction comes to rest in a fixed step: in the second
    half it does not move at all.

    `law(v, u)` is the law as printed: the friction, and the speed that counts as motion. One that
    sticks at v = 0 only is stepped over by Euler's method for ever.
    """
    scales = setting.scales
    h, u, x, v = (
        EULER_STEP * scales.time,
        EULER_FORCE * scales.force,
        0.0,
        EULER_SPEED * scales.speed,
    )
    halfway = math.nan
    for k in range(EULER_STEPS):
        if k == EULER_STEPS // 2:
            halfway = x
        force, moving = law(v, u)
        v += h * (u - force) / setting.mass
        x += h * moving
    return x == halfway
