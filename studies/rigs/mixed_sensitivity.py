"""Random mixed-sensitivity problems of even order >= 4: an axis with drive lag and flexible modes.

    r ──▶(+)──▶ e = y ──▶ W_S ──▶ z1
          ▲ -                                u ──▶ W_KS ──▶ z2
          └── position ◀── G ◀──(+)◀── u
                                 ▲
                                 └── LOAD * d

G = 1/(lag s + 1) * sum over the modes of share w^2/(s^2 + 2 damping w s + w^2). One slow mode
carries most of the motion; (order - 4)/2 flexible modes are above it, drawn with numpy's
default_rng(seed + order). The unit of time is 1/bandwidth. D12 and D21 have full rank and no zero
is on the imaginary axis, so that SLICOT's Riccati equations apply and must give the same optimum.
"""

from __future__ import annotations

import numpy as np

from frictool.plant.generalised_plant import GeneralisedPlant

ORDERS = tuple(range(4, 21, 2))
SEED = 2024
LAG, DAMPING = 0.05, 0.02
ERROR_LOW, ERROR_HIGH, ERROR_CORNER = (
    100.0,
    0.5,
    0.7,
)  # W_S: gain at rest, gain above the bandwidth, where it crosses one
COMMAND, LOAD = 0.1, 0.1


def mixed_sensitivity(order: int, seed: int = SEED) -> GeneralisedPlant:
    """Return the problem of the even `order` >= 4.

    Its states are W_S, the lag, then position and speed of each mode.
    """
    random = np.random.default_rng(seed + order)
    modes = (order - 2) // 2
    frequencies = np.concatenate([[0.3], np.sort(random.uniform(2.0, 12.0, modes - 1))])
    shares = np.concatenate(
        [[1.0], random.uniform(0.01, 0.1, modes - 1) * random.choice([-1.0, 1.0], modes - 1)]
    )
    a, b2, position = np.zeros((order, order)), np.zeros((order, 1)), np.zeros((1, order))
    pole = ERROR_CORNER / ERROR_LOW
    a[0, 0], a[1, 1], b2[1, 0] = -pole, -1.0 / LAG, 1.0 / LAG
    for k, (w, share) in enumerate(zip(frequencies, shares, strict=True)):
        x, v = 2 + 2 * k, 3 + 2 * k
        a[x, v], a[v, x], a[v, v], a[v, 1] = (
            1.0,
            -(w**2),
            -2.0 * (0.5 if k == 0 else DAMPING) * w,
            w**2,
        )
        position[0, x] = share
    a[0] -= pole * (ERROR_LOW - ERROR_HIGH) * position[0]
    b1 = np.zeros((order, 2))
    b1[0, 0], b1[1, 1] = pole * (ERROR_LOW - ERROR_HIGH), LOAD / LAG
    c1 = np.vstack([np.eye(order)[0] - ERROR_HIGH * position[0], np.zeros(order)])
    d11 = np.array([[ERROR_HIGH, 0.0], [0.0, 0.0]])
    return GeneralisedPlant(
        a, b1, b2, c1, -position, d11, np.array([[0.0], [COMMAND]]), np.array([[1.0, 0.0]]), 0.0
    )
