"""Compositions that have every block between them, and what their golden vectors have to visit."""

from __future__ import annotations

import msgspec
import numpy as np

from frictool.documents.bench import Winding
from frictool.documents.controller import (
    Controller,
    Feedforward,
    FrictionCompensation,
    Limiter,
    LinearController,
    Profile,
    Velocity,
)
from studies.rigs.example_controllers import BRAKE_LAW, CUT_LAW, clutch_controller, speed_controller
from tests.support.export_controllers import scheduled, space
from tests.support.observed_loop import tracking

replace = msgspec.structs.replace


def _cascade() -> Controller:
    """(5.70), the band that brakes, a disturbance observer, a winding."""
    base = clutch_controller(BRAKE_LAW)
    actuator = replace(base.bench.actuator, winding=Winding(0.2, 12.0))
    observer = FrictionCompensation(
        source="observer", observer_rad_s=60.0, inertia=1.32e-5, gain=0.8
    )
    bench = replace(base.bench, actuator=actuator)
    return replace(
        base,
        velocity=Velocity(order=2, bandwidth_rad_s=600.0),
        friction_compensation=observer,
        bench=bench,
    )


def _position() -> Controller:
    """A PI in state space with conditional integration, (5.7) with virtual friction, a sensor of
    the speed, modelled friction."""
    gains = space(np.eye(1), np.array([0.01]), np.array([1.0]), 3.0)
    linear = LinearController(
        discrete=gains, continuous=gains, sos=(), anti_windup=(0.0,), conditional=True
    )
    limiter = Limiter(
        "energy",
        0.5,
        inertia=1.32e-5,
        coulomb=0.099,
        virtual_coulomb=0.05,
        virtual_speed=20.0,
        settled_speed=5.0,
    )
    modelled = FrictionCompensation(
        source="model", velocity="reference", coulomb=0.05, viscous=3e-4, smoothing_speed=15.0
    )
    return replace(
        clutch_controller(),
        structure="position",
        position_law=None,
        linear=linear,
        limiter=limiter,
        velocity=Velocity("measured"),
        friction_compensation=modelled,
    )


def _sections() -> Controller:
    """Second-order sections, a proportional law, no prefilter, nothing in the band."""
    base = clutch_controller(
        replace(CUT_LAW, kind="proportional", gain=7.0, action="none", settled_speed=None),
        prefilter=False,
    )
    linear = speed_controller()
    sections = tuple(linear.sos)
    return replace(
        base,
        linear=replace(
            linear, form="sos", sos=sections, sos_anti_windup=(1e-3, -1e-3) * len(sections)
        ),
    )


def _observed() -> Controller:
    """A band that brakes, and friction as tables, both by the speed of a tracking observer."""
    velocity = Velocity(source="observer", observer=tracking())
    modelled = FrictionCompensation(
        source="model",
        smoothing_speed=15.0,
        speeds=(-90.0, -30.0, -15.0, 15.0, 40.0, 80.0),
        efforts=(-0.07, -0.05, -0.08, 0.06, 0.04, 0.05),
        positions=(-10.0, 15.0, 40.0, 70.0),
        forward=(0.01, -0.02, 0.02, 0.0),
        backward=(0.02, 0.01, -0.01, 0.01),
        gain=0.5,
    )
    return replace(clutch_controller(BRAKE_LAW), velocity=velocity, friction_compensation=modelled)


def _profiled() -> Controller:
    """A profile and its feedforward before a band that brakes."""
    profile = Profile(speed=380.0, acceleration=20_000.0, smoothing_samples=5)
    fed = Feedforward(1.32e-5, 3.81e-4, 0.05, switch_on_speed=10.0, switch_off_speed=5.0)
    return replace(clutch_controller(BRAKE_LAW), prefilter=None, profile=profile, feedforward=fed)


def _streamed() -> Controller:
    """Second-order sections behind a reference from outside, which the feedforward differentiates,
    and a proportional law."""
    fed = Feedforward(
        1.32e-5, 3.81e-4, 0.05, switch_on_speed=10.0, switch_off_speed=5.0, filter_rad_s=100.0
    )
    return replace(_sections(), feedforward=fed)


CASES: dict[str, Controller] = {
    "cut": clutch_controller(CUT_LAW),
    "cascade": _cascade(),
    "position": _position(),
    "sections": _sections(),
    "scheduled": scheduled(clutch_controller(CUT_LAW)),
    "observed": _observed(),
    "profiled": _profiled(),
    "streamed": _streamed(),
}
VISITS = {
    "cut": {"run", "rest", "limited", "invalid", "fault"},
    "cascade": {"run", "brake", "rest", "limited", "voltage", "invalid", "fault"},
    "position": {"released", "braking", "held", "limited", "invalid", "fault"},
    "sections": {"limited", "invalid", "fault"},
    "scheduled": {"run", "rest", "limited", "invalid", "fault"},
    "observed": {"run", "brake", "rest", "limited", "invalid", "fault"},
    "profiled": {"run", "brake", "rest", "forward", "backward", "limited", "invalid", "fault"},
    "streamed": {"forward", "backward", "limited", "invalid", "fault"},
}
