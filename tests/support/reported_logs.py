"""Reports of simulated logs, compared with the known truth."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np

from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec
from frictool.logs.log import Log, Stream
from frictool.report.verdict import judge
from frictool.simulate.closed_loop import simulate_closed_loop
from frictool.synth.design import design_controller
from studies.rigs.clutch_model import ROOT, clutch_model
from studies.table_5_1.published_figures import LOOPS, TOLERANCE, deviation

HERE = Provenance("check", "0")
MASS, CLUTCH = ROOT / "configs/mass", ROOT / "configs/clutch"
PLANTS = 300


def metres(value: float) -> Quantity:
    """In SI."""
    return Quantity(value=value, unit="m")


STEP = Scenario(
    "scenario/1",
    "step",
    "linear",
    start=metres(0.0),
    steps=(Step(reference=metres(1.0), duration_s=600.0),),
)
RANDOM = Scenario(
    "scenario/1",
    "random plants",
    "rotary",
    start=Quantity(value=5.0, unit="rad"),
    variants="random",
    plants=PLANTS,
    seed=5,
    steps=tuple(
        Step(reference=Quantity(value=value, unit="rad"), duration_s=1.1)
        for value in (55.0, 5.0, 35.0, 15.0)
    ),
)


def designed(model: Model, spec: Spec, design: Design) -> Controller:
    """A verified controller, without what is proved beyond the vertices."""
    return design_controller(model, spec, design, HERE)


def limit_cycle(name: str) -> dict[str, Any]:
    """Amplitude and period that the report tells of a loop held for 600 s, within 2 % of table
    5.1's."""
    model = load(MASS / ("smooth.yaml" if name.startswith("smooth") else "model.yaml"), Model)
    spec = load(MASS / "spec.yaml", Spec)
    controller = designed(model, spec, load(MASS / f"designs/{name}.yaml", Design))
    log = simulate_closed_loop(model, controller, STEP, HERE)
    asked = msgspec.structs.replace(spec, limit_cycle=metres(0.0))
    verdict = judge(asked, [log], controller)
    found = verdict.evidence[0][1][0].values
    amplitude, period = (
        found["limit_cycle_amplitude"],
        found.get("limit_cycle_period", float("nan")),
    )
    printed = LOOPS[name].printed[3:]
    away = [
        abs(deviation(value, known))
        for value, known in zip((amplitude, period), printed, strict=True)
    ]
    cycles = float(printed[0]) > 0.0
    said = next(item.met for item in verdict.requirements if item.name == "limit_cycle")
    right = (max(away) <= TOLERANCE if cycles else amplitude == 0.0) and said is not cycles
    return {
        "passed": right,
        "amplitude_m": amplitude,
        "period_s": period if cycles else None,
        "printed": list(printed),
    }


def load_behind_the_backlash(plants: int = PLANTS) -> dict[str, Any]:
    """The bounds from motor position and backlash hold the load's error and overshoot, in every
    hold of random plants."""
    model, spec = clutch_model(), load(CLUTCH / "spec.yaml", Spec)
    controller = designed(model, spec, load(CLUTCH / "designs/fast.yaml", Design))
    log = simulate_closed_loop(
        model, controller, msgspec.structs.replace(RANDOM, plants=plants), HERE
    )
    known = judge(spec, [log], controller).evidence
    bounded = judge(spec, [_without_load(log)], controller).evidence
    outside, widths, metrics = 0, [], 0
    for (_, true), (_, bounds) in zip(known, bounded, strict=True):
        for exact, between in zip(true, bounds, strict=True):
            for name, (low, high) in between.bounds.items():
                metrics += 1
                outside += not low - 1e-9 <= exact.values[name] <= high + 1e-9
                if name == "load_static_error":
                    widths.append(high - low)
    step = controller.bench.encoder.resolution
    narrow = float(np.max(widths)) <= 2.0 * step * (1.0 + 1e-9)
    figures = {
        "plants": plants,
        "metrics": metrics,
        "outside": outside,
        "widest_rad": float(np.max(widths)),
        "encoder_step_rad": step,
    }
    return {"passed": outside == 0 and narrow and metrics >= 8 * plants, **figures}


def _without_load(log: Log) -> Log:
    """As a bench would have recorded it."""
    streams = []
    for stream in log.streams:
        kept = {name: values for name, values in stream.signals.items() if name != "load_position"}
        streams.append(
            Stream(stream.topic, stream.time, kept, {name: stream.units[name] for name in kept})
        )
    return Log(tuple(streams), log.metadata, log.source)
