"""Run of an observer along a log, block by block.

After a gap, the observer forgets the position and the speed of the axis, and keeps its estimate of
the wear.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from frictool.adapters.observer_composition import observer_program
from frictool.control.compiled_program import compile_program, start_at
from frictool.control.program_replay import record_along
from frictool.documents.observer import Observer
from frictool.observe.motion_block import MotionBlock
from frictool.typing import Vector

MISS = "miss"  # name of the innovation beyond the dead zone in control/tracking_observer.py


@dataclass(frozen=True)
class ObserverOutput:
    """Estimates of an observer at the n samples of a block, each (n,).

    - time, position, velocity: time and estimated motion, s, rad | m, rad/s | m/s
    - friction: friction with the sign of the velocity, N m | N
    - wear: factor of the friction, or added friction [N m | N] for an additive observer; None if
      the observer does not estimate wear
    - miss: innovation (measured minus predicted position) of a tracking observer, reduced by its
      dead zone, rad | m; None for other observers
    """

    time: Vector
    position: Vector
    velocity: Vector
    friction: Vector
    wear: Vector | None
    miss: Vector | None = None


class ObserverRun:
    """Observer with its state, for a run along successive blocks of samples."""

    def __init__(self, observer: Observer) -> None:
        self.program, self.observer_nodes = observer_program(observer)
        self.machine = compile_program(self.program)
        self.inputs = np.array([self.program.inputs[name].index for name in ("position", "effort")])
        self.nodes = {
            name: node for name, node in self.observer_nodes._asdict().items() if node is not None
        }
        self.nodes |= {
            name: self.program.nodes[index]
            for index, name in self.program.names.items()
            if name == MISS
        }
        self.columns = sorted(self.nodes, key=lambda name: self.nodes[name].op != "state")
        indices = [self.nodes[name].index for name in self.columns]
        split = sum(node.op == "state" for node in self.nodes.values())
        self.states, self.others = (
            np.array(indices[:split], dtype=np.int64),
            np.array(indices[split:], dtype=np.int64),
        )
        self.is_begun = False

    def take(self, piece: MotionBlock) -> ObserverOutput:
        """Process a block, which must not be empty; return the estimates at its samples (n,).

        At the first block and after a gap, the observer starts at rest at the first position of the
        block.
        """
        if not (self.is_begun and piece.follows):
            self._start(float(piece.position[0]))
        measured = np.column_stack([piece.position, piece.effort])
        output = np.empty((piece.time.size, len(self.columns)))
        record_along(self.machine, self.inputs, measured, self.states, self.others, output)
        self.is_begun = True
        values = {name: output[:, column] for column, name in enumerate(self.columns)}
        return ObserverOutput(
            piece.time,
            values["position"],
            values["velocity"],
            values["friction"],
            values.get("wear"),
            values.get(MISS),
        )

    def _start(self, position: float) -> None:
        for state in self.program.states.values():
            if not (
                self.is_begun
                and self.observer_nodes.wear is not None
                and state.index == self.observer_nodes.wear.index
            ):
                self.machine.real[state.index] = state.value
        start_at(self.machine, position)


def run_along(observer: Observer, pieces: Iterable[MotionBlock]) -> Iterator[ObserverOutput]:
    """Run an observer along blocks; yield the output for each block that is not empty."""
    run = ObserverRun(observer)
    yield from (run.take(piece) for piece in pieces if piece.time.size)
