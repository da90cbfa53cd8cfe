"""An arm in gravity with dry friction, under a servo or an effort that is played to it, and the
files that a user would have of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.runtime.kernels import kernel
from frictool.typing import Vector

PERIOD = 1e-3  # s
SUBSTEPS = 10


@dataclass(frozen=True)
class Arm:
    """SI: inertia kg m^2, viscous N m s/rad, friction and the effort of its weight at 90 degrees
    (`gravity`) in N m; counts a turn."""

    inertia: float = 0.17
    viscous: float = 0.05
    coulomb: float = 0.3
    breakaway: float = 0.36
    gravity: float = 0.0
    counts: int = 4096

    @property
    def step(self) -> float:
        """One count in rad."""
        return 2.0 * math.pi / self.counts


BENCH = """\
format: bench/1
name: arm
axis: rotary
sample_period_s: 0.001
encoder: {{counts_per_revolution: {counts}}}
actuator:
  drive: current
  constant: {{value: 1, unit: N m/A}}
  limit: {{value: 20, unit: A}}
mechanics:
  inertia: {{value: {inertia}, low: {inertia_low}, high: {inertia_high}, unit: kg m^2}}
  viscous: {{value: {viscous}, low: 0, high: {viscous_high}, unit: N m s/rad}}
  coulomb: {{value: {coulomb}, low: {coulomb_low}, high: {coulomb_high}, unit: N m}}
{load}columns:
  time: {{column: time, unit: s}}
  position: {{column: position, unit: rad}}
  current: {{column: current, unit: A}}
"""


def write_bench(folder: Path, arm: Arm, load: str = "") -> Path:
    """Write bench.yaml of the arm with wide ranges; `load`: a line that goes before the columns."""
    values = {
        "counts": arm.counts,
        "load": load,
        "inertia": arm.inertia,
        "viscous": arm.viscous,
        "coulomb": arm.coulomb,
    }
    ranges = {
        "inertia_low": 0.4 * arm.inertia,
        "inertia_high": 2.0 * arm.inertia,
        "viscous_high": 5.0 * arm.viscous,
        "coulomb_low": 0.2 * arm.coulomb,
        "coulomb_high": 3.0 * arm.coulomb,
    }
    target = folder / "bench.yaml"
    target.write_text(BENCH.format(**values, **ranges))
    return target


def write_log(target: Path, position: Vector, effort: Vector) -> Path:
    """Write a CSV of `position` (n,) in rad and `effort` (n,) in N m at PERIOD."""
    rows = zip(np.arange(position.size) * PERIOD, position, effort, strict=True)
    target.write_text(
        "time,position,current\n" + "".join(f"{t:.3f},{x:.9f},{u:.6f}\n" for t, x, u in rows)
    )
    return target


@kernel
def _play(
    command: Vector, gains: Vector, arm: Vector, step: float, position: Vector, effort: Vector
) -> None:
    """Fill `position` and `effort` (n,). gains: of position, its integral, its speed; all 0: the
    command is the effort. arm: as `Arm`."""
    inertia, viscous, coulomb, breakaway, gravity = arm
    x, v, total, speed = 0.3 * step, 0.0, 0.0, 0.0
    last, stuck, h = 0.0, True, PERIOD / SUBSTEPS
    for k in range(command.size):
        position[k] = math.floor(x / step) * step
        speed += 0.25 * ((position[k] - last) / PERIOD - speed)
        last = position[k]
        effort[k] = command[k]
        if gains[0] != 0.0:
            total += (command[k] - position[k]) * PERIOD
            effort[k] = gains[0] * (command[k] - position[k]) + gains[1] * total - gains[2] * speed
        for _ in range(SUBSTEPS):
            driving = effort[k] - gravity * math.sin(x)
            if stuck and abs(driving) <= breakaway:
                continue
            side = math.copysign(1.0, driving if stuck else v)
            after = v + h / inertia * (driving - side * coulomb - viscous * v)
            stuck = after * side <= 0.0 and abs(driving) <= breakaway
            v = 0.0 if stuck else after
            x += h * v


def play(
    arm: Arm, command: Vector, gains: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> tuple[Vector, Vector]:
    """Position (n,) rad by the encoder and effort (n,) N m of an arm under a servo on `command`
    (n,) rad, or driven by `command` N m."""
    position, effort = np.empty(command.size), np.empty(command.size)
    values = np.array([arm.inertia, arm.viscous, arm.coulomb, arm.breakaway, arm.gravity])
    _play(command, np.array(gains), values, arm.step, position, effort)
    return position, effort
