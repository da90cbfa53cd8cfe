"""One step of the Dormand-Prince method 5(4) with dense output, for x' = v, v' = a, q' = x - r.

x is the position, v the velocity, a the acceleration, r the reference, and q the integral of x - r.
Coefficients: Dormand, Prince 1980; dense output: Hairer, Norsett, Wanner, Solving Ordinary
Differential Equations I, II.6.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from frictool.engine.drive import effort, reference
from frictool.runtime.kernels import bare_kernel
from frictool.typing import Vector

Force = Callable[[float, float, Vector], float]

STAGES = 7
# y(t0 + c_i h) = y0 + h sum_j a_ij k_j, written out below so that the compiler keeps all in
# registers
C2 = 1 / 5
C3 = 3 / 10
C4 = 4 / 5
C5 = 8 / 9
A21 = 1 / 5
A31, A32 = 3 / 40, 9 / 40
A41, A42, A43 = 44 / 45, -56 / 15, 32 / 9
A51 = 19372 / 6561
A52 = -25360 / 2187
A53 = 64448 / 6561
A54 = -212 / 729
A61 = 9017 / 3168
A62 = -355 / 33
A63 = 46732 / 5247
A64 = 49 / 176
A65 = -5103 / 18656
A71 = 35 / 384
A73 = 500 / 1113
A74 = 125 / 192
A75 = -2187 / 6784
A76 = 11 / 84
E1 = 71 / 57600
E3 = -71 / 16695
E4 = 71 / 1920
E5 = -17253 / 339200
E6 = 22 / 525
E7 = -1 / 40
# y(t0 + s h) = y0 + h sum_i k_i (DENSE[i][0] s + DENSE[i][1] s^2
#                                 + DENSE[i][2] s^3 + DENSE[i][3] s^4)
DENSE = (
    (1.0, -8048581381 / 2820520608, 8663915743 / 2820520608, -12715105075 / 11282082432),
    (0.0, 0.0, 0.0, 0.0),
    (0.0, 131558114200 / 32700410799, -68118460800 / 10900136933, 87487479700 / 32700410799),
    (0.0, -1754552775 / 470086768, 14199869525 / 1410260304, -10690763975 / 1880347072),
    (0.0, 127303824393 / 49829197408, -318862633887 / 49829197408, 701980252875 / 199316789632),
    (0.0, -282668133 / 205662961, 2019193451 / 616988883, -1453857185 / 822651844),
    (0.0, 40617522 / 29380423, -110615467 / 29380423, 69997945 / 29380423),
)
B = np.array(DENSE)
# the same coefficients as tables, for systems of any size
NODES = np.array((0.0, C2, C3, C4, C5, 1.0, 1.0))
TABLEAU = np.array(
    (
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (A21, 0.0, 0.0, 0.0, 0.0, 0.0),
        (A31, A32, 0.0, 0.0, 0.0, 0.0),
        (A41, A42, A43, 0.0, 0.0, 0.0),
        (A51, A52, A53, A54, 0.0, 0.0),
        (A61, A62, A63, A64, A65, 0.0),
        (A71, 0.0, A73, A74, A75, A76),
    )
)
ERRORS = np.array((E1, 0.0, E3, E4, E5, E6, E7))


class _Slip(NamedTuple):
    force: Force
    law: Vector
    mobility: float
    direction: float
    drive: Vector


@bare_kernel
def _rate(slip: _Slip, t: float, x: float, v: float, q: float) -> float:
    force, law, mobility, direction, drive = slip
    return (effort(t, x, v, q, drive) - force(v, direction, law)) * mobility


@bare_kernel
def fill_row(row: Vector, k: tuple[float, float, float, float, float, float, float]) -> None:
    """Copy the seven derivatives k, one for each stage of a step, to `row` (7,)."""
    row[0], row[1], row[2], row[3], row[4], row[5], row[6] = k


@bare_kernel
def layer_step(
    force: Force,
    law: Vector,
    mass: float,
    direction: float,
    drive: Vector,
    t: float,
    h: float,
    start: float,
    y: Vector,
    slopes: Vector,
) -> float:
    """Try one step of length h from y = (x, v, q) at time t; return the error of v [m/s | rad/s].

    start: acceleration at t. Fills slopes (3, 7) with x', v', q' at the stages. The friction
    `force(v, direction, law)` opposes the motion.
    """
    x, v, q = y[0], y[1], y[2]
    v1 = v
    slip = _Slip(force, law, 1.0 / mass, direction, drive)
    a1 = start
    e1 = x - reference(t, drive)
    v2 = v + h * A21 * a1
    x2 = x + h * A21 * v1
    e2 = x2 - reference(t + C2 * h, drive)
    a2 = _rate(slip, t + C2 * h, x2, v2, q + h * A21 * e1)
    v3 = v + h * (A31 * a1 + A32 * a2)
    x3 = x + h * (A31 * v1 + A32 * v2)
    e3 = x3 - reference(t + C3 * h, drive)
    a3 = _rate(slip, t + C3 * h, x3, v3, q + h * (A31 * e1 + A32 * e2))
    v4 = v + h * (A41 * a1 + A42 * a2 + A43 * a3)
    x4 = x + h * (A41 * v1 + A42 * v2 + A43 * v3)
    e4 = x4 - reference(t + C4 * h, drive)
    a4 = _rate(slip, t + C4 * h, x4, v4, q + h * (A41 * e1 + A42 * e2 + A43 * e3))
    v5 = v + h * (A51 * a1 + A52 * a2 + A53 * a3 + A54 * a4)
    x5 = x + h * (A51 * v1 + A52 * v2 + A53 * v3 + A54 * v4)
    e5 = x5 - reference(t + C5 * h, drive)
    a5 = _rate(slip, t + C5 * h, x5, v5, q + h * (A51 * e1 + A52 * e2 + A53 * e3 + A54 * e4))
    v6 = v + h * (A61 * a1 + A62 * a2 + A63 * a3 + A64 * a4 + A65 * a5)
    x6 = x + h * (A61 * v1 + A62 * v2 + A63 * v3 + A64 * v4 + A65 * v5)
    e6 = x6 - reference(t + h, drive)
    a6 = _rate(slip, t + h, x6, v6, q + h * (A61 * e1 + A62 * e2 + A63 * e3 + A64 * e4 + A65 * e5))
    v7 = v + h * (A71 * a1 + A73 * a3 + A74 * a4 + A75 * a5 + A76 * a6)
    x7 = x + h * (A71 * v1 + A73 * v3 + A74 * v4 + A75 * v5 + A76 * v6)
    e7 = x7 - reference(t + h, drive)
    a7 = _rate(slip, t + h, x7, v7, q + h * (A71 * e1 + A73 * e3 + A74 * e4 + A75 * e5 + A76 * e6))
    fill_row(slopes[0], (v1, v2, v3, v4, v5, v6, v7))
    fill_row(slopes[1], (a1, a2, a3, a4, a5, a6, a7))
    fill_row(slopes[2], (e1, e2, e3, e4, e5, e6, e7))
    return abs(h * (E1 * a1 + E3 * a3 + E4 * a4 + E5 * a5 + E6 * a6 + E7 * a7))


@bare_kernel
def dense_output(y: Vector, slopes: Vector, h: float, piece: Vector) -> None:
    """Fill the first 5 columns of `piece` with the coefficients of the step's dense output.

    The polynomials are functions of the time since the step's start. `piece` and `slopes` (rows, 7)
    have one row for each state.
    """
    for row in range(slopes.shape[0]):
        piece[row, 0] = y[row]
        power = 1.0
        for k in range(4):
            total = 0.0
            for i in range(STAGES):
                total += B[i, k] * slopes[row, i]
            piece[row, k + 1] = total / power
            power *= h


@bare_kernel
def stage_point(stage: int, h: float, y: Vector, slopes: Vector, point: Vector) -> None:
    """Fill `point` (n,) with the state at which the derivatives of a stage are evaluated.

    - y (n,): state at the start of the step
    - slopes (7, n): derivatives of the earlier stages
    """
    for row in range(y.shape[0]):
        total = 0.0
        for j in range(stage):
            total += TABLEAU[stage, j] * slopes[j, row]
        point[row] = y[row] + h * total


@bare_kernel
def local_error(row: int, h: float, slopes: Vector) -> float:
    """Return the estimated local error (>= 0) of the variable in row `row` of `slopes`."""
    total = 0.0
    for i in range(STAGES):
        total += ERRORS[i] * slopes[i, row]
    return abs(h * total)
