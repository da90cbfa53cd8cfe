"""Commands of a supervisor: the simulated controller and the exported C obey them alike, and the
axis does what each command is for."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import control_step, start_at
from frictool.control.number_format import machine_in
from frictool.control.supervision import SupervisedProgram
from frictool.documents.conditions import ControllerCommand, SensorFault
from frictool.documents.controller import ProgramNumber
from frictool.documents.provenance import Provenance
from frictool.errors import DocumentError
from frictool.logs.log import Log
from frictool.simulate.closed_loop import SimulationRequest, simulate_closed_loop
from frictool.simulate.compiled_target import COMPILERS, compiled_target
from studies.rigs.clutch_model import clutch_model
from studies.rigs.step_scenario import controller, scenario
from tests.support.compiled_c import NUMBERS, sources

SHA256 = "0" * 64  # of the sources that tests.support.compiled_c writes
HELD = (
    ControllerCommand("hold", 0.1),
    ControllerCommand("follow", 0.4),
    ControllerCommand("disable", 0.52),
    ControllerCommand("enable", 0.54),
    ControllerCommand("fault", 0.58),
    ControllerCommand("enable", 0.59),
    ControllerCommand("reset", 0.62),
)


def played(
    commands: tuple[ControllerCommand, ...],
    request: SimulationRequest,
    faults: tuple[SensorFault, ...] = (),
) -> Log:
    steps = scenario(40.0, 25.0, seconds=0.5, sensor_faults=faults, commands=commands)
    return simulate_closed_loop(
        clutch_model(), controller(), steps, Provenance("test", "0"), request=request
    )


@pytest.mark.parametrize("number", NUMBERS)
def test_simulation_and_exported_code_obey_alike(number: ProgramNumber, tmp_path: Path) -> None:
    if not any(map(shutil.which, COMPILERS)):
        pytest.skip("no C compiler on the PATH")
    for name, text in sources(controller(), number).items():
        (tmp_path / name).write_text(text)
    inputs = tuple(controller_program(controller()).inputs)
    code = compiled_target(tmp_path, SHA256, "controller.yaml", inputs)
    lost = (SensorFault("encoder_invalid", 0.541, 0.543),)
    simulated = played(HELD, SimulationRequest(number=number), lost)
    assert played(HELD, SimulationRequest(target=code), lost).streams == simulated.streams


def test_each_command_does_what_it_is_for() -> None:
    signals = played(HELD, SimulationRequest()).main.signals
    command, position, fault = (
        signals[name] for name in ("command", "position_true", "controller_fault")
    )
    assert not command[520:540].any()
    assert not command[580:620].any()
    assert command[540:580].any()
    assert command[620:].any()
    assert np.flatnonzero(fault).tolist() == list(range(580, 620))
    assert abs(position[499] - 40.0) < 2.0  # the first step, held before it ended
    free = played((), SimulationRequest()).main.signals
    np.testing.assert_array_equal(position[:520], free["position_true"][:520])


def test_a_held_axis_stays_although_the_reference_moves() -> None:
    commands = (ControllerCommand("hold", 0.45), ControllerCommand("follow", 0.9))
    signals = played(commands, SimulationRequest()).main.signals
    free = played((), SimulationRequest()).main.signals
    assert signals["reference"][700] == 25.0
    assert abs(signals["position_true"][899] - 40.0) < 2.0
    assert abs(free["position_true"][899] - 25.0) < 2.0
    assert signals["position_true"][-1] < signals["position_true"][899]


@pytest.mark.parametrize("number", NUMBERS)
def test_enabling_is_a_start_at_the_position_and_does_not_end_a_fault(
    number: ProgramNumber,
) -> None:
    program = controller_program(controller())
    new = machine_in(program, number)
    supervised = SupervisedProgram(program, new)
    supervised.start(5.0)
    for _ in range(30):
        supervised.step(20.0, 6.0, 0.0)
    supervised.command("disable", 6.0)
    assert [supervised.step(20.0, math.nan, math.nan) for _ in range(50)] == [0.0] * 50
    supervised.command("enable", 7.0)
    start_at(new, 7.0)
    assert supervised.step(20.0, 7.0, 0.0) == control_step(new, 20.0, 7.0, 0.0)
    supervised.command("fault", 7.0)
    for name in ("disable", "enable"):
        supervised.command(name, 7.0)
    assert supervised.in_fault
    assert supervised.step(20.0, 7.0, 0.0) == 0.0
    supervised.command("reset", math.nan)
    assert supervised.in_fault
    supervised.command("reset", 7.0)
    assert not supervised.in_fault


@pytest.mark.parametrize("number", NUMBERS)
def test_an_invalid_reference_does_not_matter_while_the_axis_holds(number: ProgramNumber) -> None:
    program = controller_program(controller())
    supervised = SupervisedProgram(program, machine_in(program, number))
    supervised.start(5.0)
    supervised.step(20.0, 5.0, 0.0)
    supervised.command("hold", 5.0)
    for _ in range(100):
        supervised.step(math.nan, 5.0, 0.0)
    assert not supervised.in_fault
    supervised.command("follow", 5.0)
    for _ in range(100):
        supervised.step(math.nan, 5.0, 0.0)
    assert supervised.in_fault


def test_a_command_after_the_end_is_refused() -> None:
    with pytest.raises(DocumentError, match=r"commands\[0\]\.at_s: found 5, after the end"):
        played((ControllerCommand("hold", 5.0),), SimulationRequest())


def test_a_command_that_does_not_exist_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError):
        msgspec.convert({"command": "jump", "at_s": 0.1}, ControllerCommand)
