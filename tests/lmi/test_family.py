"""The mixed-sensitivity family against SLICOT's Riccati equations; all orders are in `make
accept`."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.lmi.hinf_synthesis import controller, minimise
from frictool.plant.lti import gain
from frictool.verify.hinf_norm import norm
from studies.references.slicot import AVAILABLE, MISSING, slicot
from studies.rigs.mixed_sensitivity import COMMAND, ERROR_HIGH, ORDERS, mixed_sensitivity

TIMEOUT = 60.0  # s


@pytest.mark.skipif(not AVAILABLE, reason=MISSING)
@pytest.mark.parametrize("order", [4, 8])
def test_gamma_is_that_of_slicot(order: int) -> None:
    plant = mixed_sensitivity(order)
    theirs, ours = slicot(plant, TIMEOUT), minimise([plant], 1.02)
    assert theirs.gamma is not None, theirs.reason
    assert ours.optimum == pytest.approx(theirs.gamma, rel=0.01)
    assert norm(plant.closed(controller(plant, ours)))[0] <= ours.gamma


@pytest.mark.parametrize("order", ORDERS)
def test_the_family_is_what_its_module_says(order: int) -> None:
    plant = mixed_sensitivity(order)
    assert len(plant.a) == order
    assert np.max(np.linalg.eigvals(plant.a).real) < 0.0
    open_loop = plant.closed(gain(0.0, 0.0))
    reference, load = open_loop.response([1e4])[0].T
    np.testing.assert_allclose(
        np.abs(reference), [ERROR_HIGH, 0.0], atol=1e-3
    )  # far above every mode e = r
    np.testing.assert_allclose(np.abs(load), 0.0, atol=1e-3)
    assert plant.d12[1, 0] == COMMAND
    again = mixed_sensitivity(order)
    assert plant.a.tobytes() == again.a.tobytes()
