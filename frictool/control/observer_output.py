"""Estimates of an observer at a sample, common to all observers.

The stand-alone program and the controller read the same record.
"""

from __future__ import annotations

from typing import NamedTuple

from frictool.control.program import ProgramNode


class ObserverNodes(NamedTuple):
    """Estimates at this sample, before its effort is known.

    position [rad | m], velocity [per s]. friction [N m | N]: dry friction with the sign of the
    velocity, which it opposes; 0 while the observer takes the axis for stuck, since friction is
    then not observed. wear: ratio of friction to the model's [1], or increase of friction
    [N m | N]; None if the observer does not estimate wear.
    """

    position: ProgramNode
    velocity: ProgramNode
    friction: ProgramNode
    wear: ProgramNode | None
