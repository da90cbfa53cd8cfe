"""Every block of a controller is told, and none that it does not have."""

from __future__ import annotations

import msgspec
import pytest

from frictool.documents.bench import Winding
from frictool.documents.controller import (
    Controller,
    Feedforward,
    FrictionCompensation,
    Limiter,
    PositionLaw,
    Prefilter,
    Profile,
    Velocity,
)
from frictool.report.controller_blocks import block_descriptions
from studies.rigs.step_logs import controller


def told(**changes: object) -> dict[str, str]:
    return dict(block_descriptions(msgspec.structs.replace(controller(), **changes)))


def position_loop() -> Controller:
    return msgspec.structs.replace(controller(), structure="position", position_law=None)


def test_a_plain_cascade_has_its_law_and_its_linear_part() -> None:
    found = told()
    assert list(found) == [
        "Position law",
        "Linear",
        "Drive",
    ]  # a law that only cuts sees no velocity
    assert found["Position law"] == (
        "square root, gain 81.1 by sqrt(F/J); inside the band of 2 rad: drive 0, once the "
        "prefilter is slower than 5 rad/s"
    )
    assert (
        found["Linear"]
        == "order 1 from eta = (integral of the speed reference) - position, runs as "
        "state space"
    )
    assert found["Drive"] == "current limited to 50 A"


@pytest.mark.parametrize(
    ("velocity", "words"),
    [
        (Velocity(), "the encoder's difference, not filtered"),
        (
            Velocity(bandwidth_rad_s=150.0),
            "the encoder's difference through a first-order low-pass at 150 rad/s",
        ),
        (
            Velocity(bandwidth_rad_s=300.0, order=2),
            "the encoder's difference through a second-order low-pass at 300 rad/s",
        ),
        (Velocity(source="measured"), "from a separate sensor"),
    ],
)
def test_velocity_where_a_block_sees_it(velocity: Velocity, words: str) -> None:
    assert "Velocity" not in told(velocity=velocity)
    brake = PositionLaw(gain=160.0, band=1.1, action="brake", rest_speed=40.0)
    by_speed = msgspec.structs.replace(controller().linear, input="speed_error")
    assert told(velocity=velocity, position_law=brake)["Velocity"] == words
    assert told(velocity=velocity, linear=by_speed)["Velocity"] == words
    assert (
        told(
            velocity=velocity,
            friction_compensation=FrictionCompensation(
                "observer", observer_rad_s=50.0, inertia=1e-5
            ),
        )["Velocity"]
        == words
    )
    limited = msgspec.structs.replace(
        position_loop(), velocity=velocity, limiter=Limiter("error", 2.0)
    )
    assert dict(block_descriptions(limited))["Velocity"] == words


@pytest.mark.parametrize(
    ("law", "words"),
    [
        (
            PositionLaw(gain=10.0, kind="proportional"),
            "proportional, gain 10; the loop stays closed everywhere",
        ),
        (
            PositionLaw(
                gain=160.0, formula="sqrt(2F/J)", band=1.1, action="brake", rest_speed=40.0
            ),
            "square root, gain 160 by sqrt(2F/J); inside the band of 1.1 rad: speed reference 0, "
            "drive 0 below 40 rad/s",
        ),
    ],
)
def test_position_laws(law: PositionLaw, words: str) -> None:
    assert told(position_law=law)["Position law"] == words


@pytest.mark.parametrize(
    ("limiter", "words"),
    [
        (
            Limiter("energy", 2.0, inertia=1e-5, coulomb=0.1),
            "drive released where ||e| - J v²/2F| < 2 rad, the integral frozen",
        ),
        (
            Limiter("error", 2.0),
            "drive released where |e| < 2 rad (the usual cut-off), the integral frozen",
        ),
        (
            Limiter(
                "energy",
                2.0,
                inertia=1e-5,
                coulomb=0.1,
                virtual_coulomb=1.0,
                virtual_speed=0.01,
                settled_speed=5.0,
            ),
            "drive released where ||e| - J v²/2F| < 2 rad, the integral frozen, with a "
            "virtual friction of 1, once the prefilter is slower than 5 rad/s",
        ),
    ],
)
def test_limiters(limiter: Limiter, words: str) -> None:
    found = dict(block_descriptions(msgspec.structs.replace(position_loop(), limiter=limiter)))
    assert found["Limit-cycle limiter"] == words
    assert found["Linear"].startswith("order 1 from the position's error")


@pytest.mark.parametrize(
    ("block", "words"),
    [
        (
            FrictionCompensation("model", "reference", coulomb=0.1, smoothing_speed=1.0),
            "adds 100 % of the friction of the model, at the reference",
        ),
        (
            FrictionCompensation(
                "model", smoothing_speed=1.0, speeds=(-1.0, 1.0), efforts=(-0.1, 0.1)
            ),
            "adds 100 % of the friction of the model, as a table of 2 speeds, at the measured",
        ),
        (
            FrictionCompensation(
                "model", smoothing_speed=1.0, positions=(0.0, 1.0), forward=(-0.1, 0.1)
            ),
            "adds 100 % of the friction of the model, with a table of 2 positions, at the measured",
        ),
        (
            FrictionCompensation("observer", observer_rad_s=50.0, inertia=1e-5, gain=0.8),
            "adds 80 % of the friction that an observer of 50 rad/s",
        ),
    ],
)
def test_friction_compensation(block: FrictionCompensation, words: str) -> None:
    assert told(friction_compensation=block)["Friction compensation"].startswith(words)


def test_prefilter_form_and_winding() -> None:
    bench = controller().bench
    wound = msgspec.structs.replace(
        bench, actuator=msgspec.structs.replace(bench.actuator, winding=Winding(0.2, 12.0))
    )
    linear = msgspec.structs.replace(
        controller().linear, form="sos", sos_anti_windup=(0.0, 0.0), conditional=True
    )
    found = told(prefilter=Prefilter(30.0, 0.8), bench=wound, linear=linear)
    assert found["Prefilter"] == "second-order low-pass of the reference, 30 rad/s, damping 0.8"
    assert found["Drive"] == "current limited to 50 A, and by 12 V over 0.2 Ω and the back-EMF"
    assert found["Linear"].endswith(
        "runs as second-order sections, integrators held while the drive is limited"
    )


def test_profile_and_feedforward() -> None:
    found = told(
        profile=Profile(100.0, 2000.0, 5),
        feedforward=Feedforward(1.3e-5, 3.8e-4, 0.1, switch_on_speed=10.0, switch_off_speed=5.0),
    )
    assert found["Profile"] == (
        "at most 100 rad/s and 2000 rad/s², jerk limited by a moving average of 5 samples"
    )
    assert found["Feedforward"] == ("inertia 1.3e-05, viscous 0.00038, Coulomb 0.1 above 10 rad/s")
    streamed = Feedforward(1.3e-5, 0.0, 0.0, 10.0, 5.0, filter_rad_s=300.0)
    words = told(feedforward=streamed)["Feedforward"]
    assert words.endswith("derivatives of the reference filtered at 300 rad/s")
