"""Comparison of the stored forms of a linear controller: discrete, continuous, sections."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.adapters.state_space import read_state_space
from frictool.documents.controller import Controller, LinearController, Row
from frictool.errors import NoSolutionError
from frictool.plant.lti import tustin
from frictool.verify.feedback_loops import running_form
from frictool.verify.hinf_norm import spectral_radius

# allowed difference of two frequency responses, relative to the peak of (z - 1) K(z), or to the
# peak of K(z) if K has no integrator
AGREEMENT = 2e-6
AT_ONE = 1e-9  # distance from z = 1 below which a pole is an integrator
# without z = -1, where the inverse Tustin image of a delay has a pole
ANGLES = np.geomspace(1e-3, np.pi * (1.0 - 1e-9), 200)


def check_forms(controller: Controller) -> None:
    """Raise NoSolutionError if the stored forms differ, or if the anti-windup is unstable.

    With conditional integration, the integrators are held while the drive is limited, so that only
    the other states must be stable.
    """
    linear, period = controller.linear, controller.sample_period_s
    system = read_state_space(linear.discrete, period)
    direct = system.response(ANGLES / period)[:, 0, 0]
    poles = np.linalg.eigvals(system.a) if system.order else np.empty(0)
    weight = (
        np.abs(np.exp(1j * ANGLES) - 1.0)
        if np.any(np.abs(poles - 1.0) < AT_ONE)
        else np.ones(len(ANGLES))
    )
    others = {
        "sos": sections_response(linear.sos, ANGLES),
        "continuous": tustin(read_state_space(linear.continuous, 0.0), period).response(
            ANGLES / period
        )[:, 0, 0],
    }
    for name, other in others.items():
        apart = float(np.max(weight * np.abs(other - direct)) / np.max(weight * np.abs(direct)))
        if not apart <= AGREEMENT:
            raise NoSolutionError(
                f"{controller.name}: not verified: linear.{name} is not equal to "
                f"linear.discrete (difference: {apart:.3g} of the peak of the frequency response); "
                "run frictool synth again"
            )
    radius = limited_radius(linear, period)
    if radius >= 1.0:
        name = "sos_anti_windup" if linear.form == "sos" else "anti_windup"
        raise NoSolutionError(
            f"{controller.name}: not verified: with linear.{name} the controller is unstable while "
            f"the drive is limited (spectral radius {radius:.6g} of a - l c); "
            "run frictool synth again"
        )


def limited_radius(linear: LinearController, period: float) -> float:
    """Return the spectral radius of the controller's state matrix while the drive is limited.

    Integrators that keep their value while the drive is limited are left out.
    """
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
    """Return the frequency response of a chain of second-order sections at z = exp(j angle)."""
    delayed = np.exp(-1j * angles)
    powers = np.stack([np.ones(len(angles)), delayed, delayed**2])
    response = np.ones(len(angles), dtype=np.complex128)
    for section in sections:
        response *= (np.array(section[:3]) @ powers) / (np.array(section[3:]) @ powers)
    return response
