"""The screw and nut of 2.1.6: reversible or not by mu against tan(alpha), and (2.15) in place of
(2.14)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
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
    assert ("is self-locking" in _note(found)) == holds
    # a load that friction holds is a part of it; one that it does not hold is told beside it
    assert (found.one.residual.stiffness == 0.0) == holds


@settings(max_examples=12, deadline=None)
@given(st.floats(0.05, 3.0), st.floats(0.02, 0.95))
@example(0.106, 0.05)
@example(1.7, 0.05)
def test_the_thesis_form_is_that_of_2_15_at_a_steady_speed(steep: float, share: float) -> None:
    """Also with a lead angle above 45 degrees, where r f - u tan(a) is negative."""
    mu = share * min(steep, 1.0 / steep)
    found = chain(screw(mu, lead=2.0 * math.pi * RADIUS * steep, form="thesis"), None).one
    x = found.positions
    force = STIFFNESS * RADIUS * steep * x
    up = found.residual.at(x) + found.forward.curve
    down = found.residual.at(x) - found.backward.curve
    # (2.15) at rest of accelerations: u = r tan(a) f ± mu |r f - u tan(a)|
    scale = np.max(np.abs(up))
    np.testing.assert_allclose(
        up,
        RADIUS * steep * force + mu * np.abs(RADIUS * force - up * steep),
        atol=1e-6 * scale,
    )
    np.testing.assert_allclose(
        down,
        RADIUS * steep * force - mu * np.abs(RADIUS * force - down * steep),
        atol=1e-6 * scale,
    )
    assert np.all(up >= down - 1e-9 * scale)  # friction takes power in both directions


@settings(max_examples=12, deadline=None)
@given(st.floats(0.05, 3.0), st.floats(0.02, 3.0), st.floats(1e-3, 0.1))
def test_the_losses_of_a_thread_follow_from_its_normal_force(
    steep: float, friction: float, radius: float
) -> None:
    """Balance the forces on the thread per unit of its normal force, at constant speed."""
    mu = min(friction, 0.95 / steep)
    sine, cosine = math.sin(math.atan(steep)), math.cos(math.atan(steep))
    # force along the screw, and force around it: the friction mu changes its sign with the motion
    raising, lowering = (((cosine - s * mu * sine), (sine + s * mu * cosine)) for s in (1.0, -1.0))
    found = chain(screw(mu, lead=2.0 * math.pi * radius * steep, radius=radius), None)
    losses = next(step.report for step in found.steps if step.report.step == "losses")
    efficiency, driven_back = (figure.value for figure in losses.figures[:2])
    # no length: of the load's effort in the motor's coordinate, r tan(a) f
    assert 1.0 / efficiency == pytest.approx(raising[1] / raising[0] / steep, rel=1e-9)
    assert driven_back == pytest.approx(lowering[1] / lowering[0] / steep, rel=1e-9, abs=1e-12)
    assert (driven_back < 0.0) == (mu > steep)


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
    assert "(friction_form: thesis) of thread" in told[1]
