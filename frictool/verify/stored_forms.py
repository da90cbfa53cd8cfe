"""The forms in which a controller document holds one controller, against each other: what is
flashed may be any of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.documents.controller import Controller, LinearController, Row
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti, tustin
from frictool.verify.feedback_loops import running_form
from frictool.verify.hinf_norm import spectral_radius

# of the peak of (z - 1) K(z), or of K(z) without an integrator; sections are stored where they
# agree to half of it
AGREEMENT = 2e-6
AT_ONE = 1e-9  # a pole nearer to z = 1 is meant to be an integrator
ANGLES = np.geomspace(
    1e-3, np.pi * (1.0 - 1e-9), 200
)  # a form with a delay has a pole at z = -1 of its inverse Tustin image


def check_forms(controller: Controller) -> None:
    """Raises NoSolutionError where the sections or the continuous form are not the discrete one, or
    the anti-windup is unstable.

    With conditional integration the integrators are held and not driven, so that only the rest has
    to be stable by itself.
    """
    linear, period = controller.linear, controller.sample_period_s
    system = Lti.of(linear.discrete, period)
    direct = system.response(ANGLES / period)[:, 0, 0]
    poles = np.linalg.eigvals(system.a) if system.order else np.empty(0)
    weight = (
        np.abs(np.exp(1j * ANGLES) - 1.0)
        if np.any(np.abs(poles - 1.0) < AT_ONE)
        else np.ones(len(ANGLES))
    )
    others = {
        "sos": sections_response(linear.sos, ANGLES),
        "continuous": tustin(Lti.of(linear.continuous, 0.0), period).response(ANGLES / period)[
            :, 0, 0
        ],
    }
    for name, other in others.items():
        apart = float(np.max(weight * np.abs(other - direct)) / np.max(weight * np.abs(direct)))
        if not apart <= AGREEMENT:
            raise NoSolutionError(
                f"{controller.name}: not verified: linear.{name} is not linear.discrete, which was verified (apart by {apart:.3g} of the "
                "peak of their frequency responses); synthesise it anew"
            )
    radius = limited_radius(linear, period)
    if radius >= 1.0:
        name = "sos_anti_windup" if linear.form == "sos" else "anti_windup"
        raise NoSolutionError(
            f"{controller.name}: not verified: the anti-windup gains (linear.{name}) leave the controller unstable while the drive "
            f"is limited (spectral radius {radius:.6g} of a - l c); synthesise it anew"
        )


def limited_radius(linear: LinearController, period: float) -> float:
    """Spectral radius of the controller while the drive is limited: of a - l c, without integrators
    that are held then."""
    gains = linear.sos_anti_windup if linear.form == "sos" else linear.anti_windup
    runs = running_form(linear, period)
    limited = runs.a - np.outer(gains, runs.c)
    if linear.conditional:
        kept = [
            k for k in range(runs.order) if not np.array_equal(runs.a[k], np.eye(runs.order)[k])
        ]
        limited = limited[np.ix_(kept, kept)]
    return spectral_radius(limited)


def sections_response(
    sections: tuple[Row, ...], angles: NDArray[np.float64]
) -> NDArray[np.complex128]:
    """Of the product of second-order sections at the angles on the unit circle."""
    delayed = np.exp(-1j * angles)
    powers = np.stack([np.ones(len(angles)), delayed, delayed**2])
    response = np.ones(len(angles), dtype=np.complex128)
    for section in sections:
        response *= (np.array(section[:3]) @ powers) / (np.array(section[3:]) @ powers)
    return response
