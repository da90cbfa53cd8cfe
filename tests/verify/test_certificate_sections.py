"""The certificate of a controller that runs as second-order sections is of those, coefficient by
coefficient."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache

import msgspec
import numpy as np
import pytest

from frictool.adapters.state_space import stored_state_space
from frictool.documents.certificate import Certificate, CertifiedWeights, Filter
from frictool.errors import NoSolutionError
from frictool.plant.generalised_plant import FirstOrderWeight, PlantWeights, generalised_plant
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.synth.certificate_construction import certify
from frictool.verify.certificate_loop import CertificateLoop, closed_loop
from frictool.verify.certificate_proof import prove
from frictool.verify.enclosed_axis import corners
from frictool.verify.feedback_loops import chain
from frictool.verify.interval_arithmetic import ONE
from tests.verify.gentle_loop import BOX, GENTLE, LAG, LOOP, PERIOD, WEIGHTS

# a section of the second order, one of the first, one that is a delay, one that is a gain
SECTIONS = (
    (0.02, 0.01, 0.003, 1.0, -1.4, 0.5),
    (1.0, -0.9, 0.0, 1.0, -0.95, 0.0),
    (0.0, 1.0, 0.0, 1.0, 0.0, 0.0),
    (1.5, 0.0, 0.0, 1.0, 0.0, 0.0),
)


@pytest.mark.parametrize("lag", [0.0, LAG])
@pytest.mark.parametrize("delay", [0, 1])
def test_the_enclosed_loop_is_the_generalised_plant_closed_by_the_chain(
    lag: float, delay: int
) -> None:
    weights = CertifiedWeights(Filter(31.5, 40.0, 0.635), 0.03, 0.5, 0.2, Filter(0.01), 0.1)
    loop = CertificateLoop(
        stored_state_space(GENTLE), "speed", delay, lag, PERIOD, weights, SECTIONS
    )
    assert loop.inner == [
        "section 0.1",
        "section 0.2",
        "section 1.1",
        "section 2.1",
    ]  # no state that nothing feeds
    narrow = Fraction(10), Fraction(10) + Fraction(1, 10**6)
    enclosed, n = closed_loop(
        loop,
        corners(
            (Fraction(900), Fraction(1000)), narrow, (Fraction(300), Fraction(400)), lag, PERIOD
        )[0],
    )
    whole = (enclosed.centre / ONE).astype(float)
    found = Lti(whole[:n, :n], whole[:n, n:], whole[n:, :n], whole[n:, n:], PERIOD)
    judged = PlantWeights(
        FirstOrderWeight(31.5, 40.0, 0.635), 0.03, 0.5, 0.2, FirstOrderWeight(0.01), 0.1
    )
    plant = generalised_plant("speed", AxisRates(900, 10, 300), lag, judged, PERIOD, delay)
    looks = np.array([1.0, 30.0, 300.0, 2500.0])
    assert found.response(looks) == pytest.approx(
        plant.closed(chain(SECTIONS, PERIOD)).response(looks), rel=1e-7, abs=1e-9
    )


def in_sections() -> CertificateLoop:
    """The loop of test_certificate.py, its controller of order 1 as one section."""
    (a,), (b,), (c,), (d,) = GENTLE.a.ravel(), GENTLE.b.ravel(), GENTLE.c.ravel(), GENTLE.d.ravel()
    return replace(LOOP, sections=((float(d), float(b * c - a * d), 0.0, 1.0, float(-a), 0.0),))


@cache
def certificate() -> Certificate:
    return certify(in_sections(), BOX)


def test_it_is_proved_of_the_sections() -> None:
    assert [one.of for one in prove(certificate(), in_sections())] == ["norm", "sensitivity"]
    assert certificate().weights == WEIGHTS


@pytest.mark.parametrize("place", [0, 1, 4])
def test_a_section_that_is_changed_fails(place: int) -> None:
    (section,) = in_sections().sections
    spoilt = tuple(1.2 * value if index == place else value for index, value in enumerate(section))
    with pytest.raises(NoSolutionError, match="not proved"):
        prove(certificate(), replace(in_sections(), sections=(spoilt,)))


def test_matrices_beside_the_sections_are_not_looked_at() -> None:
    other = msgspec.structs.replace(LOOP.controller, d=((0.0,),))
    assert prove(certificate(), replace(in_sections(), controller=other))
