"""A bench and models with known parameters, for exports to simulators."""

from __future__ import annotations

from typing import Any

import numpy as np
from msgspec.structs import replace

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate
from frictool.documents.registry import load
from tests.support.documentation_pages import ROOT

BENCH = """format: bench/1
name: known
axis: rotary
sample_period_s: 0.001
encoder: {step: {value: 1e-5, unit: rad}}
actuator:
  drive: current
  constant: {value: 0.1, low: 0.09, high: 0.11, unit: N m/A}
  limit: {value: 20, unit: A}
mechanics:
  inertia: {value: 2e-3, unit: kg m^2}
  viscous: {value: 0.01, unit: N m s/rad}
  coulomb: {value: 0.2, unit: N m}
columns:
  time: {column: time, unit: s}
  position: {column: position, unit: rad}
  current: {column: current, unit: A}
"""


def estimate(value: float, unit: str, half_width: float = 0.0) -> Estimate:
    return Estimate(value, value - half_width, value + half_width, unit, source="identified")


def known_model(bench: Bench) -> Model:
    """Linear and Coulomb friction, with an offset."""
    made = load(ROOT / "configs/clutch/nonlinear.yaml", Model)
    parameters = replace(
        made.parameters,
        inertia=estimate(2.5e-3, "kg m^2", 1e-4),
        viscous=estimate(0.008, "N m s/rad", 1e-3),
        coulomb=estimate(0.25, "N m", 0.01),
        breakaway=estimate(0.25, "N m"),
        offset=estimate(0.05, "N m"),
    )
    return replace(made, name="known", bench=bench, parameters=parameters, laws=None)


def known_effort(time: Any) -> Any:
    """Effort [N m] that moves the axis of `BENCH` in both directions."""
    return 0.6 * np.sin(2 * np.pi * 0.5 * time) + 0.4 * np.sin(2 * np.pi * 1.7 * time)
