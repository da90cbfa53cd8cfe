"""Random mechanisms of all elements, drawn by a seed: blocks of some kg, speeds about 1 m/s,
efforts of some N."""

from __future__ import annotations

import numpy as np

from frictool.typing import Vector
from studies.rigs.mechanism_builder import Builder

LAWS = ("none", "none", "coulomb", "svc", "stribeck", "coulomb_tanh", "lugre")


def _ripple(rng: np.random.Generator, b: Builder, size: float, positive: bool) -> int:
    """A curve of some smooth pieces."""
    breaks = np.linspace(-1.0, 1.0, 7)
    values = size * rng.uniform(0.2 if positive else -1.0, 1.0, breaks.size)
    slopes = np.zeros(breaks.size)
    h = breaks[1] - breaks[0]
    cubic = [
        (values[i], slopes[i],
        (3 * (values[i + 1] - values[i]) / h - 2 * slopes[i] - slopes[i + 1]) / h,
         (slopes[i] + slopes[i + 1] - 2 * (values[i + 1] - values[i]) / h) / h**2)
        for i in range(breaks.size - 1)
    ]  # fmt: skip
    return b.curve(breaks.tolist(), cubic)


def _friction(rng: np.random.Generator, b: Builder, block: int) -> None:
    law = LAWS[rng.integers(len(LAWS))]
    coulomb, viscous = rng.uniform(0.2, 3.0), rng.uniform(0.0, 1.0)
    level = _ripple(rng, b, 1.5, True) if rng.random() < 0.2 else -1
    if law == "coulomb":
        b.friction(block, law, level, coulomb=coulomb)
    elif law == "svc":
        b.friction(block, law, level, coulomb=coulomb, breakaway=1.4 * coulomb, viscous=viscous)
    elif law == "stribeck":
        b.friction(
            block,
            law,
            level,
            coulomb=coulomb,
            breakaway=1.5 * coulomb,
            stribeck_velocity=0.05,
            stribeck_exponent=2.0,
            viscous=viscous,
        )
    elif law == "coulomb_tanh":
        b.friction(block, law, level, coulomb=coulomb, smoothing_velocity=0.05)
    elif law == "lugre":
        b.friction(
            block, law, -1, coulomb=coulomb, breakaway=1.5 * coulomb, stribeck_velocity=0.05,
            stribeck_exponent=2.0, viscous=viscous,
            stiffness=1e3 * coulomb, damping=2.0,
        )  # fmt: skip
    if rng.random() < 0.15:
        b.pressing(
            block, _ripple(rng, b, 10.0, True), rng.uniform(0.05, 0.2), rng.uniform(1.0, 1.3)
        )
    if rng.random() < 0.15:
        b.push(
            block, rng.uniform(-2.0, 2.0), _ripple(rng, b, 2.0, False) if rng.random() < 0.5 else -1
        )
    if rng.random() < 0.25:
        b.stop(
            block,
            -rng.uniform(0.05, 0.5),
            rng.uniform(0.05, 0.5),
            float(rng.choice([0.0, 0.3, 0.8])),
        )


def _link(rng: np.random.Generator, b: Builder, one: int, other: int) -> None:
    a, c = (one, other) if rng.random() < 0.7 else (other, one)
    ratio = rng.uniform(0.5, 2.0) * rng.choice([-1.0, 1.0])
    gap, thrown = rng.uniform(0.005, 0.05), float(rng.choice([0.0, 0.0, 0.4, 0.9]))
    kind = rng.integers(8)
    drive, back = abs(ratio) * rng.uniform(0.0, 0.4), abs(ratio) * rng.uniform(0.0, 0.6)
    if kind == 0:
        b.joint(a, c, ratio)
    elif kind == 1:
        b.joint(a, c, ratio, drive_loss=drive, back_loss=back)
    elif kind == 2:
        b.joint(a, c, ratio, gap=gap, restitution=thrown)
    elif kind == 3:
        b.joint(a, c, ratio, gap=gap, restitution=thrown, drive_loss=drive, back_loss=back)
    elif kind == 4:
        b.joint(a, c, ratio, thread=abs(ratio) * 0.3, thesis_screw=0.1)
    elif kind == 5:
        b.coupling(a, c, 10 ** rng.uniform(2, 4), 10 ** rng.uniform(-1, 1), ratio)
    elif kind == 6:
        b.coupling(a, c, 10 ** rng.uniform(2, 4), 10 ** rng.uniform(-1, 1), ratio, gap=gap)
    else:
        b.coupling(a, c, 10 ** rng.uniform(2, 4), 1.0, ratio, drive_loss=drive, back_loss=back)


def drawn(seed: int) -> tuple[Builder, Vector, float]:
    """A mechanism, commands (samples, sources) and their period [s]."""
    rng, b = np.random.default_rng(seed), Builder()
    n = int(rng.integers(1, 8))
    for i in range(n):
        b.block(10 ** rng.uniform(-1, 0.7))
        _friction(rng, b, i)
        if i > 0:
            _link(rng, b, int(rng.integers(i)), i)
    for i in range(n):
        if i == 0 or rng.random() < 0.2:
            b.source(i, 1.0, 10.0, float(rng.choice([0.0, 0.005])))
    if rng.random() < 0.3:
        b.coupling(-1, int(rng.integers(n)), 100.0, 0.5)
    period, samples = 5e-3, 200
    t = period * np.arange(samples)[:, None]
    size = rng.uniform(1.0, 10.0, (1, len(b.sources)))
    commands = size * np.sin(
        2 * np.pi * rng.uniform(0.5, 4.0, (1, len(b.sources))) * t
        + rng.uniform(0, 6, (1, len(b.sources)))
    )
    if rng.random() < 0.5:
        commands = np.where(rng.random(commands.shape) < 0.02, -commands, np.sign(commands) * size)
    return b, commands, period
