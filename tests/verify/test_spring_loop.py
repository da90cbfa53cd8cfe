"""Loops around an axis with a spring: against the equation of motion, Routh's criterion and the
frequency response; what `verify` finds again."""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from frictool.documents.controller import Controller
from frictool.documents.digests import with_digests
from frictool.documents.quantity import Estimate
from frictool.errors import NoSolutionError
from frictool.plant.linear_axis import AxisRates
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.verify.document_check import check_document
from frictool.verify.feedback_loops import (
    DIFFERENCE,
    ETA,
    FeedbackLoop,
    feedbacks_of,
    measured_axis,
    open_loop,
)
from frictool.verify.hinf_norm import spectral_radius
from frictool.verify.margins import sensitivity
from frictool.verify.recheck import recheck, verify
from frictool.verify.spring_loop import require_spring_margin, spring_check
from frictool.verify.vertices import vertex_points
from tests.support.sprung_valve import positioner, valve

PERIOD = 1e-4
POINT = PlantPoint("v1", 0.13, 4.0, 9.3, 4.0)
STIFFNESS = 60.0  # N m/rad


def stiff(*ends: float) -> Estimate:
    return Estimate(ends[-1], min(ends), max(ends), "N m/rad", source="identified")


@pytest.fixture(scope="module")
def sprung() -> Controller:
    return positioner(valve(0.84, 0.88, 0.92))


@pytest.mark.parametrize("lag", [0.0, 0.001])
@pytest.mark.parametrize("sees", [(ETA,), (DIFFERENCE,), (ETA, DIFFERENCE)])
def test_the_axis_oscillates_as_its_equation_of_motion(sees: tuple[str, ...], lag: float) -> None:
    """The poles of J s^2 + B s + k, and the static deflection K u/k."""
    rates = replace(POINT.rates, spring=STIFFNESS / POINT.inertia)
    axis = measured_axis(rates, lag, PERIOD, sees).system
    poles = np.linalg.eigvals(axis.a)
    for root in np.roots([POINT.inertia, POINT.viscous, STIFFNESS]):
        assert np.min(np.abs(poles - np.exp(root * PERIOD))) < 1e-9
    gains = axis.response(0.0)[0, :, 0].real
    assert gains[0] == pytest.approx(0.0, abs=1e-9)
    deflection = {ETA: -POINT.constant / STIFFNESS, DIFFERENCE: 0.0}
    assert gains[1:] == pytest.approx([deflection[name] for name in sees], abs=1e-9)


@pytest.mark.parametrize("share", [0.98, 1.02])
def test_an_integrator_is_stable_up_to_the_limit_of_routh(share: float) -> None:
    """J s^3 + B s^2 + k s + K g is stable for K g < B k/J; a sample delays by half a period."""
    gain = share * POINT.viscous * STIFFNESS / (POINT.inertia * POINT.constant)
    integrator = Lti(np.eye(1), np.eye(1), np.array([[gain * PERIOD]]), np.zeros((1, 1)), PERIOD)
    loops = [FeedbackLoop("position loop", integrator, (ETA,))]
    check = spring_check(loops, [POINT], (0.0, 0), stiff(STIFFNESS), None)
    assert check is not None
    assert (check.spectral_radius < 1.0) == (share < 1.0)
    assert (check.modulus_margin > 0.0) == (share < 1.0)
    if share > 1.0:
        with pytest.raises(NoSolutionError, match=r"60 N m/rad: the loop is unstable"):
            require_spring_margin(check, 0.0)


def test_the_margin_of_a_speed_loop_is_its_distance_from_minus_one(sprung: Controller) -> None:
    """The speed loop holds every position, which is a pole at 1; the other poles decide."""
    (loop,) = feedbacks_of(sprung)
    point = vertex_points(sprung)[0]
    lag = sprung.bench.actuator.loop_time_constant_s
    grid = np.geomspace(1e-3, 0.999 * math.pi / sprung.sample_period_s, 20_000)
    for stiffness in (0.92, 300.0):
        rates = replace(point.rates, spring=stiffness / point.inertia)
        gain = open_loop(loop, rates, lag, sprung.delay_samples)
        assert spectral_radius(sensitivity(gain).a) == pytest.approx(1.0, abs=1e-9)
        check = spring_check([loop], [point], (lag, 1), stiff(stiffness), None)
        assert check is not None
        assert check.spectral_radius < 1.0 - 1e-6
        distance = np.min(np.abs(1.0 + gain.response(grid)[:, 0, 0]))
        assert check.modulus_margin == pytest.approx(distance, rel=1e-4)


def test_both_ends_are_checked_and_a_stiffness_of_0_is_none() -> None:
    controller = Lti(np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)), np.eye(1), PERIOD)
    loops = [FeedbackLoop("position loop", controller, (ETA,))]
    assert spring_check(loops, [POINT], (0.0, 0), stiff(0.0, 0.0), None) is None
    # a negative stiffness of more than the gain of the loop, K, drives the axis away
    for low, stable in ((-0.9 * POINT.constant, True), (-1.1 * POINT.constant, False)):
        check = spring_check(loops, [POINT], (0.0, 0), stiff(low, STIFFNESS), None)
        assert check is not None
        assert (check.spectral_radius < 1.0) == stable
        assert f"{low:.4g} N m/rad" in check.where or stable


def test_rates_without_a_spring_are_unchanged() -> None:
    assert POINT.rates == AxisRates(4.0 / 0.13, 4.0 / 0.13, 9.3 / 0.13)
    assert measured_axis(POINT.rates, 0.0, PERIOD, (DIFFERENCE,)).system.order == 2


def test_the_document_keeps_the_spring_and_verify_finds_it_again(sprung: Controller) -> None:
    assert sprung.stiffness is not None
    assert sprung.stiffness.interval == (0.84, 0.92)
    recheck(sprung)
    model = verify(sprung, valve(0.84, 0.88, 0.92)).model
    assert model is not None
    assert model.holds
    assert model.sprung is not None
    assert 0.5 < model.sprung.modulus_margin < model.margin + 0.01


def test_a_spring_beyond_the_verified_one_is_named(sprung: Controller) -> None:
    weaker = verify(sprung, valve(0.1, 0.5, 0.9)).model
    stronger = verify(sprung, valve(0.84, 0.88, 1.5)).model
    assert weaker is not None
    assert stronger is not None
    assert weaker.beyond == ()
    assert stronger.beyond == (
        "stiffness of a spring on the axis 1.5 N m/rad, verified 0 to 0.92 N m/rad",
    )
    assert not stronger.holds


def test_a_document_whose_spring_makes_the_loop_unstable_is_refused(sprung: Controller) -> None:
    """The integrator of the speed loop, K/T_i, holds the axis against a weaker negative spring."""
    assert sprung.stiffness is not None
    limit = 7.0 / 0.15  # N m/rad, speed gain over integral time of the design
    for stiffness, refused in ((-0.5 * limit, False), (-1.5 * limit, True)):
        edited = with_digests(msgspec.structs.replace(sprung, stiffness=stiff(stiffness)))
        edited = msgspec.structs.replace(
            edited,
            verified=msgspec.structs.replace(edited.verified, modulus_margin_specified=0.0),
        )
        if refused:
            with pytest.raises(NoSolutionError, match="with the spring, speed loop"):
                check_document(edited)
        else:
            check_document(edited)
