"""A belt between two pulleys (2.6)-(2.9): its resonance by hand, kept below the bandwidth and
dropped above it."""

from __future__ import annotations

import numpy as np
import pytest

from frictool.adapters.resonance_filter import resonance_filters
from frictool.documents.resonances import Oscillation, Resonances
from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.mechanism.linearisation import linearise
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.reduction_chain import ReductionChain, chain
from frictool.reduce.step_report import StepReport
from tests.support.small_mechanisms import belt

STIFFNESS, DAMPING, NEAR, FAR = 2e5, 20.0, 2e-4, 6e-4 * 0.5**2  # inertias at the motor
AT_MOTOR = 0.02**2  # of the belt's stiffness and damping
RESONANCE = np.sqrt(STIFFNESS * AT_MOTOR * (1.0 / NEAR + 1.0 / FAR))


def _told(found: ReductionChain) -> StepReport:
    return next(step.report for step in found.steps if step.report.step == "compliance")


def test_above_the_bandwidth_the_belt_is_rigid_and_the_error_that_of_the_two_inertias() -> None:
    found = chain(belt(), 100.0)
    figures = {figure.name: figure.value for figure in _told(found).figures}
    assert figures["belt: resonance"] == pytest.approx(RESONANCE, rel=1e-6)
    assert figures["belt: compliance"] == pytest.approx(1.0 / (STIFFNESS * AT_MOTOR), rel=1e-12)
    w = 1j * 100.0
    k, d = STIFFNESS * AT_MOTOR, DAMPING * AT_MOTOR
    yielding = (d * w + k) / (w**2 * (NEAR * FAR * w**2 + (NEAR + FAR) * (d * w + k)))
    rigid = 1.0 / ((NEAR + FAR) * w**2)
    assert _told(found).predicted == pytest.approx(abs(abs(rigid / yielding) - 1.0), rel=1e-6)
    assert found.kept == ()
    assert found.one.resonances is None
    assert found.one.inertia == pytest.approx(
        (NEAR + FAR) / 0.5**2, rel=1e-12
    )  # at the encoder's pulley


def test_below_it_is_kept_as_a_pair_of_poles_and_a_zero() -> None:
    found = chain(belt(), 2000.0)
    assert found.kept == ("belt",)
    assert len(found.last.blocks) == 2
    kept = found.one.resonances
    assert kept is not None
    (pole,) = kept.poles
    assert pole.rad_s == pytest.approx(RESONANCE, rel=1e-9)
    assert pole.damping == pytest.approx(0.5 * DAMPING / STIFFNESS * RESONANCE, rel=1e-9)
    assert kept.zeros == ()
    assert kept.real_zeros_rad_s == pytest.approx((STIFFNESS / DAMPING,), rel=1e-6)


def test_the_axis_with_its_resonance_is_the_free_mechanism() -> None:
    found = chain(belt(), 2000.0)
    assert found.one.resonances is not None
    free = {name: link for name, link in found.last.links.items() if not name.startswith("bearing")}
    import msgspec

    system = linearise(assemble_cached(msgspec.structs.replace(found.last, links=free))).transfer(
        "motor", "encoder"
    )
    w = np.geomspace(10.0, 5000.0, 60)
    constant = 0.05 / 0.5
    axis = linear_axis(
        AxisRates(constant / found.one.inertia, 0.0, 0.0),
        0.0,
        0.0,
        resonance_filters(found.one.resonances)[0],
    ).system
    position = -axis.response(w)[:, 2, 0]  # eta is minus the position
    np.testing.assert_allclose(position, system.response(w)[:, 0, 0], rtol=1e-6)


def test_a_filter_has_the_response_of_its_poles_and_zeros() -> None:
    given = Resonances(
        poles=(Oscillation(300.0, 0.02, (280.0, 320.0)), Oscillation(900.0, 0.1)),
        links=("a",),
        zeros=(Oscillation(500.0, 0.03),),
        real_zeros_rad_s=(2000.0, -3000.0),
    )
    s = 1j * np.geomspace(1.0, 3000.0, 50)

    def pair(w: float, d: float) -> np.ndarray:
        return np.asarray(1.0 + 2.0 * d * s / w + s**2 / w**2)

    above = pair(500.0, 0.03) * (1.0 + s / 2000.0) * (1.0 - s / 3000.0)
    for w, filtered in zip((300.0, 280.0, 320.0), resonance_filters(given), strict=True):
        np.testing.assert_allclose(
            filtered.response(s.imag)[:, 0, 0],
            above / (pair(w, 0.02) * pair(900.0, 0.1)),
            rtol=1e-9,
        )


def test_a_mechanism_that_yields_needs_a_bandwidth() -> None:
    with pytest.raises(NoSolutionError, match="compliant links: belt; give a bandwidth"):
        chain(belt(), None)
