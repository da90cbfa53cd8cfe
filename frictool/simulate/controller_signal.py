"""Internal signal of a controller at each sample, from a repeated run of its program.

The simulation does not record internal signals. A repeated run with the same number format,
references and positions has bit by bit the signals of the simulation, even if the simulation used
exported code.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from frictool.control.compiled_program import CompiledProgram, copy_program, hold, read, start_at
from frictool.control.machine_code import machine_code, started_values
from frictool.control.program import Program, ProgramNode
from frictool.control.program_replay import value_along
from frictool.control.supervision import CommandName, SupervisedProgram
from frictool.engine.closed_loop import MEASURED, TRUE_POSITION, TRUE_VELOCITY, measure
from frictool.engine.coded_loop import replay_coded
from frictool.typing import Vector


class RecordedRun(NamedTuple):
    """Inputs of a controller in a simulated run, with which its program can be run again.

    - running: program in the number format of the run
    - reference: reference (n,) [rad | m]
    - record: (n, 7), columns of engine/closed_loop.py
    - step: encoder step [rad | m]
    - known: value of each scheduled parameter, by the index of its node in the program
    - commands: commands of a supervisor just before a sample, by the index of the sample
    """

    program: Program
    running: CompiledProgram
    reference: Vector
    record: Vector
    step: float
    known: Mapping[int, float]
    commands: Mapping[int, Sequence[CommandName]]

    @property
    def started_at(self) -> float:
        """Return the position [rad | m] at which the controller started."""
        return float(measure(float(self.record[0, TRUE_POSITION]), self.step))


def controller_signal(run: RecordedRun, node: ProgramNode) -> Vector:
    """Return the value [SI] (n,) of a node of the controller's program at each sample.

    If the node is a state, its value at a sample is the value before the update at this sample.
    """
    values = np.empty(run.reference.size)
    if not run.reference.size:
        return values
    again = run.running._replace(real=run.running.real.copy(), single=run.running.single.copy())
    for parameter, value in run.known.items():
        hold(again, parameter, value)
    position, velocity = (
        np.ascontiguousarray(run.record[:, column]) for column in (MEASURED, TRUE_VELOCITY)
    )
    code = None if run.commands else machine_code(again, node.index)
    if code is not None:
        memory = started_values(again, run.started_at)
        replay_coded(memory, code.address, run.reference, position, velocity, values)
        return values
    again = copy_program(again)
    first = read(_started(again, run.started_at), node.index)
    if run.commands:
        for k, supervised in _supervised(run, again):
            values[k] = read(supervised.machine, node.index)
    else:
        value_along(again, node.index, run.reference, position, velocity, values)
    if node.op == "state":
        values[1:] = values[:-1].copy()
        values[0] = first
    return values


def fault_signal(run: RecordedRun) -> Vector:
    """Return an array (n,): 1 while the controller is in its fault state, else 0."""
    values = np.zeros(run.reference.size)
    for k, supervised in _supervised(run, copy_program(run.running)):
        values[k] = supervised.in_fault
    return values


def _started(machine: CompiledProgram, position: float) -> CompiledProgram:
    start_at(machine, position)
    return machine


def _supervised(run: RecordedRun, new: CompiledProgram) -> Iterator[tuple[int, SupervisedProgram]]:
    supervised = SupervisedProgram(run.program, new)
    supervised.start(run.started_at)
    for k in range(run.reference.size):
        measured = float(run.record[k, MEASURED])
        for name in run.commands.get(k, ()):
            supervised.command(name, measured)
        supervised.step(run.reference[k], measured, float(run.record[k, TRUE_VELOCITY]))
        yield k, supervised
