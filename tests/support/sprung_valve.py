"""A valve with a return spring: bench, model and design of a positioner that releases its drive in
a band around the target."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar, cast

import msgspec

from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.document_reader import DocumentReader
from frictool.documents.document_text import compose
from frictool.documents.laws import Laws, Load
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Estimate
from frictool.documents.spec import Spec
from frictool.plan.assumed_axis import assumed_axis
from frictool.synth.design import design_controller

Document = TypeVar("Document", bound=msgspec.Struct)

BENCH = """\
format: bench/1
name: valve
axis: rotary
sample_period_s: 0.002
delay_samples: 1
encoder: {counts_per_revolution: 4096}
actuator:
  drive: current
  constant: {value: 4, unit: N m/A}
  limit: {value: 8, unit: A}
  loop_time_constant_s: 0.001
mechanics:
  inertia: {value: 0.13, low: 0.06, high: 0.25, unit: kg m^2}
  viscous: {value: 4, low: 2, high: 7, unit: N m s/rad}
  coulomb: {value: 9.3, low: 9.2, high: 9.4, unit: N m}
  travel: {low: 0, high: 1.6, unit: rad}
columns:
  time: {column: time, unit: s}
  position: {column: encoder, unit: count}
  current: {column: current, unit: A}
"""
SPEC = """\
format: spec/1
name: valve
axis: rotary
drive: current
static_error: {value: 0.01, unit: rad}
modulus_margin: 0.5
"""
DESIGN = """\
format: design/1
name: valve
axis: rotary
structure: speed_cascade
method: pid
weights: {}
position_law:
  action: brake
  formula: sqrt(F/J)
  band: {value: 0.006, unit: rad}
  settled_speed: {value: 0.26, unit: rad/s}
  rest_speed: {value: 0.035, unit: rad/s}
prefilter: {natural_frequency_rad_s: 13, damping: 0.8}
velocity: {order: 1, filter_rad_s: 700}
pid:
  speed_gain: {value: 7, unit: N m s/rad}
  integral_time_s: 0.15
"""
VALUES = {
    "inertia": 0.13,
    "viscous": 4.0,
    "coulomb": 9.3,
    "breakaway": 12.0,
    "offset": 0.3,
}  # SI


def parsed(text: str, kind: type[Document]) -> Document:
    """Return the document in `text`."""
    path = Path(f"{kind.__name__}.yaml")
    return cast(Document, DocumentReader(path).read(compose(text, path), kind, ""))


def valve(low: float, value: float, high: float, travel: bool = True) -> Model:
    """Return the model with a spring of stiffness `value`, between low and high [N m/rad]."""
    bench = parsed(BENCH, Bench)
    if not travel:
        bench = msgspec.structs.replace(
            bench, mechanics=msgspec.structs.replace(bench.mechanics, travel=None)
        )
    spring = Estimate(value, low, high, "N m/rad", source="identified")
    return msgspec.structs.replace(
        assumed_axis(bench, VALUES), laws=Laws(load=Load(stiffness=spring))
    )


def positioner(model: Model) -> Controller:
    """Return the controller of DESIGN, verified at the vertices of the model."""
    spec, design = parsed(SPEC, Spec), parsed(DESIGN, Design)
    return design_controller(model, spec, design, Provenance("test", "0"))
