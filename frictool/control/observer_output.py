"""What an observer finds at a sample: the result of every observer's block, which both the
stand-alone program and the loop read."""

from __future__ import annotations

from typing import NamedTuple

from frictool.control.program import ProgramNode


class ObserverNodes(NamedTuple):
    """Values at this sample, from what was measured before it.

    position [rad | m], velocity [per s]. friction [N m | N]: the dry friction, of the velocity's
    sign, which it opposes; 0 where the observer takes the axis for stuck, and nothing is observed
    of it. wear: friction over the model's [1], or what it has grown by [N m | N]; None where an
    observer knows of none.
    """

    position: ProgramNode
    velocity: ProgramNode
    friction: ProgramNode
    wear: ProgramNode | None
