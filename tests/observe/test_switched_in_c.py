"""A controller whose speed comes from a switched observer, exported: its C equals the simulation
bit by bit, in double and in float."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, control_step, start_at
from frictool.documents.controller import Controller, Number, Velocity
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import run_along
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller
from tests.support.compiled_c import COMPILERS, in_format, library, needs_compiler, simulated, write
from tests.support.example_observers import drawn_observer
from tests.support.export_inputs import rows_for

SAMPLES = 1500
Kind = Literal["multiplicative", "additive"]


def _controller(kind: Kind) -> Controller:
    """A cascade with (5.70)'s place taken by an observer, and a band that brakes by its speed."""
    return msgspec.structs.replace(
        clutch_controller(BRAKE_LAW),
        velocity=Velocity("observer", observer=drawn_observer(3, kind, viscous=4e-4, offset=0.01)),
    )


@needs_compiler
@pytest.mark.parametrize("number", ["double", "float"])
@pytest.mark.parametrize("kind", ["multiplicative", "additive"])
def test_the_exported_c_is_the_simulation_bit_by_bit(
    kind: Kind, number: Number, tmp_path: Path
) -> None:
    controller = _controller(kind)
    program = controller_program(controller)
    write(controller, tmp_path, number)
    play = library(controller, number, tmp_path, COMPILERS[0], "-O2")
    rows = in_format(program, number, rows_for(controller, program, SAMPLES, 5))
    drives = simulated(program, number, rows)
    assert np.unique(drives).size > 100
    assert np.array_equal(play(rows), drives)


@pytest.mark.parametrize("kind", ["multiplicative", "additive"])
def test_in_the_loop_it_is_the_observer_along_the_log(kind: Kind) -> None:
    """The speed that the controller uses is what `observe run` finds from the same positions and
    efforts, every bit: with a drive that has no lag, whose effort the log has at each sample."""
    controller = _controller(kind)
    bench = controller.bench
    actuator = msgspec.structs.replace(bench.actuator, loop_time_constant_s=0.0)
    controller = msgspec.structs.replace(
        controller, bench=msgspec.structs.replace(bench, actuator=actuator)
    )
    program, observer = controller_program(controller), controller.velocity.observer
    assert observer is not None
    running, rows = compile_program(program), rows_for(controller, program, SAMPLES, 6)
    names = list(program.inputs)
    reference, position = (rows[:, names.index(name)] for name in ("reference", "position"))
    start_at(running, float(position[0]))
    place, speeds, drives = (
        program.states["estimated_velocity"].index,
        np.empty(SAMPLES),
        np.empty(SAMPLES),
    )
    for k in range(SAMPLES):
        speeds[k] = running.real[place]
        drives[k] = control_step(running, float(reference[k]), float(position[k]), 0.0)
    acted = np.concatenate(
        [np.zeros(controller.delay_samples), drives[: SAMPLES - controller.delay_samples]]
    )
    effort = controller.bench.actuator.constant.value * acted
    piece = MotionBlock(
        controller.sample_period_s * np.arange(SAMPLES), position, effort, follows=False
    )
    found = next(run_along(observer, [piece]))
    assert np.count_nonzero(found.velocity) > SAMPLES // 2
    assert np.array_equal(found.velocity, speeds)
