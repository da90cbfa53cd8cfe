"""Friction over a log: its interval contains what the model leaves open."""

from __future__ import annotations

from dataclasses import replace
from statistics import NormalDist

import msgspec
import numpy as np
import pytest

from frictool.documents.model import Model
from frictool.observe.friction_tracker import FrictionTracker, estimate_starts
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.observe.wear_estimate import UnmodelledFall
from frictool.typing import Matrix
from studies.rigs.clutch_fleet import clutch

SPEED = 50.0  # rad/s, below the knee of the friction
PERIOD = 1e-3  # s


def with_viscous(low: float, high: float) -> Model:
    """Return the clutch with a viscous friction that equals Coulomb friction at SPEED.

    The ends of its interval are relative to its value.
    """
    model = clutch()
    p = model.parameters
    value = p.coulomb.value / SPEED
    viscous = msgspec.structs.replace(p.viscous, value=value, low=low * value, high=high * value)
    return msgspec.structs.replace(model, parameters=msgspec.structs.replace(p, viscous=viscous))


def friction_in_slip(model: Model, fall: UnmodelledFall | None = None) -> Matrix:
    """Return value, low, high (3,) of the friction after a second at a constant speed, N m."""
    time = np.arange(1000) * PERIOD
    p = model.parameters
    effort = np.full(time.size, p.coulomb.value + SPEED * p.viscous.value)
    piece = MotionBlock(time, SPEED * time, effort, follows=False)
    velocity = np.full((3, time.size), SPEED)
    wear = replace(WearEstimator(model).estimate, fall=fall)
    known = estimate_starts(piece, wear, [])
    return FrictionTracker(model).take(piece, velocity, known)[:, -1]


def test_each_end_of_the_viscous_friction_moves_its_end_of_the_interval() -> None:
    """Half-widths of independent causes add as squares."""
    half = 0.5 * clutch().parameters.coulomb.value
    exact, slower, faster = (
        friction_in_slip(with_viscous(*ends)) for ends in ((1.0, 1.0), (0.5, 1.0), (1.0, 1.5))
    )
    value, low, high = exact
    assert slower == pytest.approx([value, value - np.hypot(value - low, half), high], rel=1e-6)
    assert faster == pytest.approx([value, low, value + np.hypot(high - value, half)], rel=1e-6)


def test_a_fall_that_the_model_lacks_is_part_of_the_friction() -> None:
    """At SPEED, one part has fallen to 1/e; the other part has vanished."""
    unit = clutch().parameters.coulomb.value
    fall = UnmodelledFall(
        (SPEED, 0.1 * SPEED), (0.3 * unit, 0.2 * unit), ((unit**2, 0.0), (0.0, unit**2))
    )
    value, low, high = friction_in_slip(clutch())
    half = NormalDist().inv_cdf(0.975) * unit * np.exp(-1.0)
    added = value + 0.3 * unit * np.exp(-1.0)
    assert friction_in_slip(clutch(), fall) == pytest.approx(
        [
            added,
            max(0.0, added - np.hypot(value - low, half)),
            added + np.hypot(high - value, half),
        ],
        rel=1e-6,
    )


@pytest.mark.parametrize("share", [-0.9, -0.5, 0.0, 0.5, 0.9])
def test_at_rest_friction_balances_the_effort(share: float) -> None:
    model = clutch()
    p = model.parameters
    held = share * p.coulomb.value
    time = np.arange(100) * PERIOD
    still = np.zeros(time.size)
    piece = MotionBlock(time, still, still + held + p.offset.value, follows=False)
    known = estimate_starts(piece, WearEstimator(model).estimate, [])
    value, low, high = FrictionTracker(model).take(piece, np.zeros((3, time.size)), known)[:, -1]
    assert [value, low, high] == pytest.approx([held] * 3, abs=1e-12)


def test_after_a_reversal_the_axis_is_in_its_backlash_for_the_width_of_it() -> None:
    model = clutch()
    width, loose = model.bench.mechanics.backlash, model.bench.mechanics.backlash_coulomb
    assert width is not None
    assert loose is not None
    step = 0.01 * width.value
    turn = int(2.0 * max(width.interval) / step)
    path = step * np.concatenate((np.arange(turn), turn - np.arange(turn)))
    time = np.arange(path.size) * PERIOD
    velocity = np.tile(np.where(np.arange(path.size) < turn, SPEED, -SPEED), (3, 1))
    piece = MotionBlock(time, path, np.zeros(path.size), follows=False)
    known = estimate_starts(piece, WearEstimator(model).estimate, [])
    friction = FrictionTracker(model).take(piece, velocity, known)[0]
    inside = np.isclose(np.abs(friction), loose.value)
    assert np.all(np.sign(friction) == np.sign(velocity[0]))
    assert inside[turn:].sum() * step == pytest.approx(width.value, abs=2.0 * step)
    assert not inside[-1]
    assert not inside[turn - 1]
