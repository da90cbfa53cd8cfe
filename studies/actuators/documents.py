"""Documents of an actuator: bench, model, specification and scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from studies.actuators.drawing import VARIED, Actuator, Interval, Plant

SOURCE = "drawn by studies.actuators"


def write(actuator: Actuator, folder: Path) -> None:
    """Write bench.yaml, model.yaml, spec.yaml and steps.yaml into the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, document in (
        ("bench", bench(actuator)),
        ("model", model(actuator)),
        ("spec", spec(actuator)),
        ("steps", scenario(actuator)),
    ):
        text = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=100)
        (folder / f"{name}.yaml").write_text(text)


def bench(actuator: Actuator) -> dict[str, Any]:
    """Return the bench of the actuator."""
    units = _units(actuator)
    turns = actuator.counts_per_turn
    drive_column = {"column": actuator.drive, "unit": units["drive"]}
    return {
        "format": "bench/1",
        "name": actuator.name,
        "axis": actuator.axis,
        "sample_period_s": actuator.period,
        "delay_samples": actuator.delay,
        "encoder": {"counts_per_revolution": turns}
        if turns
        else {"step": {"value": actuator.encoder_step, "unit": "m"}},
        "actuator": {
            "drive": actuator.drive,
            "constant": _quantity(actuator.constant, units["constant"]),
            "limit": {"value": actuator.limit, "unit": units["drive"]},
            "loop_time_constant_s": actuator.lag,
        },
        "mechanics": {
            "inertia": _quantity(actuator.inertia, units["inertia"]),
            "viscous": _quantity(actuator.viscous, units["viscous"]),
            "coulomb": _quantity(actuator.coulomb, units["effort"]),
            "backlash": {"value": actuator.backlash, "unit": units["position"]},
            "backlash_coulomb": {"value": actuator.backlash_coulomb, "unit": units["effort"]},
            "travel": {"low": 0.0, "high": actuator.travel, "unit": units["position"]},
            "top_speed": {
                "value": top_speed(actuator),
                "unit": units["speed"],
            },
        },
        "columns": {
            "time": {"column": "time", "unit": "s"},
            "position": {"column": "encoder", "unit": "count"},
            actuator.drive: drive_column,
        },
    }


def top_speed(actuator: Actuator) -> float:
    """Return the top speed of the bench, rad/s | m/s."""
    return float(f"{3.0 * actuator.amplitude / actuator.bang_bang:.3g}")


def model(actuator: Actuator) -> dict[str, Any]:
    """Return the model of the actuator, with intervals over the product's life."""
    units = _units(actuator)
    breakaway = actuator.breakaway_ratio * actuator.coulomb.value
    values = {
        "inertia": _quantity(actuator.inertia, units["inertia"]),
        "viscous": _quantity(actuator.viscous, units["viscous"]),
        "coulomb": _quantity(actuator.coulomb, units["effort"]),
        "breakaway": {"value": breakaway, "unit": units["effort"]},
        "offset": {"value": 0.0, "unit": units["effort"]},
    }
    return {
        "format": "model/1",
        "name": actuator.name,
        "axis": actuator.axis,
        "law": "coulomb",
        "method": SOURCE,
        "confidence": 0.95,
        "bench": bench(actuator),
        "parameters": {name: {**value, "source": "identified"} for name, value in values.items()},
        "provenance": {"command": SOURCE, "frictool": "0.1.0", "inputs": []},
    }


def spec(actuator: Actuator) -> dict[str, Any]:
    """Return the specification of the actuator."""
    units = _units(actuator)
    return {
        "format": "spec/1",
        "name": actuator.name,
        "axis": actuator.axis,
        "drive": actuator.drive,
        "response_time_95_s": actuator.response,
        "overshoot_percent": actuator.overshoot,
        "static_error": {"value": actuator.static_error, "unit": units["position"]},
        "oscillations": actuator.oscillations,
        "modulus_margin": actuator.margin,
        "drive_peak": {"value": actuator.limit, "unit": units["drive"]},
        "rest": {"after_s": actuator.rest_after, "drive": 0.0},
    }


def scenario(actuator: Actuator) -> dict[str, Any]:
    """Return a step over most of the travel, and the step back with a long hold."""
    position = _units(actuator)["position"]
    there, back = actuator.start + actuator.amplitude, actuator.start
    return {
        "format": "scenario/1",
        "name": "steps",
        "axis": actuator.axis,
        "drive": actuator.drive,
        "start": {"value": back, "unit": position},
        "variants": "vertices",
        "seed": 1,
        "steps": [
            {"reference": {"value": value, "unit": position}, "duration_s": duration}
            for value, duration in ((there, actuator.short_hold), (back, actuator.long_hold))
        ],
    }


def scenario_of(actuator: Actuator, plant: Plant) -> dict[str, Any]:
    """Return `scenario` for one plant, with the plant's start position."""
    units = _units(actuator)
    start = actuator.start + plant.phase * actuator.encoder_step
    keys = {**units, "coulomb": units["effort"]}
    return {
        **scenario(actuator),
        "start": {"value": start, "unit": units["position"]},
        "variants": "given",
        "given": {name: {"value": getattr(plant, name), "unit": keys[name]} for name in VARIED},
    }


def _units(actuator: Actuator) -> dict[str, str]:
    drive = "A" if actuator.drive == "current" else "V"
    if actuator.axis == "rotary":
        names = "rad", "rad/s", "kg m^2", "N m", "N m s/rad"
    else:
        names = "m", "m/s", "kg", "N", "N s/m"
    units = dict(zip(("position", "speed", "inertia", "effort", "viscous"), names, strict=True))
    return {**units, "drive": drive, "constant": f"{units['effort']}/{drive}"}


def _quantity(interval: Interval, unit: str) -> dict[str, Any]:
    return {**interval._asdict(), "unit": unit}
