"""One axis with dry friction: parameters and state, as floats and as flat arrays for kernels.

    command u --[limits]--> [1/(lag s + 1)] --drive i--> [constant K]
    --> effort e = K i - offset --> inertia J --> velocity v

    slipping   J v' = e - viscous v - coulomb sign(v)          (4.17), (4.43)
    at rest    v = 0 as long as |e| <= breakaway

Between motor and load there may be a backlash of full width rho, (4.45). The position difference z
= (motor position - load position) stays in [-rho/2, rho/2]. If z = sign(v) rho/2, the backlash is
closed, the motor carries the load, and the friction of the axis acts. Otherwise the load stays at
rest, and only `backlash_coulomb` opposes the motor (`backlash_breakaway` if the motor is at rest).
The load has no separate inertia (thesis 2.2.4): a contact does not change the velocity. The offset
belongs to the drive and always acts. plant/axis_friction_laws.py makes the friction depend on
direction, speed, position and time at rest, and adds end stops.

A winding limits the current in addition to the drive limit: |resistance i + K v| <= supply, since
the supply must overcome the back-EMF and the resistance. The inductance is neglected, because the
electrical time constant is much shorter than the time constant of the current loop.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictool.plant.axis_friction_laws import PLAIN_SIZE, AxisFrictionLevels, AxisLaws

# beta of table 4.8: breakaway divided by Coulomb friction inside the backlash
BACKLASH_BREAKAWAY_RATIO = 1.1

# indices of the parameters in the kernels' array: the order of AxisParameters
INERTIA, VISCOUS, COULOMB, BREAKAWAY, OFFSET, CONSTANT = 0, 1, 2, 3, 4, 5
LAG, DRIVE_LIMIT, BACKLASH, BACKLASH_COULOMB, BACKLASH_BREAKAWAY, ENCODER_STEP = 6, 7, 8, 9, 10, 11
RESISTANCE, SUPPLY = 12, 13

# indices in the kernels' state
# RESTED: time at rest [s], kept while the axis slips
POSITION, VELOCITY, DRIVE, GAP, LOAD_POSITION, MODE, RESTED = range(7)
STATE_SIZE = 7

# values of MODE, for readers of a state; kernels derive it from velocity, gap and effort
STUCK = 0.0  # at rest
SLIPPING = 1.0  # moving with the load; -1 in the negative direction
LOOSE = 2.0  # moving inside the backlash; -2 in the negative direction


class AxisParameters(NamedTuple):
    """Parameters of an axis, in SI units of a rotary | linear axis.

    - breakaway, backlash_breakaway: static friction; `checked` raises it to `coulomb` or
      `backlash_coulomb` if it is smaller
    - offset: constant effort that opposes a positive drive
    - constant: effort per A or V
    - lag: time constant of the drive, s
    - backlash: full width of the backlash
    - encoder_step: 0 for a sensor without quantisation
    - resistance: 0 if the limit of the winding is neglected
    """

    inertia: float  # kg m^2 | kg
    viscous: float  # N m s/rad | N s/m
    coulomb: float  # N m | N
    breakaway: float  # N m | N
    offset: float = 0.0  # N m | N
    constant: float = 1.0  # N m/A | N/A, or per volt
    lag: float = 0.0
    drive_limit: float = float("inf")  # A | V
    backlash: float = 0.0  # rad | m
    backlash_coulomb: float = 0.0  # N m | N
    backlash_breakaway: float = 0.0  # N m | N
    encoder_step: float = 0.0  # rad | m
    resistance: float = 0.0  # ohm
    supply: float = float("inf")  # V
    laws: AxisLaws = AxisLaws()

    def checked(self) -> AxisParameters:
        """Return the axis, with a breakaway of at least the Coulomb friction.

        Raises ValueError with the name of a parameter that is out of range.
        """
        return _checked(self)

    def _raise_if_impossible(self) -> None:
        for name, value in zip(self._fields, self.numbers, strict=False):
            if math.isnan(value) or (math.isinf(value) and name not in ("drive_limit", "supply")):
                raise ValueError(f"{name} is {value}; allowed: a finite number")
            if value < 0.0 and name != "offset":
                raise ValueError(f"{name} is {value:g}; allowed: >= 0")
        for name in ("inertia", "constant", "drive_limit", "supply"):
            if getattr(self, name) == 0.0:
                raise ValueError(f"{name} is 0; allowed: > 0")

    def as_array(self) -> NDArray[np.float64]:
        """Return the parameters for kernels, (14,), or (EXTENDED_SIZE,) if `laws` has an effect.

        Raises ValueError as `checked` and `AxisLaws.pack` do.
        """
        return _packed(self).copy()

    @property
    def numbers(self) -> tuple[float, ...]:
        """Return the values of all fields except `laws`, in order."""
        return self[:PLAIN_SIZE]  # type: ignore[return-value]  # the laws are the last field


# cached, because an axis is checked and packed when it is made, and again for each simulation
@lru_cache(maxsize=1)
def _checked(parameters: AxisParameters) -> AxisParameters:
    parameters._raise_if_impossible()
    return parameters._replace(
        breakaway=max(parameters.breakaway, parameters.coulomb),
        backlash_breakaway=max(parameters.backlash_breakaway, parameters.backlash_coulomb),
    )


@lru_cache(maxsize=1)
def _packed(parameters: AxisParameters) -> NDArray[np.float64]:
    axis = parameters.checked()
    levels = AxisFrictionLevels(axis.viscous, axis.coulomb, axis.breakaway)
    return np.concatenate([axis.numbers, axis.laws.pack(levels)])


def rest(position: float = 0.0, drive: float = 0.0) -> NDArray[np.float64]:
    """Return the state (7,) of an axis at rest at `position` [rad | m] with `drive` [A | V].

    The motor is in the middle of the backlash.
    """
    return np.array([position, 0.0, drive, 0.0, position, STUCK, 0.0])
