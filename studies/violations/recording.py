"""Record of a machine's test: the log that frictool reads, the bench, and the truth."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.typing import Matrix, Vector
from studies.violations.machine import Machine, generator_of
from studies.violations.motion import play

BENCH = """\
format: bench/1
name: violated
axis: rotary
sample_period_s: {period:.9g}
encoder: {{step: {{value: {count:.17g}, unit: rad}}}}
actuator:
  drive: current
  constant: {{value: {constant:.9g}, low: {low:.9g}, high: {high:.9g}, unit: N m/A}}
  limit: {{value: {limit:.9g}, unit: A}}
mechanics:
  inertia: {inertia}
  viscous: {viscous}
  coulomb: {coulomb}
columns:
  time: {{column: time, unit: s}}
  position: {{column: encoder, unit: count}}
  current: {{column: current, unit: A}}
"""


@dataclass(frozen=True)
class Recording:
    """Log of a test with the true parameters.

    - time, counts, current: logged channels (n,) [s, encoder counts, A]
    - motion: true position and velocity (2, n) [rad, rad/s]
    - effort: commanded effort (n,) [N m]
    - truth: inertia, viscous, coulomb and offset of the machine, means over the moving samples
    """

    machine: Machine
    time: Vector
    counts: Vector
    current: Vector
    motion: Matrix
    effort: Vector
    truth: dict[str, float]

    @property
    def bench(self) -> str:
        """Return the text of `bench.yaml`."""
        machine = self.machine
        return BENCH.format(
            period=machine.instruments.period,
            count=machine.instruments.count,
            constant=machine.constant,
            low=machine.constant * (1.0 - machine.constant_share),
            high=machine.constant * (1.0 + machine.constant_share),
            limit=1.5 * machine.servo.limit / machine.constant,
            inertia=_quantity(machine.bench_inertia, "kg m^2"),
            viscous=_quantity(machine.bench_viscous, "N m s/rad"),
            coulomb=_quantity(machine.bench_coulomb, "N m"),
        )

    @property
    def log(self) -> Log:
        """Return the log in memory."""
        position = self.counts * self.machine.instruments.count
        signals = {"position": position, "current": self.current}
        return Log((Stream(MAIN_TOPIC, self.time, signals, {"position": "rad", "current": "A"}),))

    def write(self, folder: Path) -> None:
        """Write `log.csv`, `bench.yaml` and `truth.json` to a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "bench.yaml").write_text(self.bench)
        (folder / "truth.json").write_text(json.dumps(self.truth, indent=2) + "\n")
        with (folder / "log.csv").open("w", newline="") as stream:
            rows = csv.writer(stream)
            rows.writerow(["time", "encoder", "current"])
            rows.writerows(
                (f"{t:.9g}", int(c), f"{i:.9g}")
                for t, c, i in zip(self.time, self.counts, self.current, strict=True)
            )


def _quantity(ends: tuple[float, float, float], unit: str) -> str:
    """Return a document's quantity from its value, low and high."""
    value, low, high = ends
    return f"{{value: {value:.9g}, low: {low:.9g}, high: {high:.9g}, unit: {unit}}}"


def record(machine: Machine, seed: str) -> Recording:
    """Simulate the machine's test and return the recording."""
    instruments = machine.instruments
    n = machine.played.size
    motion, effort = np.empty((2, n)), np.empty(n)
    play(
        machine.physics,
        machine.servo,
        machine.played,
        machine.rate_played,
        instruments.period,
        instruments.count,
        motion,
        effort,
    )
    draw = generator_of(seed, "noise")
    time = np.asarray(np.arange(n) * instruments.period, dtype=np.float64)
    position = motion[0] + instruments.eccentric * np.sin(motion[0] + instruments.eccentric_phase)
    counts = np.floor(position / instruments.count + draw.uniform())
    noise = instruments.noise * draw.standard_normal(n)
    if instruments.noise_time > 0.0:
        pole = float(np.exp(-instruments.period / instruments.noise_time))
        noise = lfilter([np.sqrt(1.0 - pole**2)], [1.0, -pole], noise)
    late = instruments.delay + instruments.jitter * draw.standard_normal(n)
    logged = effort
    if instruments.delay > 0.0:
        logged = np.interp(time - instruments.period * late, time, effort)
    current = (instruments.gain * logged + noise) / machine.constant
    return Recording(machine, time, counts, current, motion, effort, _truth(machine, time, motion))


def _truth(machine: Machine, time: Vector, motion: Matrix) -> dict[str, float]:
    """Return the sliding parameters of the machine, as means over the moving samples."""
    p = machine.physics
    moving = np.abs(motion[1]) > 0.05 * float(np.max(np.abs(motion[1])))
    x, t = motion[0, moving], time[moving]
    late = float(np.mean(0.5 - t / p.warming_time))
    over = 1.0 + p.position_share * float(np.mean(np.sin(p.position_rate * x + p.position_phase)))
    coulomb = p.coulomb * (1.0 + p.coulomb_warming * late) * over
    drift = p.offset_drift * float(np.mean(np.sin(p.drift_rate * t)))
    return {
        "inertia": p.inertia + p.belt_inertia,
        "viscous": p.viscous * (1.0 + p.viscous_warming * late),
        "viscous_forward": p.viscous
        * (1.0 + p.viscous_direction)
        * (1.0 + p.viscous_warming * late),
        "coulomb": coulomb,
        "offset": p.offset + drift + coulomb * p.coulomb_direction,
        "offset_with_loads": p.offset
        + drift
        + coulomb * p.coulomb_direction
        + p.gravity * float(np.mean(np.sin(x + p.gravity_phase)))
        + p.spring * float(np.mean(x)),
    }
