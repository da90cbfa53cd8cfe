"""Logs that tell curves: sines of several speeds of the mass of table 4.1, and bench tests of the thesis's non-linear clutch."""

from __future__ import annotations

import numpy as np

from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.identify.record import Record, make_record
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.axis_model import axis_of
from tests.identify.benches import MASS, MASS_NOISE, MASS_PERIOD, MASS_POLE, ROOT, _position_loop

SPEEDS = (2.0, 4.0, 6.0, 8.0, 10.0)  # m/s
PERIODS = 3  # of 1 s at each speed
SETTLE = 1000  # samples


def mass_sines(seed: int, step: float = MASS.encoder_step) -> list[Record]:
    """Sines of 1 Hz at SPEEDS, one log each, under the position loop of table 4.1."""
    generator = np.random.default_rng([seed, 5])
    gains = np.array([3.0 * MASS_POLE**2 * MASS.inertia, MASS_POLE**3 * MASS.inertia, 3.0 * MASS_POLE * MASS.inertia - MASS.viscous])
    logs = []
    for speed in SPEEDS:
        time = np.arange(SETTLE + PERIODS * 1000) * MASS_PERIOD
        reference = -speed / (2.0 * np.pi) * np.cos(2.0 * np.pi * time + generator.uniform(0.0, 2.0 * np.pi))
        x, u = np.empty(time.size), np.empty(time.size)
        state = np.asarray(rest(reference[0] + step * generator.random()))
        assert _position_loop(state, reference, gains, MASS.as_array(), step, MASS_PERIOD, x, u) == 0
        u += MASS_NOISE * generator.standard_normal(u.size)
        kept = slice(SETTLE, None)
        logs.append(make_record(f"{speed:g} m/s", time[kept], x[kept], u[kept], resolution=step, lag=0.0))
    return logs


def nonlinear_clutch() -> AxisParameters:
    """The clutch of configs/clutch/nonlinear.yaml: tables 4.5 to 4.8, 5.2."""
    return axis_of(load(ROOT / "configs" / "clutch" / "nonlinear.yaml", Model))
