"""`relax: auto` on the clutch: the position loop of 5.4.3, whose weights the thesis moved by hand,
and loops with derived weights.

python -m tests.accept build/accept.json "relax: position" "relax: position at 1 ms" "relax: speed"
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from frictool.adapters.model_polytope import polytope
from frictool.adapters.state_space import read_state_space
from frictool.documents.design import Design
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.documents.weights import Weights as Document
from frictool.lmi.hinf_synthesis import minimise, vertex_controllers
from frictool.plant.generalised_plant import GeneralisedPlant, PlantWeights, generalised_plant
from frictool.synth.design import design_controller
from frictool.synth.lpv import lpv
from frictool.synth.minimax import minimax
from frictool.synth.synthesis_problem import SynthesisProblem
from frictool.synth.weight_relaxation import Trade, relax
from frictool.synth.weights import choose_weights
from frictool.verify.encoder_count_drive import drive_after_count
from frictool.verify.hinf_norm import norm
from frictool.verify.speed_loop import check_loop, performance
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.synthesis_requirements import plants_that_meet

RIG = ROOT / "configs/clutch"
SPEC, SPEED = load(RIG / "spec.yaml", Spec), load(RIG / "designs/speed.yaml", Design)
LAG, PERIOD, RECENTRING, PLANTS = 3e-3, 1e-3, 1.05, 200
BOX = polytope(clutch_model())


def _trade(design: Design, plants: Callable[[PlantWeights], list[GeneralisedPlant]]) -> Trade:
    chosen = choose_weights(clutch_model(), SPEC, msgspec.structs.replace(design, relax="auto"))
    trade = relax(chosen, lambda weights: minimise(plants(weights), RECENTRING).gamma)
    for point in trade.curve:
        print(
            f"    W3 {point.drive:8.4f}   largest W1 {point.disturbance:10.6f}   gamma "
            f"{point.level:.4f}"
        )
    print(f"    {trade.why}")
    return trade


def relaxes_the_position_loop() -> dict[str, Any]:
    """z2 = 20 rad/s, no noise and no weight on the command, as in the text: gamma at most 1, and
    the vertices' true norms."""

    def plants(weights: PlantWeights) -> list[GeneralisedPlant]:
        return [generalised_plant("position", point.rates, LAG, weights) for point in BOX.vertices]

    given = Document(
        bandwidth_rad_s=20.0,
        disturbance=1.0,
        drive=1.26,
        command=0.0,
        noise=Quantity(value=0.0, unit="rad"),
    )
    trade = _trade(
        msgspec.structs.replace(SPEED, structure="position", position_law=None, weights=given),
        plants,
    )
    posed = plants(trade.weights)
    lyapunov = minimise(posed, RECENTRING)
    worst = max(
        norm(plant.closed(k))[0]
        for plant, k in zip(posed, vertex_controllers(posed, lyapunov), strict=True)
    )
    by_hand = next(p for p in sorted(trade.curve, key=lambda p: p.drive) if p.drive >= 0.05)
    passed = (
        trade.chosen.level <= 1.0 and worst <= 1.01 * lyapunov.gamma and by_hand.disturbance < 0.15
    )
    return {
        "passed": passed and len(trade.points) <= 48,
        "W1": trade.chosen.disturbance,
        "W3": trade.chosen.drive,
        "gamma": trade.chosen.level,
        "worst true norm": worst,
        "gamma at the start": trade.start.level,
        "solves": len(trade.points),
    }


def relaxes_the_speed_loop() -> dict[str, Any]:
    """Only z2 = 40 rad/s given, at 1 ms with one sample of delay: the controller found holds its
    margin, one count asks for less than the drive's limit, and random plants meet 5.4.1 in the
    non-linear simulation."""

    def plants(weights: PlantWeights) -> list[GeneralisedPlant]:
        return [
            generalised_plant("speed", point.rates, LAG, weights, PERIOD, 1)
            for point in BOX.vertices
        ]

    trade = _trade(msgspec.structs.replace(SPEED, weights=Document(bandwidth_rad_s=40.0)), plants)
    weights = trade.weights
    noise = Quantity(value=weights.noise.gain, unit="rad")
    found = Document(40.0, weights.disturbance, weights.drive, weights.command, noise)
    model, here = clutch_model(), Provenance("a check", "0")
    controller = design_controller(model, SPEC, msgspec.structs.replace(SPEED, weights=found), here)
    asks = drive_after_count(
        read_state_space(controller.linear.discrete, PERIOD), model.bench.encoder.resolution
    )
    margin = min(
        check.modulus_margin
        for vertex in controller.verified.vertices
        for check in vertex.checks
        if check.delay_samples == 1
    )
    inside = plants_that_meet(controller, model, SPEC, here, PLANTS)
    return {
        "passed": bool(
            trade.chosen.level <= 1.0
            and margin >= 0.6
            and asks <= 50.0
            and inside >= 0.99 * PLANTS
            and np.isfinite(asks)
        ),
        "W1": trade.chosen.disturbance,
        "W3": trade.chosen.drive,
        "gamma": trade.chosen.level,
        "modulus margin with one sample of delay": margin,
        "one count asks for, A": asks,
        f"inside the specification, of {PLANTS}": inside,
        "solves": len(trade.points),
    }


def relaxes_the_position_loop_as_it_runs() -> dict[str, Any]:
    """Only z2 = 20 rad/s given, at 1 ms with one sample of delay: the constant controller with the
    relaxed weights has every vertex's norm below 1 and the specified margin; the frozen one, on
    whose inequalities the weights were relaxed, has not."""
    model = clutch_model()
    design = msgspec.structs.replace(
        SPEED,
        structure="position",
        position_law=None,
        weights=Document(bandwidth_rad_s=20.0),
        relax="auto",
    )

    def plants(weights: PlantWeights) -> list[GeneralisedPlant]:
        return [
            generalised_plant("position", point.rates, LAG, weights, PERIOD, 1)
            for point in BOX.vertices
        ]

    trade = _trade(design, plants)
    asked = msgspec.structs.replace(design, method="minimax", order=4)
    posed, full = (
        SynthesisProblem(BOX, LAG, PERIOD, 1, trade.weights, one, model, SPEC)
        for one in (asked, design)
    )
    told: dict[str, Any] = {
        "W1": trade.chosen.disturbance,
        "W3": trade.chosen.drive,
        "gamma": trade.chosen.level,
    }
    norms, margins = {}, {}
    for name, k in (("minimax", minimax(posed).controller), ("frozen", lpv(full).controller)):
        norms[name] = told[f"worst norm, {name}"] = max(
            performance(k, posed.running(point.rates)) for point in BOX.vertices
        )
        margins[name] = told[f"modulus margin, {name}"] = min(
            check_loop(k, point.rates, LAG, 1).modulus_margin for point in BOX.vertices
        )
    passed = (
        trade.chosen.level <= 1.0
        and norms["minimax"] <= 1.0 < norms["frozen"]
        and margins["minimax"] >= 0.5 > margins["frozen"]
    )
    return {"passed": passed, **told}


CHECKS = {
    "relax: position": relaxes_the_position_loop,
    "relax: position at 1 ms": relaxes_the_position_loop_as_it_runs,
    "relax: speed": relaxes_the_speed_loop,
}
