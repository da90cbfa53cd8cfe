"""Turntable with dry friction and a coarse encoder, and its specifications."""

from __future__ import annotations

import msgspec

from frictool.documents.bench import Bench
from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate
from frictool.documents.spec import Spec

RANGES = {  # low, value, high [SI]
    "inertia": (0.018, 0.02, 0.022),
    "viscous": (0.04, 0.05, 0.06),
    "coulomb": (1.35, 1.5, 1.65),
    "breakaway": (1.4, 1.7, 7.0),
}
UNITS = {
    "inertia": "kg m^2",
    "viscous": "N m s/rad",
    "coulomb": "N m",
    "breakaway": "N m",
    "offset": "N m",
}


def turntable(**others: tuple[float, float, float]) -> Model:
    """Return a turntable with a coarse encoder; `others` replace RANGES."""
    ranges = {**RANGES, **others}
    mechanics = {
        name: {"low": low, "value": value, "high": high, "unit": UNITS[name]}
        for name, (low, value, high) in ranges.items()
    }
    bench = {
        "format": "bench/1",
        "name": "turntable",
        "axis": "rotary",
        "sample_period_s": 0.004,
        "delay_samples": 1,
        "encoder": {"step": {"value": 0.004, "unit": "rad"}},
        "actuator": {
            "drive": "current",
            "constant": {"low": 0.78, "value": 0.8, "high": 0.82, "unit": "N m/A"},
            "limit": {"value": 12, "unit": "A"},
        },
        "mechanics": {
            **mechanics,
            "travel": {"low": 0.0, "high": 6.0, "unit": "rad"},
            "top_speed": {"value": 15, "unit": "rad/s"},
        },
        "columns": {"time": {"column": "time", "unit": "s"}},
    }
    estimates = {
        name: Estimate(low=low, value=value, high=high, unit=UNITS[name], source="bench")
        for name, (low, value, high) in {**ranges, "offset": (0.0, 0.0, 0.0)}.items()
    }
    return Model(
        format="model/1",
        name="turntable",
        axis="rotary",
        law="coulomb",
        method="bench",
        confidence=0.95,
        bench=msgspec.convert(bench, Bench),
        parameters=Parameters(**estimates),
        provenance=Provenance("a test", "0"),
    )


def specified(response_s: float, overshoot: float, error: float) -> Spec:
    """Return a specification: 95 % response time [s], overshoot [%] and static error [rad]."""
    spec = {
        "format": "spec/1",
        "name": "turntable",
        "axis": "rotary",
        "drive": "current",
        "response_time_95_s": response_s,
        "overshoot_percent": overshoot,
        "static_error": {"value": error, "unit": "rad"},
        "modulus_margin": 0.5,
    }
    return msgspec.convert(spec, Spec)


POSSIBLE, IMPOSSIBLE = specified(0.4, 5.0, 0.008), specified(0.25, 0.1, 0.0045)
