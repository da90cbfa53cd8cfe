"""Benches of the study, and actuators drawn within their a-priori intervals."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import provenance_of_call
from frictool.documents.quantity import Estimate, Quantity, si_unit
from frictool.documents.registry import load
from frictool.identify.fit_result import DIMENSIONS

CONFIGS = Path(__file__).parents[2] / "configs"
BREAKAWAY_RATIO = 1.1


class RigFigures(NamedTuple):
    """Figures of a bench in SI: intervals are value times (1 - spread) to (1 + spread)."""

    name: str
    axis: str
    period: float  # s
    step: float  # encoder step, rad | m
    constant: float  # effort per ampere
    limit: float  # A
    inertia: float
    viscous: float
    coulomb: float
    travel: float
    speed: float
    spread: float = 0.4


# a joint, two servos, an arm's shoulder, a belt, a valve, a table, a pump and a positioning stage
FIGURES = (
    RigFigures("joint-2000", "rotary", 1e-3, 3.14159e-3, 0.1, 10.0, 1e-3, 0.01, 0.08, 3.0, 10.0),
    RigFigures("servo-24", "rotary", 1e-3, 0.2618, 0.02, 10.0, 2e-5, 1e-4, 0.02, 60.0, 200.0),
    RigFigures("arm", "rotary", 1e-3, 1e-4, 5.0, 10.0, 0.5, 1.0, 4.0, 2.5, 3.0),
    RigFigures("belt", "linear", 1e-3, 1e-5, 20.0, 10.0, 4.0, 10.0, 25.0, 0.8, 1.5),
    RigFigures("slow-valve", "rotary", 1e-2, 2e-3, 2.0, 3.0, 5e-3, 0.5, 1.2, 1.4, 1.0),
    RigFigures("table", "linear", 1e-3, 1e-6, 60.0, 8.0, 40.0, 150.0, 60.0, 0.4, 0.5),
    RigFigures("pump", "rotary", 5e-4, 1e-3, 0.05, 20.0, 5e-5, 5e-4, 0.05, 40.0, 300.0),
    RigFigures("stage", "linear", 1e-3, 1e-7, 10.0, 4.0, 2.0, 8.0, 6.0, 0.1, 0.3),
)


def benches() -> list[Bench]:
    """Return the ten benches: those of FIGURES, the clutch and EMPS."""
    made = [_bench(one) for one in FIGURES]
    return [*made, *(load(CONFIGS / name / "bench.yaml", Bench) for name in ("clutch", "emps"))]


def truth(bench: Bench, seed: int) -> Model:
    """Return an actuator drawn uniformly within the middle of the bench's intervals."""
    draw = np.random.default_rng([seed, 26])
    known = bench.mechanics

    def drawn(name: str) -> float:
        quantity: Quantity = getattr(known, name)
        low, high = quantity.interval
        middle = quantity.value + draw.uniform(-0.5, 0.5) * min(
            high - quantity.value, quantity.value - low
        )
        return float(middle)

    values = {name: drawn(name) for name in ("inertia", "viscous", "coulomb")}
    values |= {"offset": 0.0, "breakaway": BREAKAWAY_RATIO * values["coulomb"]}
    estimates = {
        name: Estimate(value, value, value, si_unit(DIMENSIONS[name], bench.axis), source="assumed")
        for name, value in values.items()
    }
    parameters = Parameters(**estimates)
    return Model(
        format="model/1",
        name=bench.name,
        axis=bench.axis,
        law=parameters.law,
        method="none",
        confidence=0.95,
        bench=bench,
        parameters=parameters,
        provenance=provenance_of_call("studies.promises.rigs.truth"),
        not_identified={},
    )


def _bench(rig: RigFigures) -> Bench:
    import msgspec

    length = "rad" if rig.axis == "rotary" else "m"
    effort = "N m" if rig.axis == "rotary" else "N"
    units = ("kg m^2", "N m s/rad", effort) if rig.axis == "rotary" else ("kg", "N s/m", effort)

    def around(value: float, unit: str) -> dict[str, object]:
        low, high = value * (1.0 - rig.spread), value * (1.0 + rig.spread)
        return {"value": value, "low": low, "high": high, "unit": unit}

    return msgspec.convert(
        {
            "format": "bench/1",
            "name": rig.name,
            "axis": rig.axis,
            "sample_period_s": rig.period,
            "encoder": {"step": {"value": rig.step, "unit": length}},
            "actuator": {
                "drive": "current",
                "constant": {"value": rig.constant, "unit": f"{effort}/A"},
                "limit": {"value": rig.limit, "unit": "A"},
            },
            "mechanics": {
                "inertia": around(rig.inertia, units[0]),
                "viscous": around(rig.viscous, units[1]),
                "coulomb": around(rig.coulomb, units[2]),
                "travel": {"low": 0.0, "high": rig.travel, "unit": length},
                "top_speed": {"value": rig.speed, "unit": f"{length}/s"},
            },
            "columns": {
                "time": {"column": "time", "unit": "s"},
                "position": {"column": "position", "unit": length},
                "current": {"column": "current", "unit": "A"},
            },
        },
        Bench,
    )
