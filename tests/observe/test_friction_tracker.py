"""Friction over a log: its interval contains what the model leaves open."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.model import Model
from frictool.observe.friction_tracker import FrictionTracker, estimate_starts
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.typing import Matrix
from studies.rigs.clutch_fleet import clutch

SPEED = 2000.0  # rad/s
PERIOD = 1e-3  # s


def with_viscous(low: float, high: float) -> Model:
    """Return the clutch with these ends of the viscous friction, relative to its value."""
    model = clutch()
    viscous = model.parameters.viscous
    ranged = msgspec.structs.replace(viscous, low=low * viscous.value, high=high * viscous.value)
    return msgspec.structs.replace(
        model, parameters=msgspec.structs.replace(model.parameters, viscous=ranged)
    )


def friction_in_slip(model: Model) -> Matrix:
    """Return value, low, high (3,) of the friction after a second at a constant speed, N m."""
    time = np.arange(1000) * PERIOD
    p = model.parameters
    effort = np.full(time.size, p.coulomb.value + SPEED * p.viscous.value)
    piece = MotionBlock(time, SPEED * time, effort, follows=False)
    velocity = np.full((3, time.size), SPEED)
    wear = WearEstimator(model)
    known = estimate_starts(piece, wear.estimate, [])
    return FrictionTracker(model).take(piece, velocity, known)[:, -1]


def test_each_end_of_the_viscous_friction_moves_its_end_of_the_interval() -> None:
    viscous = SPEED * clutch().parameters.viscous.value
    exact, slower, faster = (
        friction_in_slip(with_viscous(*ends)) for ends in ((1.0, 1.0), (0.5, 1.0), (1.0, 1.5))
    )
    assert slower[1] == pytest.approx(exact[1] - 0.5 * viscous, rel=0.05)
    assert slower[2] == pytest.approx(exact[2], rel=0.02)
    assert faster[2] == pytest.approx(exact[2] + 0.5 * viscous, rel=0.05)
