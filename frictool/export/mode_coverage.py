"""Conditions that golden vectors must meet: a visit to every mode and limit of a program."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.control.compiled_program import CompiledProgram, read
from frictool.control.program import Program
from frictool.control.target_band import BRAKE, REST, RUN


@dataclass(frozen=True)
class VisitCondition:
    """Condition on the values of a program after a sample.

    - index: number of the node of the program that the condition concerns
    - value: value that the node must have or, if `differs` is True, must not have
    - where: number of a second node, which must differ from 0; None without a second node
    - text: description of the condition
    """

    index: int
    value: float
    differs: bool
    text: str
    where: int | None = None

    def made(self, machine: CompiledProgram) -> bool:
        """Return True if the condition holds after the program's last sample."""
        if self.where is not None and read(machine, self.where) == 0.0:
            return False
        return bool((read(machine, self.index) == self.value) != self.differs)


def visit_conditions(program: Program) -> dict[str, VisitCondition]:
    """Return the conditions of the modes and limits that the program has, by name."""
    indices = {name: index for index, name in reversed(program.names.items())}
    conditions = {}
    if "mode_now" in indices:
        modes = {"run": (RUN, "in RUN"), "brake": (BRAKE, "in BRAKE"), "rest": (REST, "in REST")}
        for name, (value, text) in modes.items():
            if name != "brake" or "running" in indices:  # a band with action `cut` never brakes
                conditions[name] = VisitCondition(indices["mode_now"], value, False, text)
    released = indices.get("released_and_settled", indices.get("released"))
    if released is not None:
        conditions["released"] = VisitCondition(released, 1.0, False, "with the drive released")
    if "braking" in indices:
        conditions["braking"] = VisitCondition(
            indices["braking"], 0.0, True, "with virtual friction", released
        )
    if "friction_direction_now" in indices:
        direction_index = indices["friction_direction_now"]
        for name, direction in (("forward", 1.0), ("backward", -1.0)):
            text = f"with the feedforward's Coulomb friction for {name} motion"
            conditions[name] = VisitCondition(direction_index, direction, False, text)
    if "held" in indices:
        conditions["held"] = VisitCondition(indices["held"], 1.0, False, "with the integrator held")
    if program.guard is not None:
        guard = program.guard
        conditions["invalid"] = VisitCondition(
            guard.left_now.index,
            guard.hold.value,
            True,
            "with an invalid input, or in the fault state",
        )
        conditions["fault"] = VisitCondition(guard.fault.index, 1.0, False, "in the fault state")
    conditions["limited"] = VisitCondition(indices["met"], 0.0, True, "with the drive limited")
    if "drive_high" in indices:
        limit = program.nodes[indices["drive_limit"]].value
        conditions["voltage"] = VisitCondition(
            indices["drive_high"], limit, True, "with the current limited by the voltage"
        )
    return conditions
