"""A mechanism's text played with samples of its sources, by the engine alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from frictool.adapters.mechanism.assembly import assemble
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import rest
from frictool.engine.status_codes import OK
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.typing import Vector
from tests.support.mechanism_text import mechanism

HEAD = "format: mechanism/1\nname: test\n"


@dataclass(frozen=True)
class Played:
    """time (t,) [s], positions and speeds (t, n) of the blocks [rad | m]: at the beginning and
    after each sample."""

    time: Vector
    positions: Vector
    speeds: Vector
    blocks: tuple[str, ...]

    def position(self, block: str) -> Vector:
        """(t,)"""
        return self.positions[:, self.blocks.index(block)]

    def speed(self, block: str) -> Vector:
        """(t,)"""
        return self.speeds[:, self.blocks.index(block)]


def play(text: str, samples: Sequence[Sequence[float]], period: float = 1e-3) -> Played:
    """From rest at its start; `samples`: what each source is asked for, held for a period. The text
    may leave out its head."""
    assembled = assemble(mechanism(text if "format:" in text else HEAD + text))
    return moved(assembled, samples, period)


def moved(
    assembled: AssembledMechanism, samples: Sequence[Sequence[float]], period: float
) -> Played:
    """The same of a mechanism that is put together."""
    machine = prepare(assembled.packed)
    found = run(
        machine,
        rest(assembled.packed, machine, assembled.start),
        samples,
        period,
        most_events=1,
    )
    assert found.status == OK
    return Played(found.times, found.positions.T, found.speeds.T, assembled.blocks)
