"""Margins against what they promise (the loop is stable just inside and unstable just outside), a
scanned Nyquist curve, and python-control."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.lti import Lti, parallel_sum, tustin
from frictool.verify.margins import (
    LoopMargins,
    gain_crossings,
    loop_margins,
    margins,
    open_loop,
    phase_crossings,
    small_gain,
)
from frictool.verify.speed_loop import check_loop, closed_loop

PERIOD, LAG = 1e-3, 3e-3
CLUTCH = AxisRates(1015.0, 29.0, 7500.0)
drawn = {
    "drive": st.floats(700.0, 1300.0),
    "viscous": st.floats(0.0, 60.0),
    "crossing": st.floats(20.0, 120.0),
    "lead": st.floats(2.0, 6.0),
    "slow": st.floats(5.0, 30.0),
    "delay": st.integers(0, 2),
}


def _lead(crossing: float, lead: float, slow: float, gain: float) -> Lti:
    """gain (1 + s/z)(1 + w1/s)/(1 + s/p), with its integrator exact once it is sampled."""
    zero, pole, corner = crossing / lead, 10.0 * crossing, crossing / slow
    k = gain * (1.0 + corner / zero), gain * (1.0 - pole / zero) * (1.0 - corner / pole)
    rest = Lti(
        np.array([[-pole]]),
        np.array([[pole]]),
        np.array([[k[1]]]),
        np.array([[gain * pole / zero]]),
        0.0,
    )
    integrator = Lti(
        np.zeros((1, 1)), np.ones((1, 1)), np.array([[gain * corner]]), np.zeros((1, 1)), 0.0
    )
    return parallel_sum(tustin(integrator, PERIOD), tustin(rest, PERIOD))


def _loop(
    drive: float, viscous: float, crossing: float, lead: float, slow: float, delay: int
) -> tuple[Lti, AxisRates]:
    gain = crossing**2 / (drive * np.hypot(1.0, lead))
    return _lead(crossing, lead, slow, gain), AxisRates(drive, viscous, 7500.0)


def _scaled(controller: Lti, factor: float) -> Lti:
    return Lti(
        controller.a, controller.b, factor * controller.c, factor * controller.d, controller.period
    )


def _stable(controller: Lti, rates: AxisRates, delay: int) -> bool:
    return closed_loop(controller, rates, LAG, delay).stable


@given(**drawn)
@settings(max_examples=settings.default.max_examples // 3)
def test_the_loop_is_stable_up_to_its_margins_and_not_beyond(**case: float) -> None:
    controller, rates = _loop(**case)
    delay = int(case["delay"])
    found = margins(controller, rates, LAG, delay)
    assume(found.modulus > 0.0)
    assert _stable(_scaled(controller, 1.0 + 0.9999 * (found.gain_up - 1.0)), rates, delay)
    assert not _stable(_scaled(controller, found.gain_up * 1.0001), rates, delay)
    assert _stable(_scaled(controller, 1.0 - 0.9999 * (1.0 - found.gain_down)), rates, delay)
    if found.gain_down > 0.0:
        assert not _stable(_scaled(controller, found.gain_down * 0.9999), rates, delay)
    whole = int(found.delay_samples)
    assert _stable(controller, rates, delay + whole)
    assert not _stable(controller, rates, delay + whole + 1)


@given(**drawn)
@settings(max_examples=settings.default.max_examples // 3)
def test_against_python_control(**case: float) -> None:
    import control  # takes a second, which the collection of the tests does not need

    controller, rates = _loop(**case)
    loop = open_loop(controller, rates, LAG, int(case["delay"]))
    found = loop_margins(loop)
    assume(found.modulus > 0.0)
    w = np.geomspace(1e-3, 0.99999 * np.pi / PERIOD, 2000)  # which it interpolates between
    gains, phases, _, at_phase, at_gain, _ = control.stability_margins(
        control.frd(loop.response(w)[:, 0, 0], w, smooth=True), returnall=True
    )
    above = [value for value in gains if value > 1.0]
    assert found.gain_up == pytest.approx(min(above), rel=1e-3)
    below = [value for value in gains if 1e-6 < value < 1.0]
    if below and found.gain_down > 1e-3:
        assert found.gain_down == pytest.approx(max(below), rel=1e-3)
    assert np.degrees(found.phase) == pytest.approx(np.min(np.abs(phases)), abs=0.05)
    assert found.crossing == pytest.approx(np.max(at_gain), rel=1e-3)
    assert len(at_phase) > 0


@given(**drawn)
@settings(max_examples=settings.default.max_examples // 3)
def test_against_a_scanned_nyquist_curve(**case: float) -> None:
    """No sign change of Im L or |L| - 1 on a fine scan is without its crossing, and min |1 + L| is
    the scan's."""
    controller, rates = _loop(**case)
    loop = open_loop(controller, rates, LAG, int(case["delay"]))
    w = np.geomspace(1e-2, 0.9999 * np.pi / PERIOD, 20_000)
    curve = loop.response(w)[:, 0, 0]
    for crossings, height in (
        (phase_crossings(loop), curve.imag),
        (gain_crossings(loop), np.abs(curve) - 1.0),
    ):
        for k in np.flatnonzero(height[:-1] * height[1:] < 0.0):
            assert np.any((crossings >= w[k] * 0.999999) & (crossings <= w[k + 1] * 1.000001))
    assert np.abs(loop.response(gain_crossings(loop))[:, 0, 0]) == pytest.approx(1.0, rel=1e-9)
    found = loop_margins(loop)
    if found.modulus > 0.0:
        assert found.modulus == pytest.approx(np.min(np.abs(1.0 + curve)), rel=1e-4)
        assert found.modulus == pytest.approx(
            check_loop(controller, rates, LAG, int(case["delay"])).modulus_margin, rel=1e-5
        )
        assert found.modulus <= min(1.0 - 1.0 / found.gain_up, 2.0 * np.sin(0.5 * found.phase)) * (
            1.0 + 1e-6
        )


