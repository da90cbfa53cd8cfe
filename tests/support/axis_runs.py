"""Axes and controlled loops that tests of the engine move."""

from __future__ import annotations

import math

import msgspec
import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from frictool.engine.axis_motion import advance
from frictool.engine.status_codes import OK
from frictool.plant.axis import (
    DRIVE,
    GAP,
    POSITION,
    RESTED,
    VELOCITY,
    AxisParameters,
    rest,
)
from studies.rigs.example_controllers import BRAKE_LAW, clutch_controller, speed_controller
from tests.support.axis_reference import Motion

CLUTCH = AxisParameters(
    inertia=1.32e-5, viscous=3.8e-4, coulomb=0.099, breakaway=0.109, constant=0.0134, lag=3e-3,
    drive_limit=50.0,
    backlash=3.0, backlash_coulomb=0.05, backlash_breakaway=0.055,
)  # fmt: skip
BARE = AxisParameters(inertia=1.0, viscous=0.0, coulomb=1.0, breakaway=1.5)
COMMANDS = st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=12)
ENCODED = CLUTCH._replace(encoder_step=2 * math.pi / 56)
PERIOD = 1e-3
CONTROLLER = clutch_controller(
    BRAKE_LAW, speed=msgspec.structs.replace(speed_controller(), anti_windup=(0.0, 0.0))
)


def run(
    p: AxisParameters,
    commands: list[float],
    period: float = 1e-3,
    state: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    state = rest() if state is None else state
    array = p.as_array()
    for command in commands:
        assert advance(state, command, array, period) == OK
    return state


def as_motion(state: NDArray[np.float64]) -> Motion:
    return Motion(*(float(state[k]) for k in (POSITION, VELOCITY, DRIVE, GAP, RESTED)))
