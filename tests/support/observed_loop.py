"""A PI of the speed on the clutch, and observers of it, for tests of what an observer does in a
loop."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np

from frictool.documents.controller import Controller, DelayCheck, LinearController, Velocity, Vertex
from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.observe.design.tracking import design_tracking
from frictool.plant.lti import Lti
from frictool.synth.realisation import stored_forms
from studies.rigs.example_controllers import CONSTANT, CUT_LAW, clutch_controller
from studies.rigs.verified_controller import truthful

PERIOD = 1e-3
CLUTCH = load(Path(__file__).parents[2] / "configs/clutch/nonlinear.yaml", Model)


def pi(gain: float, integral_time: float, period: float = PERIOD) -> LinearController:
    """gain [N m s/rad] (1 + 1/(T_i s)), by Tustin, its integrator held and not driven."""
    k, half = gain / CONSTANT, 0.5 * period / integral_time
    system = Lti(
        np.eye(1),
        np.array([[period / integral_time]]),
        np.array([[k]]),
        np.array([[k * (1.0 + half)]]),
        period,
    )
    return msgspec.structs.replace(
        stored_forms(system), input="speed_error", conditional=True, anti_windup=(0.0,)
    )


def by_speed(
    gain: float = 1.0e-3, integral_time: float = 0.06, velocity: Velocity | None = None
) -> Controller:
    """A PI of the speed behind the square-root law, verified at a light and a heavy clutch,
    low-pass of 1000 rad/s."""
    made = clutch_controller(CUT_LAW, speed=pi(gain, integral_time))
    checks = (DelayCheck(0, 0.9, 0.5), DelayCheck(1, 0.9, 0.5))
    plants = {"light": (1.11e-5, 0.018, 14.0e-3), "heavy": (1.53e-5, 0.18, 12.8e-3)}
    vertices = tuple(
        Vertex(name, j, 0.0, f, k, 1.0, 1.0, 0.5, True, checks)
        for name, (j, f, k) in plants.items()
    )
    verified = msgspec.structs.replace(
        made.verified, vertices=vertices, modulus_margin_specified=0.4
    )
    velocity = velocity or Velocity(bandwidth_rad_s=1000.0)
    return truthful(msgspec.structs.replace(made, verified=verified, velocity=velocity))


def tracking(bandwidth: float | None = None) -> Observer:
    """The clutch's tracking observer."""
    return design_tracking(CLUTCH, Provenance("frictool observe design", "0"), bandwidth)
