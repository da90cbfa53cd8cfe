"""An observer along a log: pieces of position and effort in, what it finds at every sample out;
nothing holds the log.

    Piece, Piece, ... ──record_along──▶ Found, Found, ...

It is the program that runs in the simulation and as exported C. Over a gap the observer forgets
where the axis was and how fast it moved, and not what it has learned of the wear.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictool.control.compiled_program import compile_program, start_at
from frictool.control.observer_composition import observer_program
from frictool.control.program_recording import record_along
from frictool.documents.observer import Observer
from frictool.observe.motion_block import MotionBlock

Vector = NDArray[np.float64]
MISS = "miss"  # of control/tracking_observer.py


@dataclass(frozen=True)
class ObserverOutput:
    """What an observer finds along a piece, all (n,): time [s], position [rad | m], velocity [per
    s], friction [N m | N], of the velocity's sign; wear [1], or [N m | N] of an additive observer,
    None where it knows of none; miss: of a tracking observer, measured less predicted position
    beyond its dead zone [rad | m]."""

    time: Vector
    position: Vector
    velocity: Vector
    friction: Vector
    wear: Vector | None
    miss: Vector | None = None


class ObserverRun:
    """One observer, from piece to piece."""

    def __init__(self, observer: Observer) -> None:
        self.program, self.found = observer_program(observer)
        self.machine = compile_program(self.program)
        self.inputs = np.array([self.program.inputs[name].index for name in ("position", "effort")])
        self.nodes = {name: node for name, node in self.found._asdict().items() if node is not None}
        self.nodes |= {
            name: self.program.nodes[index]
            for index, name in self.program.names.items()
            if name == MISS
        }
        self.columns = sorted(self.nodes, key=lambda name: self.nodes[name].op != "state")
        places = [self.nodes[name].index for name in self.columns]
        split = sum(node.op == "state" for node in self.nodes.values())
        self.states, self.others = (
            np.array(places[:split], dtype=np.int64),
            np.array(places[split:], dtype=np.int64),
        )
        self.is_begun = False

    def take(self, piece: MotionBlock) -> ObserverOutput:
        """The samples of a piece (n,), which is at least one."""
        if not (self.is_begun and piece.follows):
            self._start(float(piece.position[0]))
        given = np.column_stack([piece.position, piece.effort])
        found = np.empty((piece.time.size, len(self.columns)))
        record_along(self.machine, self.inputs, given, self.states, self.others, found)
        self.is_begun = True
        values = {name: found[:, column] for column, name in enumerate(self.columns)}
        return ObserverOutput(
            piece.time,
            values["position"],
            values["velocity"],
            values["friction"],
            values.get("wear"),
            values.get(MISS),
        )

    def _start(self, position: float) -> None:
        """At rest at `position`; what was learned of the wear stays."""
        for state in self.program.states.values():
            if not (
                self.is_begun
                and self.found.wear is not None
                and state.index == self.found.wear.index
            ):
                self.machine.real[state.index] = state.value
        start_at(self.machine, position)


def run_along(observer: Observer, pieces: Iterable[MotionBlock]) -> Iterator[ObserverOutput]:
    """What the observer finds along each piece that holds a sample."""
    run = ObserverRun(observer)
    yield from (run.take(piece) for piece in pieces if piece.time.size)
