"""Friction of the thesis's clutch (tables 4.7 and 4.8, 4.4.2.2)."""

from __future__ import annotations

# breakaway torque [N m] by direction: coefficients of a polynomial in the position [rad], table 4.7
FORWARD = (0.0794, 0.0077, -2.7773e-4, 2.8731e-6)
BACKWARD = (0.0938, -0.0126, 0.0013, -3.2940e-5, 2.5120e-7)
TABLE_4_7 = {1.0: FORWARD, -1.0: BACKWARD}
BETA = 1.1  # breakaway divided by Coulomb friction, table 4.8
KNEE = 260.0  # rad/s, speed from which viscous friction acts
