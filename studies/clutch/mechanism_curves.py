"""Curves of configs/clutch/mechanism.yaml, which the thesis only draws (figures 2.12-2.14).

    python -m studies.clutch.mechanism_curves        prints the curves in the format of the file

The thesis states the friction map (4.42), (4.44) of tables 4.7 and 4.8, the ratio r, the friction
of the brushes, and the inertia. In slip the friction at the rotor is

    C_r+ = C_r2 + (mu_c F_s1 + F_res) r/eta        C_r- = C_r2 + (mu_c F_s1 - F_res) r/eta
                                                   (2.28)-(2.29)

with F_res = F_s2 - F_s1 tan(alpha). The mean of both directions therefore gives mu_c F_s1, and half
of their difference F_res. Typical values are assumed for eta (0.8 for reducer and rack together),
mu_c (0.12 for a greased slideway), the ratio of the piston areas (0.6), and the clutch (below). The
profile angle alpha follows from F_s1 tan(alpha) = F_s2 - F_res.

Two conclusions about the springs follow. The identified friction grows with theta, so that s1 is
compressed as theta grows, and s2, the clutch's spring, relaxes (2.2.2). The diaphragm relaxes when
the clutch closes (2.2.1), so that theta = 0 is the open clutch. F_s2 and tan(alpha) are negative:
s2 pushes the cart in the positive direction of x. F_s1 rises, falls and rises again over x, like
the force of a stack of disc springs. The dip in the first 3 rad, and the rise in the last 5 rad,
are the ends of the published polynomials.
"""

from __future__ import annotations

import sys
import textwrap

import numpy as np

from frictool.typing import Vector
from studies.rigs.clutch_friction import BACKWARD, BETA, FORWARD

RATIO = 2.0414e-4  # r, m/rad, table 4.8
TRAVEL = 63.0  # rad
BRUSHES = 0.05  # C_r2, N m, table 4.8
EFFICIENCY = 0.8  # assumed: two stages of spur gears and a rack
FRICTION_COEFFICIENT = 0.12  # mu_c, assumed: greased steel
AREA_RATIO = 0.6  # S_m/S_s, assumed: 12.9 mm at the cart are 7.7 mm at the bearing

# Assumed clutch of a small car: height of the diaphragm's free cone (Almen and Laszlo) divided by
# its thickness. Beyond the peak, the force falls to 60 % at the end of the travel.
CONE = 2.1
ENGAGED = 1.2  # deflection divided by the thickness, clutch closed: just before the peak
# travel of the bearing [m] for a deflection of one thickness: 2.25 mm times the lever ratio 3.2
STROKE = 7.2e-3
PEAK = 1200.0  # force of the diaphragm's peak at the bearing, N
CUSHION = 2.5e-3  # travel of the bearing [m] until the cushion disc releases the plate
BEARING_PRELOAD = 80.0  # N, keeps the bearing turning

POINTS = 64  # points of a curve, one per rad
WIDTH = 132  # characters of a line in the file


def cone(deflection: Vector) -> Vector:
    """Return Almen and Laszlo's force of a coned disc, up to a factor, at deflection/thickness."""
    return np.asarray(deflection * ((CONE - deflection) * (CONE - 0.5 * deflection) + 1.0))


def release_force(way: Vector) -> Vector:
    """Return the clutch's force F_c [N]; way [m]: bearing's travel from the closed position."""
    peak = cone(np.array([CONE - np.sqrt((CONE**2 - 2.0) / 3.0)]))[0]
    diaphragm = PEAK * cone(ENGAGED + way / STROKE) / peak
    cushion = (
        PEAK * cone(np.array([ENGAGED]))[0] / peak * np.clip(1.0 - way / CUSHION, 0.0, 1.0) ** 2
    )
    return np.asarray(BEARING_PRELOAD + diaphragm - cushion)


def rotor_torque(theta: Vector) -> tuple[Vector, Vector]:
    """Return the friction C_r [N m] forward and backward at theta [rad] (4.42)."""
    forward, backward = (np.polynomial.Polynomial(c)(theta) for c in (FORWARD, BACKWARD))
    return forward / BETA, backward / BETA


def slideway(theta: Vector) -> tuple[Vector, Vector]:
    """Return friction mu_c F_s1 and residual spring force F_res [N] at the cart at theta [rad]."""
    forward, backward = rotor_torque(theta)
    to_cart = EFFICIENCY / RATIO
    return (0.5 * (forward + backward) - BRUSHES) * to_cart, 0.5 * (forward - backward) * to_cart


def curves() -> dict[str, tuple[Vector, Vector]]:
    """Return name -> (position [m], value) of the three curves.

    The position is that of the cart for the force of s1 [N] and the angle [rad], and that of the
    slave piston for the force of s2 [N].
    """
    theta = np.linspace(0.0, TRAVEL, POINTS)
    x = RATIO * theta
    friction, residual = slideway(theta)
    pressing = friction / FRICTION_COEFFICIENT
    clutch = -release_force(AREA_RATIO * (x[-1] - x))
    return {
        "force": (x, pressing),
        "angle": (x, np.arctan((AREA_RATIO * clutch - residual) / pressing)),
        "clutch": (AREA_RATIO * x, clutch),
    }


def lines(name: str) -> list[str]:
    """Return the lines of a curve in the format of the file, in mm, N and deg."""
    position, value = curves()[name]
    values = (
        [f"{one:.3f}" for one in np.degrees(value)]
        if name == "angle"
        else [f"{one:.1f}" for one in value]
    )
    return [
        *_series("position", "mm", [f"{1e3 * one:.4f}" for one in position]),
        *_series("value", "deg" if name == "angle" else "N", values),
    ]


def _series(key: str, unit: str, numbers: list[str]) -> list[str]:
    text = f"{key}: {{unit: {unit}, values: [{', '.join(numbers)}]}}"
    return textwrap.wrap(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def main() -> int:
    for name in ("force", "angle", "clutch"):
        print(f"{name}:", *(f"  {line}" for line in lines(name)), sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
