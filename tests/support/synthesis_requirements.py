"""Requirements of a specification, on random plants."""

from __future__ import annotations

import msgspec

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec
from frictool.report.verdict import judge
from frictool.simulate.closed_loop import simulate_closed_loop
from studies.rigs.clutch_model import ROOT

RIG = ROOT / "configs/clutch"


def plants_that_meet(
    controller: Controller, model: Model, spec: Spec, origin: Provenance, plants: int
) -> int:
    """Return the number of `plants` random plants on which steps of 50 and 20 rad and a hold of 16
    s meet `spec` but for its margin."""
    steps = load(RIG / "scenarios/steps.yaml", Scenario)
    long_hold = (steps.steps[0], Step(reference=steps.steps[-1].reference, duration_s=16.0))
    drawn = msgspec.structs.replace(
        steps, steps=long_hold, variants="random", plants=plants, seed=11
    )
    log, alone = (
        simulate_closed_loop(model, controller, drawn, origin),
        msgspec.structs.replace(spec, modulus_margin=None),
    )
    streams = log.streams[1:]  # the first is the nominal plant's
    if len(streams) != plants:
        raise RuntimeError(f"{len(streams)} plants were played, required: {plants}")
    verdicts = [
        judge(alone, [type(log)((stream,), log.metadata, stream.topic)], controller)
        for stream in streams
    ]
    return sum(all(item.met for item in verdict.requirements) for verdict in verdicts)
