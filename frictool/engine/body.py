"""One mass on a support with friction: arrays of its parameters, states and events.

             ◀── friction
    effort u ──▶ [ m ] ──▶ v          lower stop │        x        │ upper stop

The friction law consists of a function `slip_force(v, direction, law)` and the breakaway force in
each direction. Above the speed `straight_from`, the friction is `direction * coulomb + viscous * v`
up to rounding, and the motion has a closed form. Below this speed, in the Stribeck layer, the
motion is integrated in steps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictool.friction.law_extension import DELAY, PackedExtension
from frictool.typing import Vector

# parameters; pairs are (backward, forward), at index base + (direction > 0)
MASS, BREAKAWAY, COULOMB, VISCOUS, VISCOUS_BEYOND = 0, 1, 3, 5, 7
LAYER, KNEE, LOWER_STOP, UPPER_STOP, RESTITUTION, SPEED_SCALE, TOLERANCE = 9, 10, 11, 12, 13, 14, 15
BODY_SIZE = 16

# state
POSITION, VELOCITY, INTEGRAL_STATE, DIRECTION, REGION = range(5)
STATE_SIZE = 5

# speed regions of a slip: Stribeck layer, straight line, straight line above the knee
IN_LAYER, STRAIGHT, BEYOND_KNEE = 0, 1, 2

# events, one row each: time, kind, position, velocity just before the event
(
    NO_EVENT,
    BREAKS_AWAY,
    SLIPS_BACK,
    STOPS,
    LEAVES_LAYER,
    ENTERS_LAYER,
    PASSES_KNEE,
    BOUNCES,
    RESTS_AT_STOP,
) = range(9)
EVENT_SIZE = 4

# samples, one row each
SAMPLE_POSITION, SAMPLE_VELOCITY, SAMPLE_EFFORT, SAMPLE_FRICTION, SAMPLE_MODE = range(5)
SAMPLE_SIZE = 5

TOLERANCE_DEFAULT = 1e-8


@dataclass(frozen=True)
class FrictionBody:
    """Mass [kg | kg m2] with friction, SI; forces in N for a linear axis, N m for a rotary one.

    - slip_force: kernel that maps (v, direction, law) to a force
    - law: parameters of this kernel
    - breakaway, coulomb, viscous: pairs (backward, forward), >= 0
    - viscous_beyond: viscous coefficients (backward, forward) above the speed `knee`, >= 0
    - stops: positions (low, high) of the end stops
    - tolerance: allowed error of the speed in an integration step, divided by the reference speed
      that `layer_piece` of motion_pieces.py defines
    """

    mass: float
    slip_force: Any
    law: Vector
    breakaway: tuple[float, float]
    coulomb: tuple[float, float]
    viscous: tuple[float, float] = (0.0, 0.0)
    straight_from: float = 0.0  # m/s, speed above which the force is linear in v; inf: never
    speed_scale: float = 1.0  # m/s
    # m/s, speed above which the viscous coefficient is `viscous_beyond`; at least straight_from
    knee: float = math.inf
    viscous_beyond: tuple[float, float] = (0.0, 0.0)
    stops: tuple[float, float] = (-math.inf, math.inf)  # m
    restitution: float = 0.0  # ratio of the speeds after and before an end stop
    tolerance: float = TOLERANCE_DEFAULT
    # friction/law_extension.py; such an extension defines the knees instead of `knee`
    extension: PackedExtension | None = None

    def law_in(self, direction: float) -> Vector:
        """Return the parameters of `slip_force` for a direction of slip."""
        if self.extension is None:
            return self.law
        return self.extension.forward if direction > 0.0 else self.extension.backward

    def as_array(self) -> Vector:
        """Return the parameters of the body (16,); raise ValueError if they are invalid."""
        array = np.empty(BODY_SIZE)
        array[MASS] = self.mass
        for base, pair in (
            (BREAKAWAY, self.breakaway),
            (COULOMB, self.coulomb),
            (VISCOUS, self.viscous),
            (VISCOUS_BEYOND, self.viscous_beyond),
        ):
            if not all(0.0 <= side < math.inf for side in pair):
                raise ValueError(f"friction: found {pair}; allowed: at least 0 in each direction")
            array[base : base + 2] = pair
        array[LAYER:KNEE] = self.straight_from
        array[KNEE:] = self.knee, *self.stops, self.restitution, self.speed_scale, self.tolerance
        self._check()
        return array

    def _check(self) -> None:
        if not 0.0 < self.mass < math.inf:
            raise ValueError(f"mass: found {self.mass}; allowed: above 0 and finite")
        if not 1e-14 <= self.tolerance <= 1e-2:
            raise ValueError(f"tolerance: found {self.tolerance}; allowed: 1e-14 to 1e-2")
        if not 0.0 <= self.restitution < 1.0:
            raise ValueError(
                f"restitution: found {self.restitution}; allowed: at least 0 and below 1"
            )
        if not self.stops[0] < self.stops[1]:
            raise ValueError(f"stops: found {self.stops}; allowed: (low, high) with low < high")
        if not (
            self.straight_from >= 0.0 and self.speed_scale > 0.0 and self.knee >= self.straight_from
        ):
            raise ValueError(
                f"found straight_from {self.straight_from}, speed_scale {self.speed_scale}, "
                f"knee {self.knee}; allowed: positive speeds, and knee >= straight_from"
            )
        if self.extension is not None and (
            self.knee < math.inf or self.extension.table[DELAY] > 0.0
        ):
            finding = "a pure delay of the film" if self.knee == math.inf else "a knee of the body"
            raise ValueError(
                f"extension: found {finding}; with an extension, the body must have no knee, and "
                "the film no pure delay"
            )
        for side, direction in enumerate((-1.0, 1.0)):
            start = direction * float(self.slip_force(0.0, direction, self.law_in(direction)))
            if not start <= self.breakaway[side] * (1.0 + 1e-12):
                raise ValueError(
                    f"breakaway: found {self.breakaway[side]}; allowed: at least {start}, the "
                    "friction at which slip in this direction begins"
                )


def at_rest(position: float = 0.0) -> Vector:
    """Return the state (5,) of a body at rest at `position` [m | rad]."""
    return np.array([position, 0.0, 0.0, 0.0, IN_LAYER])


def moving(position: float, velocity: float) -> Vector:
    """Return the state (5,) of a body that slips at `velocity` [m/s | rad/s]."""
    if velocity == 0.0:
        return at_rest(position)
    return np.array([position, velocity, 0.0, math.copysign(1.0, velocity), IN_LAYER])
