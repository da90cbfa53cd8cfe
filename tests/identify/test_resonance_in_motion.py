"""A resonance of the drive train shows in the response of the acceleration to the effort.

The axis is two inertias in exact steps of a linear system; dry friction acts on the motor, whose
encoder a controller follows with its noise.
"""

from __future__ import annotations

import math
from dataclasses import replace

import msgspec
import numpy as np
import pytest
import scipy

from frictool.adapters.two_inertias import two_inertias
from frictool.documents.resonances import Ringing
from frictool.identify.measurement import resonance_in_motion as resonance_in_motion_module
from frictool.identify.measurement.resonance_in_motion import (
    Spectra,
    _oscillation,
    _Peak,
    _Response,
    resonance_in_motion,
)
from frictool.identify.motion_record import MotionRecord, make_record

PERIOD, SAMPLES = 0.002, 12000  # s
COUNT = 2.0 * math.pi / 2**18
MOTOR, LOAD = 0.4, 0.9  # kg m^2
COULOMB, VISCOUS = 2.0, 1.0  # N m, N m s/rad
GAIN, DAMPING = 800.0, 30.0  # of the controller, N m/rad, N m s/rad


def moving(hertz: float | None, damping: float, noise: float) -> MotionRecord:
    """Return a record of an axis with a resonance, or of a rigid axis.

    hertz: frequency at which motor and load oscillate, or None for a rigid axis. noise: rms noise
    of the effort, N m.
    """
    reduced = MOTOR * LOAD / (MOTOR + LOAD)
    rate = 2.0 * math.pi * (hertz or 1.0)
    spring, damper = reduced * rate**2, 2.0 * damping * reduced * rate
    if hertz is None:
        a = np.array([[0.0, 1.0], [0.0, -VISCOUS / (MOTOR + LOAD)]])
        b = np.array([0.0, 1.0 / (MOTOR + LOAD)])
    else:
        coupling = np.array([spring, damper, -spring, -damper])
        a = np.array([[0, 1, 0, 0], -coupling / MOTOR, [0, 0, 0, 1], coupling / LOAD], dtype=float)
        a[1, 1] -= VISCOUS / MOTOR
        b = np.array([0.0, 1.0 / MOTOR, 0.0, 0.0])
    n = b.size
    step = scipy.linalg.expm(PERIOD * np.block([[a, b[:, None]], [np.zeros((1, n + 1))]]))
    draw = np.random.default_rng(17)
    disturbance = noise * draw.standard_normal(SAMPLES)
    time = PERIOD * np.arange(SAMPLES)
    goal = np.sin(2.0 * time) + 0.2 * np.sin(7.0 * time)
    position, effort, state, before = np.empty(SAMPLES), np.empty(SAMPLES), np.zeros(n), 0.0
    for k in range(SAMPLES):
        position[k] = COUNT * math.floor(state[0] / COUNT)
        speed = (goal[k] - goal[k - 1] if k else 0.0) - (position[k] - before)
        before = position[k]
        effort[k] = GAIN * (goal[k] - position[k]) + DAMPING * speed / PERIOD + disturbance[k]
        net = effort[k] - COULOMB * np.sign(state[1])
        state = (step @ np.append(state, net))[:n]
    return make_record("moving", time, position, effort, resolution=COUNT, lag=0.0)


@pytest.mark.parametrize(("hertz", "damping"), [(45.0, 0.02), (90.0, 0.05)])
def test_frequency_and_damping_are_found(hertz: float, damping: float) -> None:
    found = resonance_in_motion([moving(hertz, damping, 2.0)], MOTOR + LOAD)
    assert found is not None
    assert found.in_motion
    assert found.rad_s == pytest.approx(2.0 * math.pi * hertz, rel=0.03)
    assert 0.5 * damping < found.damping < 2.0 * damping
    assert found.interval_rad_s is not None
    assert found.interval_rad_s[0] < found.rad_s < found.interval_rad_s[1]


@pytest.mark.parametrize("noise", [0.0, 2.0])
def test_a_rigid_axis_has_none_although_the_controller_follows_the_noise(noise: float) -> None:
    assert resonance_in_motion([moving(None, 0.0, noise)], MOTOR + LOAD) is None


def test_records_without_excitation_do_not_hide_the_resonance_of_another_record() -> None:
    excited, quiet = moving(45.0, 0.02, 2.0), moving(45.0, 0.02, 0.0)
    alone = resonance_in_motion([excited], MOTOR + LOAD)
    assert alone is not None
    assert resonance_in_motion([quiet], MOTOR + LOAD) is None
    slow = replace(excited, period=2.0 * PERIOD)
    for records in ([quiet] * 12 + [excited], [slow.part(slice(0, 100)), quiet, excited]):
        found = resonance_in_motion(records, MOTOR + LOAD)
        assert found is not None
        assert found.rad_s == pytest.approx(alone.rad_s, rel=0.02)


@pytest.mark.parametrize(("around", "resonance"), [(0.15, False), (0.5, True), (0.9, True)])
def test_a_single_tone_is_no_resonance(
    around: float, resonance: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At constant speed, encoder counts are a tone that the controller follows.

    Near the tone, effort and acceleration are independent: their coherence is that of noise.
    """
    response = resonance_in_motion_module._response

    def of_tone(acceleration: Spectra, effort: Spectra) -> _Response:
        found = response(acceleration, effort)
        peak = int(np.argmax(np.abs(found.value[: found.value.size // 2])))
        coherence = np.full(found.coherence.size, around)
        coherence[peak - 1 : peak + 2] = 0.95
        return found._replace(coherence=coherence)

    monkeypatch.setattr(resonance_in_motion_module, "_response", of_tone)
    found = resonance_in_motion([moving(45.0, 0.02, 2.0)], MOTOR + LOAD)
    assert (found is not None) is resonance


def test_the_resonance_is_written_to_a_document() -> None:
    """Without a pair of poles near the peak, the width of the peak gives the damping."""
    value = np.ones(200, dtype=np.complex128)
    value[100] = 10.0
    peak = _Peak(1024, 100, True, _Response(value, np.ones(200), np.zeros(200)), PERIOD)
    assert msgspec.to_builtins(_oscillation(peak))["damping"] > 0.0


def test_a_short_record_shows_none() -> None:
    record = moving(45.0, 0.02, 2.0).part(slice(0, 1500))
    assert resonance_in_motion([record], MOTOR + LOAD) is None
    assert resonance_in_motion([], MOTOR + LOAD) is None


def test_in_motion_both_bodies_oscillate() -> None:
    plants = [*two_inertias(Ringing(300.0, 0.03, in_motion=True))]
    assert len(plants) == 6
    assert all(not plant.rests and plant.pole == 1.0 for plant in plants)
    assert len([*two_inertias(Ringing(300.0, 0.03))]) == 16
