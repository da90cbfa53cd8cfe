"""The rows of the work array `w`, a column for each block, or for each joint where that is said.

All but GROSS hold what the last kernel that fills them found. GROSS is the size of what meets in a
block, which rounding is relative to: it is that of the last whole evaluation, and stages within a
step go by it.
"""

from __future__ import annotations

FORCE, GROSS, HOLD_LOW, HOLD_HIGH, DRIVEN = range(5)  # engine/mechanism/efforts.py
INERTIA, NEED, NEED_HIGH, ACCELERATION, LAMBDA = range(
    5, 10
)  # articulated_body.py; LAMBDA of joints
ALONG, AHEAD, BEHIND, VALUE, SLOPE, STOPPED_LOW, STOPPED_HIGH = range(
    10, 17
)  # contact_resolution.py, tree.py, lossy_impulses.py
ON_BLOCK = 17  # fixed_step_laws.py: the effort that the law on a block sees
LEAST, REST, GIVEN, HELD = range(11, 15)  # forces.py, where nothing is resolved
WORK_ROWS = 18
