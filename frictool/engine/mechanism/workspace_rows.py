"""Rows of the work array `w`: one column per block, in row LAMBDA one column per joint.

=============  ======================================================  =======================
row            value                                                   filled by
=============  ======================================================  =======================
FORCE          sum of all known efforts on the block                   efforts.py
GROSS          sum of the magnitudes of these efforts, which is the    efforts.py
               scale of rounding errors
HOLD_LOW,      lowest (<= 0) and highest effort that the friction of   efforts.py
HOLD_HIGH      a block at rest can balance
DRIVEN         effort of the sources alone                             efforts.py
INERTIA        effective inertia of the block with its subtree         articulated_body.py
NEED,          lowest and highest force that block and subtree need    articulated_body.py,
NEED_HIGH      from the joint to the parent at acceleration 0          static_forces.py
ACCELERATION   acceleration of the block                               articulated_body.py
LAMBDA         force at the load end of the joint                      articulated_body.py
ALONG          speed of the block divided by the speed of the root     tree_solver.py
AHEAD,         friction at the start of a forward and of a backward    contact_resolution.py
BEHIND         slip, without joint losses
VALUE,         effort that the subtree needs at the root's             acceleration_graph.py,
SLOPE          acceleration x, and d(effort)/dx                        lossy_impulses.py
STOPPED_LOW,   1 if the block rests at its low or high end stop,       contact_resolution.py
STOPPED_HIGH   else 0
ON_BLOCK       effort on the block of a fixed-step law                 fixed_step_laws.py
=============  ======================================================  =======================

At the stages within a step, GROSS is not computed; the last values are used.
"""

from __future__ import annotations

FORCE, GROSS, HOLD_LOW, HOLD_HIGH, DRIVEN = range(5)
INERTIA, NEED, NEED_HIGH, ACCELERATION, LAMBDA = range(5, 10)
ALONG, AHEAD, BEHIND, VALUE, SLOPE, STOPPED_LOW, STOPPED_HIGH = range(10, 17)
ON_BLOCK = 17
WORK_ROWS = 18
