"""Supervision of a controller: commands to enable, hold or reset it, as in the exported C.

==========  =================================================  =====================================
command     effect from the next sample on                     ends with
==========  =================================================  =====================================
`disable`   the drive is 0, inputs are not read                `enable`: at rest at the measured
                                                               position, unless the fault is set
`hold`      the reference keeps its last valid value           `follow`
`fault`     the fault is set: the drive is 0                   `reset`
`reset`     at rest at the measured position, without          -
            fault, enabled, following the reference
==========  =================================================  =====================================

`enable` and `reset` at an invalid position set the fault, as `start` does. After `hold` the
reference is not used and may be invalid.
"""

from __future__ import annotations

from typing import Literal

from frictool.control.compiled_program import (
    LEFT,
    CompiledProgram,
    copy_program,
    put,
    read,
    start_at,
    step,
)
from frictool.control.measurement_guard import FAULT
from frictool.control.program import Program

CommandName = Literal["disable", "enable", "hold", "follow", "fault", "reset"]


class SupervisedProgram:
    """Controller program that accepts commands between samples.

    - program: program of the controller
    - new: the same program, compiled and not yet started
    """

    def __init__(self, program: Program, new: CompiledProgram) -> None:
        self._new = new
        self._held = program.states["reference_before"].index
        self.start(0.0)

    def start(self, position: float) -> None:
        """Start at rest at `position` [rad | m], enabled and following the reference."""
        self.machine = copy_program(self._new)
        self.disabled = self.holding = False
        start_at(self.machine, position)

    @property
    def in_fault(self) -> bool:
        """Return True if the controller is in the fault state, in which its drive is 0."""
        return read(self.machine, int(self.machine.ports[LEFT])) < 0.0

    def command(self, name: CommandName, position: float) -> None:
        """Execute a command; `enable` and `reset` use the measured `position` [rad | m]."""
        if name == "reset" or (name == "enable" and self.disabled and not self.in_fault):
            self.start(position)
        elif name == "fault":
            put(self.machine, int(self.machine.ports[LEFT]), FAULT)
        elif name in ("disable", "enable"):
            self.disabled = name == "disable"
        else:
            self.holding = name == "hold"

    def step(self, reference: float, position: float, velocity: float) -> float:
        """Run one sample and return the drive [A | V]."""
        if self.disabled:
            return 0.0
        if self.holding:
            reference = read(self.machine, self._held)
        return step(self.machine, reference, position, velocity)
