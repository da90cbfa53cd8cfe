"""One axis with dry friction: its parameters and its state, as floats and as the flat arrays that
kernels take.

    command u --[limits]--> [1/(lag s + 1)] --drive i--> [constant K] --> effort e = K i - offset
    --> inertia J --> velocity v

    slipping   J v' = e - viscous v - coulomb sign(v)          (4.17), (4.43)
    at rest    v = 0 as long as |e| <= breakaway

Between motor and load there may be a backlash of full width rho, (4.45): the gap z = (position of
the motor - position of the load) stays in [-rho/2, rho/2]. At the edge z = sign(v) rho/2 the motor
carries the load along and the friction is the axis's. Elsewhere the load rests where it is, and
only `backlash_coulomb` opposes the motor (`backlash_breakaway` at rest). The load has no inertia of
its own (thesis 2.2.4): contact does not change the velocity. The offset belongs to the drive and
acts everywhere. What else friction may depend on, and where the travel ends:
plant/axis_friction_laws.py.

A winding limits a current beside the drive's own limit: what the supply leaves beside the
back-electromotive force has to drive it through the resistance, |resistance i + K v| <= supply. Its
inductance is left out, as electrical time constants are far below the current loop's: the current
is within the bound of the speed at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.plant.axis_friction_laws import PLAIN_SIZE, AxisFrictionLevels, AxisLaws

BACKLASH_BREAKAWAY_RATIO = (
    1.1  # beta of table 4.8: breakaway over Coulomb friction inside the backlash
)

# where each parameter lies in the kernels' array: the order of AxisParameters
INERTIA, VISCOUS, COULOMB, BREAKAWAY, OFFSET, CONSTANT = 0, 1, 2, 3, 4, 5
LAG, DRIVE_LIMIT, BACKLASH, BACKLASH_COULOMB, BACKLASH_BREAKAWAY, ENCODER_STEP = 6, 7, 8, 9, 10, 11
RESISTANCE, SUPPLY = 12, 13

# where each quantity lies in the kernels' state
POSITION, VELOCITY, DRIVE, GAP, LOAD_POSITION, MODE, RESTED = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
)  # RESTED: s at rest, kept while it slips
STATE_SIZE = 7

# MODE, for the reader of a state; kernels derive it anew from velocity, gap and effort
STUCK = 0.0  # at rest
SLIPPING = 1.0  # moving with the load; -1 in the negative direction
LOOSE = 2.0  # moving inside the backlash; -2 in the negative direction


class AxisParameters(NamedTuple):
    """SI floats, rotary | linear. A breakaway below its Coulomb friction is none: `checked` lifts
    it."""

    inertia: float  # kg m^2 | kg
    viscous: float  # N m s/rad | N s/m
    coulomb: float  # N m | N
    breakaway: float  # N m | N
    offset: float = 0.0  # N m | N, opposes a positive effort
    constant: float = 1.0  # N m/A | N/A, or per volt
    lag: float = 0.0  # s, time constant of the drive's own loop
    drive_limit: float = float("inf")  # A | V
    backlash: float = 0.0  # rad | m, full width
    backlash_coulomb: float = 0.0  # N m | N
    backlash_breakaway: float = 0.0  # N m | N
    encoder_step: float = 0.0  # rad | m; 0 is a perfect sensor
    resistance: float = 0.0  # ohm; 0: no winding, or one that limits nothing
    supply: float = float("inf")  # V
    laws: AxisLaws = AxisLaws()

    def checked(self) -> AxisParameters:
        """The same axis with each breakaway at least its Coulomb friction. Raises ValueError naming
        what is out of range."""
        for name, value in zip(self._fields, self.numbers, strict=False):
            if np.isnan(value) or (np.isinf(value) and name not in ("drive_limit", "supply")):
                raise ValueError(f"{name} is {value}; allowed: a finite number")
            if value < 0.0 and name != "offset":
                raise ValueError(f"{name} is {value:g}; allowed: >= 0")
        for name in ("inertia", "constant", "drive_limit", "supply"):
            if getattr(self, name) == 0.0:
                raise ValueError(f"{name} is 0; allowed: > 0")
        return self._replace(
            breakaway=max(self.breakaway, self.coulomb),
            backlash_breakaway=max(self.backlash_breakaway, self.backlash_coulomb),
        )

    def as_array(self) -> NDArray[np.float64]:
        """The kernels' parameter array, shape (14,), or (EXTENDED_SIZE,) with laws. Raises
        ValueError as `checked` and `Laws.pack` do."""
        axis = self.checked()
        return np.concatenate(
            [
                axis.numbers,
                self.laws.pack(AxisFrictionLevels(axis.viscous, axis.coulomb, axis.breakaway)),
            ]
        )

    @property
    def numbers(self) -> tuple[float, ...]:
        """The fields without the laws."""
        return self[:PLAIN_SIZE]  # type: ignore[return-value]  # the laws come after them


def rest(position: float = 0.0, drive: float = 0.0) -> NDArray[np.float64]:
    """The state at rest, shape (7,): the motor at `position` in the middle of its backlash, the
    load at the same place."""
    return np.array([position, 0.0, drive, 0.0, position, STUCK, 0.0])
