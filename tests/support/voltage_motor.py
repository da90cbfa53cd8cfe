"""Motor with winding and dry friction, driven by a voltage that is constant between rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from frictool.documents.bench import Actuator, Bench, Column, Encoder, Mechanics
from frictool.documents.quantity import Quantity
from frictool.typing import Vector

PERIOD = 2e-3  # s, of the rows
SUBSTEPS = 10  # steps of the simulation in a period
COUNT = 2.0 * np.pi / 40_000  # rad


@dataclass(frozen=True)
class Motor:
    """Motor in SI units; the voltage of a row acts `late` periods after the row."""

    inertia: float = 2e-3
    resistance: float = 1.5
    constant: float = 0.3
    inductance: float = 1.5e-3
    viscous: float = 6e-3
    coulomb: float = 0.1
    late: float = 0.0

    @property
    def damping(self) -> float:
        """Return the viscous friction with the part of the back-EMF [N m s/rad]."""
        return self.viscous + self.constant**2 / self.resistance

    def bench(self, drive: Literal["voltage", "current"], lag: float = 0.0) -> Bench:
        """Return a bench with wide ranges and this drive, whose lag is `lag` [s]."""
        voltage = drive == "voltage"
        effort = self.constant / self.resistance if voltage else self.constant
        viscous = self.damping if voltage else self.viscous
        return Bench(
            format="bench/1",
            name="motor",
            axis="rotary",
            sample_period_s=PERIOD,
            encoder=Encoder(step=Quantity(COUNT, unit="rad")),
            actuator=Actuator(
                drive,
                Quantity(effort, 0.95 * effort, 1.05 * effort, "N m/V" if voltage else "N m/A"),
                Quantity(24.0, unit="V" if voltage else "A"),
                lag,
            ),
            mechanics=Mechanics(
                inertia=_range(self.inertia, "kg m^2"),
                viscous=_range(viscous, "N m s/rad"),
                coulomb=_range(self.coulomb, "N m"),
            ),
            columns={
                "time": Column("time", "s"),
                "position": Column("x", "rad"),
                "voltage": Column("u", "V"),
                "current": Column("i", "A"),
            },
        )

    def run(self, voltage: Vector) -> tuple[Vector, Vector]:
        """Return position [rad] and current [A] at the rows, each (n,), without noise."""
        system = np.zeros((4, 4))  # current, velocity, position, and an input of 1
        system[0, :2] = -self.resistance / self.inductance, -self.constant / self.inductance
        system[1, :2] = self.constant / self.inertia, -self.viscous / self.inertia
        system[2, 1] = 1.0
        step = PERIOD / SUBSTEPS
        moves = {}
        state = np.array([0.0, 0.0, 0.0, 1.0])
        rows = np.empty((voltage.size, 3))
        ahead = round(self.late * SUBSTEPS)
        for k in range(voltage.size):
            rows[k] = state[:3]
            for j in range(SUBSTEPS):
                source = (k * SUBSTEPS + j - ahead) // SUBSTEPS
                volts = voltage[source] if source >= 0 else 0.0
                drive = self.constant * state[0]
                stuck = state[1] == 0.0 and abs(drive) <= self.coulomb
                sign = np.sign(state[1]) or np.sign(drive)
                key = (float(volts), 0.0 if stuck else float(sign))
                if key not in moves:
                    driven = system.copy()
                    driven[0, 3] = volts / self.inductance
                    driven[1, 3] = -sign * self.coulomb / self.inertia
                    if stuck:
                        driven[1] = 0.0
                    moves[key] = scipy.linalg.expm(driven * step)
                before = state[1]
                state = moves[key] @ state
                if before * state[1] < 0.0:
                    state[1] = 0.0
        return rows[:, 2], rows[:, 0]


def _range(value: float, unit: str) -> Quantity:
    return Quantity(1.1 * value, 0.5 * value, 1.6 * value, unit)


def steps(seed: int, samples: int, largest: float = 12.0, held: int = 30) -> Vector:
    """Return a random voltage (n,) with `held` rows a step, of 13 levels up to `largest` [V]."""
    levels = np.random.default_rng(seed).integers(-6, 7, samples // held + 1) / 6.0
    return np.repeat(levels * largest, held)[:samples]


def log_signals(motor: Motor, voltage: Vector, seed: int) -> dict[str, Vector]:
    """Return counted position, voltage, and current with noise and offset, each (n,)."""
    position, current = motor.run(voltage)
    draw = np.random.default_rng([seed, 1])
    noise = 0.02 * draw.standard_normal((2, voltage.size))
    counts = np.floor(position / COUNT + draw.uniform()) * COUNT
    return {
        "position": counts,
        "voltage": voltage + noise[0],
        "current": current + 0.03 + noise[1],
    }
