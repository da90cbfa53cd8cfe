"""A mechanism's text played with samples of its sources, by the engine alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.engine.mechanism.advance import TOLERANCE, advance
from frictool.engine.mechanism.machine import prepare
from frictool.engine.mechanism.state import rest
from frictool.engine.status import OK
from frictool.plant.mechanism.assembly import Assembled, assemble
from tests.mechanism.writing import mechanism

Vector = NDArray[np.float64]
HEAD = "format: mechanism/1\nname: test\n"


@dataclass(frozen=True)
class Played:
    """time (t,) [s], positions and speeds (t, n) of the blocks [rad | m]: at the beginning and after each sample."""

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
    """From rest at its start; `samples`: what each source is asked for, held for a period. The text may leave out its head."""
    assembled = assemble(mechanism(text if "format:" in text else HEAD + text))
    return moved(assembled, samples, period)


def moved(assembled: Assembled, samples: Sequence[Sequence[float]], period: float) -> Played:
    """The same of a mechanism that is put together."""
    machine = prepare(assembled.packed)
    state = rest(assembled.packed, machine, assembled.start)
    n = len(assembled.blocks)
    free, events, happened = np.zeros(n), np.zeros((0, 4)), np.zeros(1, np.int64)
    states = np.empty((len(samples) + 1, 2 * n))
    states[0] = state.y[: 2 * n]
    for index, sample in enumerate(samples, start=1):
        command = np.asarray(sample, dtype=np.float64)
        assert advance(*machine, *state, command, free, period, TOLERANCE, events, happened) == OK
        states[index] = state.y[: 2 * n]
    return Played(period * np.arange(len(samples) + 1), states[:, :n], states[:, n:], assembled.blocks)