def test_an_unstable_loop_has_no_margin() -> None:
    controller, rates = _loop(1015.0, 29.0, 60.0, 4.0, 10.0, 1)
    assert margins(_scaled(controller, 1e3), rates, LAG, 1) == LoopMargins(
        1.0, 1.0, 0.0, 0.0, 0.0, 0.0, pytest.approx(np.nan, nan_ok=True)
    )


def test_small_gain_is_the_peak_of_friction_to_speed() -> None:
    """The friction enters beside the drive, so that H = G_w/(1 + L) by hand."""
    controller, rates = _loop(1015.0, 29.0, 60.0, 4.0, 10.0, 1)
    w = np.geomspace(0.1, 0.999 * np.pi / PERIOD, 5000)
    axis = linear_axis(rates, LAG, PERIOD).system.response(w)
    # eta answers friction by -x; u = C eta; speed = P_v u + H_w friction
    control_of_eta = controller.response(w)[:, 0, 0] * np.exp(-1j * w * PERIOD)
    eta = axis[:, 2, 2] / (1.0 - axis[:, 2, 0] * control_of_eta)
    scanned = np.max(np.abs(axis[:, 1, 2] + axis[:, 1, 0] * control_of_eta * eta))
    assert small_gain(controller, rates, LAG, 1) == pytest.approx(scanned, rel=1e-4)
    assert small_gain(_scaled(controller, 1e3), rates, LAG, 1) == np.inf


def test_the_open_loop_closes_to_the_sensitivity() -> None:
    controller, rates = _loop(1015.0, 29.0, 60.0, 4.0, 10.0, 2)
    w = np.geomspace(1.0, 3000.0, 50)
    loop = open_loop(controller, rates, LAG, 2).response(w)[:, 0, 0]
    assert closed_loop(controller, rates, LAG, 2).response(w)[:, 0, 0] == pytest.approx(
        1.0 / (1.0 + loop), rel=1e-9
    )


@pytest.mark.parametrize("gain", [1e-4, 0.1, 0.7, 1.5])
@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_the_crossings_of_a_delayed_integrator_are_its_closed_form(
    gain: float, scale: float
) -> None:
    """L = k / (z (z - 1)): |L| = 1 at 2 asin(k/2), and arg L = -pi/2 - 3/2 angle is -pi at pi/3."""
    loop = Lti(
        np.array([[1.0, 1.0], [0.0, 0.0]]),
        np.array([[0.0], [gain / scale]]),
        np.array([[scale, 0.0]]),
        np.zeros((1, 1)),
        PERIOD,
    )
    assert gain_crossings(loop) * PERIOD == pytest.approx([2.0 * np.arcsin(0.5 * gain)], rel=1e-13)
    assert phase_crossings(loop) * PERIOD == pytest.approx([np.pi / 3.0, np.pi], rel=1e-13)
