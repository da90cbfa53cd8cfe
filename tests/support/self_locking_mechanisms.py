"""Random mechanisms with self-locking links, rigid or compliant, and what the compliant limit says
of the rigid ones."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.status_codes import OK
from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder
from tests.support.mechanism_runs import ready

PERIOD, HOLDS, SAMPLES = 4e-3, 4, 25  # s; commands that follow one another, and the samples of each
ALIKE, STILL = 0.03, 1e-2  # of the highest speed; rad/s of the motor, of which a tenth for the rest
KINDS = ("one", "one", "two", "series", "tail")


class Stiff(NamedTuple):
    """Natural frequency [rad/s] of compliant links, and the damping ratios of the first and of the
    other links."""

    rate: float
    first: float
    other: float


STIFF = (Stiff(1e5, 2.0, 2.0), Stiff(3e4, 15.0, 15.0), Stiff(3e4, 15.0, 4.0))


def drawn_self_locking(seed: int, stiff: Stiff | None) -> tuple[Builder, Vector]:
    """A motor with one self-locking link, two side by side, one with a lossy link or a rigid one
    behind; commands (samples, 1).

    Links are rigid, or as `stiff` says.
    """
    draw, b = np.random.default_rng([18, seed]), Builder()
    kind = str(draw.choice(KINDS))
    motor = 10.0 ** draw.uniform(-5, -3)
    b.block(motor, 100.0)

    def lossy(a: int, c: int, ratio: float, efficiency: float) -> None:
        lost = abs(ratio) * (1.0 / efficiency - 1.0)
        if stiff is None:
            b.joint(a, c, ratio, drive_loss=lost, back_loss=lost)
            return
        mass = 1.0 / (ratio * ratio / b.inertia[a] + 1.0 / b.inertia[c])
        damping = 2.0 * (stiff.other if b.couplings else stiff.first) * mass * stiff.rate
        b.coupling(a, c, mass * stiff.rate**2, damping, ratio, drive_loss=lost, back_loss=lost)

    for part in range(2 if kind in ("two", "series") else 1):
        behind = kind == "series" and part == 1
        a = len(b.inertia) - 1 if behind else 0
        ratio = float(
            draw.uniform(0.3, 2.0) if behind else draw.uniform(0.01, 0.1) * draw.choice([-1, 1])
        )
        efficiency = float(draw.uniform(0.3, 0.9) if behind else draw.uniform(0.2, 0.48))
        mass = 10.0 ** draw.uniform(-1, 1) * b.inertia[a] / ratio**2 * (1.0 if behind else 10.0)
        c = b.block(mass, 5.0)
        lossy(a, c, ratio, efficiency)
        if draw.random() < 0.7:
            b.push(c, float(draw.choice([-1, 1]) * mass * 10 ** draw.uniform(0.5, 1.5)))
        if draw.random() < 0.4:
            b.friction(c, "coulomb", coulomb=float(mass * 10 ** draw.uniform(0, 1)))
    if kind == "tail":
        b.joint(c, b.block(mass * draw.uniform(0.1, 2.0), 5.0), 1.0)
    if draw.random() < 0.3:
        b.friction(0, "coulomb", coulomb=float(motor * 10 ** draw.uniform(0, 2.5)))
    b.source(0)
    levels = draw.uniform(-1.0, 1.0, HOLDS) * motor * 10 ** draw.uniform(2.0, 4.0)
    return b, np.repeat(levels, SAMPLES)[:, None]


def speeds_of(seed: int, stiff: Stiff | None) -> Vector:
    """Speeds (blocks, holds) at the end of each hold, from rest; NaN where the engine gives up."""
    b, commands = drawn_self_locking(seed, stiff)
    machine, state = ready(b)
    result = run(machine, state, commands, PERIOD, most_events=0)
    return (
        np.asarray(result.speeds[:, SAMPLES::SAMPLES])
        if result.status == OK
        else np.full((len(b.inertia), HOLDS), math.nan)
    )


class Comparison(NamedTuple):
    """A drawn mechanism: whether its motor moves, whether its compliant motions are one whatever
    the damping, and the rigid motion too."""

    moves: bool
    has_limit: bool
    agrees: bool


def compared(seed: int) -> Comparison:
    """Play a mechanism with rigid and with compliant links and compare the speeds relative to each
    block's highest.

    What compliance leaves of the difference shrinks with it: the rigid speeds may lie as far from
    the stiffest as the softest ones do.
    """
    rigid, compliant = speeds_of(seed, None), np.array([speeds_of(seed, stiff) for stiff in STIFF])
    highest = np.max(np.abs(compliant), axis=(0, 2))
    allowed = (ALIKE * highest + STILL * np.array([1.0] + [0.1] * (rigid.shape[0] - 1)))[:, None]
    spread = np.max(np.abs(compliant - compliant[0]), axis=0)
    agrees = bool(np.all(np.abs(rigid - compliant[0]) <= allowed + spread))
    return Comparison(bool(highest[0] > STILL), bool(np.all(spread <= 2.0 * allowed)), agrees)
