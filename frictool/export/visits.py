"""The modes and limits of a program that golden vectors have to visit, by the names of its values."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.control.band import BRAKE, REST, RUN
from frictool.control.machine import Machine, read
from frictool.control.program import Program


@dataclass(frozen=True)
class Visit:
    """What is seen where the value at `place` is `value`, or is not it where `differs`, and where the condition at `where` holds.

    text: for people, behind a count of samples.
    """

    place: int
    value: float
    differs: bool
    text: str
    where: int | None = None

    def made(self, machine: Machine) -> bool:
        """At the machine's last sample."""
        if self.where is not None and read(machine, self.where) == 0.0:
            return False
        return bool((read(machine, self.place) == self.value) != self.differs)


def visits_of(program: Program) -> dict[str, Visit]:
    """Name -> what is to be seen, of those that the program has."""
    places = {name: index for index, name in reversed(program.names.items())}
    found = {}
    if "mode_now" in places:
        modes = {"run": (RUN, "in RUN"), "brake": (BRAKE, "in BRAKE"), "rest": (REST, "in REST")}
        for name, (value, text) in modes.items():
            if name != "brake" or "running" in places:  # a band that cuts never brakes
                found[name] = Visit(places["mode_now"], value, False, text)
    released = places.get("released_and_settled", places.get("released"))
    if released is not None:
        found["released"] = Visit(released, 1.0, False, "with the drive released")
    if "braking" in places:
        found["braking"] = Visit(places["braking"], 0.0, True, "with virtual friction", released)
    if "held" in places:
        found["held"] = Visit(places["held"], 1.0, False, "with the integrator held")
    if program.guard is not None:
        guard = program.guard
        found["invalid"] = Visit(guard.left_now.index, guard.hold.value, True, "with an input held or in the fault")
        found["fault"] = Visit(guard.fault.index, 1.0, False, "in the fault")
    found["limited"] = Visit(places["met"], 0.0, True, "with the drive limited")
    if "drive_high" in places:
        limit = program.nodes[places["drive_limit"]].value
        found["voltage"] = Visit(places["drive_high"], limit, True, "with less current than the limit, by the voltage")
    return found
