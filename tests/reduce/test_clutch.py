"""The clutch of 2.2: from its parts to (2.29), by hand and by `reduce`."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.documents.mechanism import Cam, Mechanism, Rack, Spring
from frictool.documents.registry import load
from frictool.errors import NoSolutionError
from frictool.plant.mechanism.curves import PRODUCT_ERROR, monotone_cubic
from frictool.reduce.reduction_chain import chain
from frictool.reduce.residual_load import ResidualLoad
from frictool.reduce.resistance_step import in_contact, self_locking_margin
from frictool.reduce.travel_grid import positions

CLUTCH = Path(__file__).parents[2] / "configs" / "clutch" / "mechanism.yaml"


@pytest.fixture(scope="module")
def clutch() -> Mechanism:
    return load(CLUTCH, Mechanism)


def _cart_forces(clutch: Mechanism, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """F_s2 - F_s1 tan(alpha) and mu_c F_s1 over the cart's way (n,) [m], (2.16), (2.28)."""
    spring, cam = clutch.links["clutch"], clutch.links["compensation"]
    assert isinstance(spring, Spring)
    assert isinstance(cam, Cam)
    assert spring.force is not None
    share = 285.0 / 475.0
    disk = monotone_cubic(spring.force.position.values, spring.force.value.values)
    force = monotone_cubic(cam.force.position.values, cam.force.value.values)
    angle = monotone_cubic(cam.angle.position.values, cam.angle.value.values)
    pressed = force.value(x)
    return share * disk.value(share * x) - pressed * np.tan(
        angle.value(x)
    ), cam.friction_coefficient * pressed


def test_c_r_is_that_of_2_28_through_the_rack(clutch: Mechanism) -> None:
    rack = clutch.links["rack"]
    assert isinstance(rack, Rack)
    found = chain(clutch, None)
    theta = positions(found.last)
    load_, friction = _cart_forces(clutch, rack.radius.value * theta)
    drive, back = 1.0 / rack.efficiency, 2.0 - 1.0 / rack.efficiency
    forward, backward = load_ + friction, load_ - friction
    wanted_forward = 0.05 + rack.radius.value * np.where(
        forward > 0.0, forward * drive, forward * back
    )
    wanted_backward = -0.05 + rack.radius.value * np.where(
        backward < 0.0, backward * drive, backward * back
    )
    curve = in_contact(found.last, theta)
    # N, about the largest force tan(alpha), which the engine holds as cubics within PRODUCT_ERROR
    # of it
    pushed = 1000.0
    near = 2.0 * PRODUCT_ERROR * drive * rack.radius.value * pushed
    np.testing.assert_allclose(curve.forward, wanted_forward, atol=near, rtol=0.0)
    np.testing.assert_allclose(curve.backward, wanted_backward, atol=near, rtol=0.0)


def test_irreversible_by_2_27_as_the_friction_coefficient_says(clutch: Mechanism) -> None:
    """Without the brushes: (2.27) holds or fails with mu_c against |F_s2 - F_s1
    tan(alpha)|/F_s1."""
    cam = clutch.links["compensation"]
    assert isinstance(cam, Cam)
    x = np.linspace(cam.force.position.values[0], cam.force.position.values[-1], 400)
    load_, friction = _cart_forces(clutch, x)
    needed = float(np.max(np.abs(load_) * cam.friction_coefficient / friction))
    without = {name: one for name, one in clutch.links.items() if name != "brushes"}

    def pressed(share: float) -> Mechanism:
        changed = msgspec.structs.replace(cam, friction_coefficient=share * needed)
        return msgspec.structs.replace(clutch, links=without | {"compensation": changed})

    for share, holds in ((1.02, True), (0.98, False)):
        found = chain(pressed(share), None)
        x = positions(found.last)
        assert (self_locking_margin(x, in_contact(found.last, x)).margin > 0.0) == holds
        assert (
            found.one.residual == ResidualLoad()
        ) == holds  # beside friction, where that does not hold it
    with pytest.raises(NoSolutionError, match=r"at .* rad the load is .*, but friction holds"):
        chain(
            pressed(0.2), None
        )  # what a constant, a spring or a harmonic leaves is more than friction holds


def test_what_lies_behind_the_play_resists_where_it_is(clutch: Mechanism) -> None:
    """Pushed forward, the cart is half a play behind the rotor; backward, half a play ahead of
    it."""
    found = chain(clutch, None)
    one = found.one
    inner = (one.positions > 5.0) & (one.positions < 58.0)
    theta = one.positions[inner]
    np.testing.assert_allclose(
        one.forward.curve[inner], in_contact(found.last, theta - 1.5).forward, rtol=1e-9
    )
    np.testing.assert_allclose(
        one.backward.curve[inner], -in_contact(found.last, theta + 1.5).backward, rtol=1e-9
    )


def test_the_levels_are_those_identified_on_the_real_clutch(clutch: Mechanism) -> None:
    """Means over the cart's travel of C_r in slip: 0.12192 and 0.13553 N m (4.42), (4.44),
    configs/clutch/nonlinear.yaml."""
    found = chain(clutch, None)
    x = positions(found.last)
    curve = in_contact(found.last, x)
    assert float(np.trapezoid(curve.forward, x)) / 63.0 == pytest.approx(0.12192, rel=1e-3)
    assert float(np.trapezoid(-curve.backward, x)) / 63.0 == pytest.approx(0.13553, rel=1e-3)
    for side in (found.one.forward, found.one.backward):
        assert side.coulomb.error < 0.01 * float(np.mean(side.curve))
