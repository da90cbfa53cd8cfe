"""The screw and nut of 2.1.6: reversible or not by mu against tan(alpha), and (2.15) in place of
(2.14)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.reduce.reduction_chain import ReductionChain, chain
from tests.support.small_mechanisms import screw

RADIUS, LEAD, STIFFNESS = 6e-3, 4e-3, 2e4
STEEP = LEAD / (2.0 * math.pi * RADIUS)


def _note(found: ReductionChain) -> str:
    return next(step.report.notes[0] for step in found.steps if step.report.step == "losses")


@settings(max_examples=12, deadline=None)
@given(st.floats(0.02, 0.4))
def test_the_resisting_torque_is_that_of_the_thread(mu: float) -> None:
    found = chain(screw(mu), None).one
    x = found.positions
    force = STIFFNESS * RADIUS * STEEP * x
    alpha, phi = math.atan(STEEP), math.atan(mu)
    load = found.residual.at(x)
    np.testing.assert_allclose(
        load + found.forward.curve, RADIUS * math.tan(alpha + phi) * force, rtol=1e-6, atol=1e-9
    )
    np.testing.assert_allclose(
        load - found.backward.curve, RADIUS * math.tan(alpha - phi) * force, rtol=1e-6, atol=1e-9
    )


@pytest.mark.parametrize(("mu", "holds"), [(0.99 * STEEP, False), (1.01 * STEEP, True)])
def test_irreversible_from_mu_above_tan_alpha_on(mu: float, holds: bool) -> None:
    found = chain(screw(mu), None)
    assert ("is irreversible" in _note(found)) == holds
    # a load that friction holds is a part of it; one that it does not hold is told beside it
    assert (found.one.residual.stiffness == 0.0) == holds


def test_the_thesis_form_is_that_of_2_15_at_a_steady_speed() -> None:
    mu = 0.05
    found = chain(screw(mu, form="thesis"), None).one
    x = found.positions
    force = STIFFNESS * RADIUS * STEEP * x
    up = found.residual.at(x) + found.forward.curve
    down = found.residual.at(x) - found.backward.curve
    # (2.15) at rest of accelerations: u = r tan(a) f ± mu |r f - u tan(a)|
    np.testing.assert_allclose(
        up, RADIUS * STEEP * force + mu * np.abs(RADIUS * force - up * STEEP), atol=1e-9
    )
    np.testing.assert_allclose(
        down, RADIUS * STEEP * force - mu * np.abs(RADIUS * force - down * STEEP), atol=1e-9
    )


def test_an_efficiency_alone_is_nowhere_left() -> None:
    found = chain(screw(0.5 * STEEP), None)
    assert "would oscillate" in _note(found)
    assert all(
        "efficiency" not in str(link) or getattr(link, "efficiency", 1.0) == 1.0
        for link in found.last.links.values()
    )
    assert np.max(found.one.forward.curve) > 0.0
    assert np.max(found.one.backward.curve) > 0.0


def test_a_thread_in_the_thesis_form_tells_that_it_is_taken_at_a_steady_speed() -> None:
    told = [
        chain(screw(0.05, form=form), None).steps[0].report.neglects for form in ("angle", "thesis")
    ]
    assert told[0] == "nothing"
    assert "friction_form: thesis of thread" in told[1]
