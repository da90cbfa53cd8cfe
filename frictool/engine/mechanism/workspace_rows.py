"""Rows of the work array `w`; a column belongs to a block, in row LAMBDA to a joint.

GROSS is the sum of the magnitudes of the efforts on a block, the scale of rounding errors. It is
computed only if `whole` is True; the stages within a step use the last values.
"""

from __future__ import annotations

FORCE, GROSS, HOLD_LOW, HOLD_HIGH, DRIVEN = range(5)  # engine/mechanism/efforts.py
# articulated_body.py; LAMBDA of joints
INERTIA, NEED, NEED_HIGH, ACCELERATION, LAMBDA = range(5, 10)
# contact_resolution.py, tree_solver.py, lossy_impulses.py
ALONG, AHEAD, BEHIND, VALUE, SLOPE, STOPPED_LOW, STOPPED_HIGH = range(10, 17)
ON_BLOCK = 17  # fixed_step_laws.py: effort u on the block of a law
WORK_ROWS = 18
