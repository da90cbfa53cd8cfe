"""Controller documents for tests without a synthesis."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from scipy import signal

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import CompiledProgram, compile_program, start_at
from frictool.documents.bench import Bench
from frictool.documents.controller import (
    Controller,
    DelayCheck,
    LinearController,
    PositionLaw,
    Prefilter,
    Velocity,
    Verified,
    Vertex,
)
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.engine.closed_loop import MEASURED, RECORD_SIZE, measure, run
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.status_codes import OK
from frictool.plant.axis import AxisParameters, rest
from frictool.plant.lti import Lti
from frictool.plant.position_load import PositionLoad
from frictool.synth.realisation import stored_forms

ROOT = Path(__file__).parents[2]
CONSTANT = 13.4e-3
# K_p (s + 1/T_i) on eta with two poles, N m per rad: a PI speed controller with a lag and a
# roll-off
GAIN, ZERO, POLES = 1.6e-3, 1 / 0.047, (1793.0, 3000.0)
CUT_LAW = PositionLaw(gain=81.1, formula="sqrt(F/J)", band=2.0, action="cut", settled_speed=5.0)
BRAKE_LAW = PositionLaw(
    gain=160.0, formula="sqrt(2F/J)", band=1.1, action="brake", settled_speed=5.0, rest_speed=40.0
)


def _discrete(continuous: tuple[Any, ...], period: float) -> LinearController:
    a, b, c, d, _ = signal.cont2discrete(continuous, period, "bilinear")
    return stored_forms(Lti(a, b, c, d, period))


def speed_controller(period: float = 1e-3) -> LinearController:
    """Return a stable controller of order 2 whose direct term is some 8 A per encoder count."""
    gain = GAIN / CONSTANT * POLES[0] * POLES[1]
    continuous = signal.zpk2ss([-ZERO], [-p for p in POLES], gain)
    return _discrete(continuous, period)


def clutch_controller(
    law: PositionLaw = CUT_LAW,
    *,
    prefilter: bool = True,
    speed: LinearController | None = None,
    limit: float = 50.0,
) -> Controller:
    """Return a controller of the clutch, sampled at 1 ms: encoder with 56 counts per turn."""
    vertex = Vertex(
        "nominal",
        1.32e-5,
        3.81e-4,
        0.099,
        CONSTANT,
        1.0,
        1.0,
        0.6,
        True,
        (DelayCheck(0, 0.98, 0.6), DelayCheck(1, 0.98, 0.5)),
    )
    return Controller(
        format="controller/1",
        name="speed",
        axis="rotary",
        structure="speed_cascade",
        method="lpv",
        domain="discrete",
        sample_period_s=1e-3,
        delay_samples=1,
        drive="current",
        drive_limit=limit,
        sign_convention="eta = integral(speed reference) - position; drive = K eta; a positive "
        "drive moves the axis forward",
        linear=speed or speed_controller(),
        position_law=law,
        verified=Verified(1.0, 1.0, 0.5, (vertex,)),
        bench=load(ROOT / "configs/clutch/bench.yaml", Bench),
        provenance=Provenance("frictool synth model.yaml", "0"),
        velocity=Velocity(bandwidth_rad_s=150.0) if law.action == "brake" else Velocity(),
        prefilter=Prefilter(natural_frequency_rad_s=30.0, damping=0.8) if prefilter else None,
    )


def started(controller: Controller, position: float) -> CompiledProgram:
    """Return the controller's program in double, at rest at `position` [rad]."""
    made = compile_program(controller_program(controller))
    start_at(made, position)
    return made


def emps_controller() -> Controller:
    """Return a controller of the EMPS carriage, with a drive limit of 10 V, sampled at 1 ms.

    The encoder step is 50 nm and the crossover frequency about 80 rad/s. Virtual friction brakes.
    """
    continuous = signal.zpk2ss([-20.0], [-1500.0, -2500.0], 210.0 * 1500.0 * 2500.0)
    linear = _discrete(continuous, 1e-3)
    law = PositionLaw(
        gain=1.45,
        formula="sqrt(2F/J)",
        band=1e-4,
        action="brake",
        settled_speed=1e-3,
        rest_speed=2e-3,
    )
    return msgspec.structs.replace(
        clutch_controller(BRAKE_LAW, speed=linear, limit=10.0),
        axis="linear",
        drive="voltage",
        position_law=law,
        velocity=Velocity(bandwidth_rad_s=500.0),
        prefilter=Prefilter(natural_frequency_rad_s=15.0, damping=0.9),
        bench=load(ROOT / "configs/emps/bench.yaml", Bench),
    )


def closed_loop_inputs(
    controller: Controller, start: float, target: float, samples: int = 1200
) -> list[dict[str, float]]:
    """Return the inputs of the controller in a closed loop with its bench, one row per sample.

    The reference is a step to `target`, then a step half-way back.
    """
    bench = controller.bench
    mechanics, actuator = bench.mechanics, bench.actuator
    axis = AxisParameters(
        inertia=mechanics.inertia.value, viscous=mechanics.viscous.value,
        coulomb=mechanics.coulomb.value,
        breakaway=1.1 * mechanics.coulomb.value, constant=actuator.constant.value,
        lag=actuator.loop_time_constant_s,
        drive_limit=actuator.limit.value, encoder_step=bench.encoder.resolution,
    )  # fmt: skip
    references = np.where(np.arange(samples) < samples // 2, target, 0.5 * (start + target))
    record = np.zeros((samples, RECORD_SIZE))
    made = started(controller, measure(start, axis.encoder_step))
    status = run(
        axis.as_array(),
        rest(start),
        made,
        references,
        bench.sample_period_s,
        1,
        record,
        PositionLoad().as_array(),
        NO_CONDITIONS,
    )
    assert status == OK
    positions = record[:, MEASURED]
    return [
        {"reference": float(r), "position": float(y)}
        for r, y in zip(references, positions, strict=True)
    ]
