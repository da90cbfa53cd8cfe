"""Record of the estimates that every observer provides, alone or as part of a controller."""

from __future__ import annotations

from typing import NamedTuple

from frictool.control.program import ProgramNode


class ObserverNodes(NamedTuple):
    """Nodes of an observer's estimates at a sample; the drive of this sample is not used.

    - position: estimated position [rad | m]
    - velocity: estimated velocity [rad/s | m/s]
    - friction: dry friction with the sign of the velocity [N m | N]. This friction is 0 while the
      estimated mode is stuck, because the friction is then not observable.
    - wear: friction divided by the model's friction [1], or increase of friction [N m | N]; None if
      the observer does not estimate wear
    """

    position: ProgramNode
    velocity: ProgramNode
    friction: ProgramNode
    wear: ProgramNode | None
