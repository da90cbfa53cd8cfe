"""One step of a Rosenbrock method of order 4, with an error estimate of order 3 and dense output.

    W k_i = f(t + c_i h, y + sum_j A_ij k_j) + sum_j C_ij k_j/h + h d_i f_t
    W = I/(gamma h) - J

y' = f(t, y), f_t is the derivative of f with respect to time, J the Jacobian, h the step length,
and k_i stage i. The method is L-stable: after a contact has relaxed, which takes microseconds, only
the motion limits the step length. Coefficients: RODAS, Hairer, Wanner, Solving Ordinary
Differential Equations II, VI.4. The state is y = (x, v, q, z...) of engine/dynamic_law_motion.py:

    x' = v        v' = (u(t, x, v, q) - F(v, z))/m        q' = x - r        z_i' = rate(z_i, v)

z_i' depends only on z_i and v, so that J is an arrowhead matrix.
"""

from __future__ import annotations

import numpy as np

from frictool.runtime.kernels import kernel
from frictool.typing import Vector

CONTACT = 3  # index of the first z in y
STAGES = 6
GAMMA = 0.25
NODES = np.array((0.0, 0.386, 0.21, 0.63, 1.0, 1.0))
IN_TIME = np.array((0.25, -0.1043, 0.1035, -0.03620000000000023, 0.0, 0.0))
A = np.array(
    (
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (1.544, 0.0, 0.0, 0.0, 0.0),
        (0.9466785280815826, 0.2557011698983284, 0.0, 0.0, 0.0),
        (3.314825187068521, 2.896124015972201, 0.9986419139977817, 0.0, 0.0),
        (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 0.0),
        (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0),
    )
)
C = np.array(
    (
        (0.0, 0.0, 0.0, 0.0, 0.0),
        (-5.6688, 0.0, 0.0, 0.0, 0.0),
        (-2.430093356833875, -0.2063599157091915, 0.0, 0.0, 0.0),
        (-0.1073529058151375, -9.594562251023355, -20.47028614809616, 0.0, 0.0),
        (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160, 0.0),
        (
            8.083246795921522,
            -7.981132988064893,
            -31.52159432874371,
            16.31930543123136,
            -6.058818238834054,
        ),
    )
)
DENSE = np.array(
    (
        (
            10.12623508344586,
            -7.487995877610167,
            -34.80091861555747,
            -7.992771707568823,
            1.025137723295662,
        ),
        (
            -0.6762803392801253,
            6.087714651680015,
            16.43084320892478,
            24.76722511418386,
            -6.594389125716872,
        ),
    )
)


@kernel
def stage_point(y: Vector, stages: Vector, i: int, rows: int, out: Vector) -> None:
    """Fill the first `rows` elements of out (n,) with the point at which stage i evaluates y'.

    - y: state at the start of the step
    - stages: results k of the earlier stages
    """
    for row in range(rows):
        total = y[row]
        for j in range(i):
            total += A[i, j] * stages[j, row]
        out[row] = total


@kernel
def complete_stage(
    gains: Vector, couplings: Vector, in_time: Vector, h: float, i: int, stages: Vector
) -> None:
    """Replace row i of `stages`, which contains y' at the stage's point, by the stage's result k_i.

    - gains (3,): -dv'/d(x, v, q)
    - couplings (3, m): dz'/dv, dz'/dz, -dv'/dz of the m elements of z that follow differential
      equations
    - in_time (3,): d(x', v', q')/dt
    """
    m = couplings.shape[1]
    k = stages[i]
    c = 1.0 / (GAMMA * h)
    for row in range(CONTACT + m):
        total = k[row]
        for j in range(i):
            total += C[i, j] / h * stages[j, row]
        k[row] = total + (h * IN_TIME[i] * in_time[row] if row < CONTACT else 0.0)
    weight = c + gains[1] + (gains[0] + gains[2] / c) / c
    right = k[1] - (gains[0] * k[0] + gains[2] * (k[2] + k[0] / c)) / c
    for j in range(m):
        share = couplings[2, j] / (c - couplings[1, j])
        weight += share * couplings[0, j]
        right -= share * k[CONTACT + j]
    k[1] = right / weight
    k[0] = (k[0] + k[1]) / c
    k[2] = (k[2] + k[0]) / c
    for j in range(m):
        k[CONTACT + j] = (k[CONTACT + j] + couplings[0, j] * k[1]) / (c - couplings[1, j])


@kernel
def between(y: Vector, end: Vector, stages: Vector, share: float, rows: int, out: Vector) -> None:
    """Fill `rows` elements of `out` with the dense output of a step at the time fraction `share`.

    y, end: states at the start (`share` 0) and at the end of the step (`share` 1).
    """
    left = 1.0 - share
    for row in range(rows):
        bend, twist = 0.0, 0.0
        for j in range(STAGES - 1):
            bend += DENSE[0, j] * stages[j, row]
            twist += DENSE[1, j] * stages[j, row]
        out[row] = left * y[row] + share * (end[row] + left * (bend + share * twist))
