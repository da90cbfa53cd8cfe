"""Dormand and Prince's method of order 8 with the error of order 5 and 3 that Hairer takes: its coefficients, and one step's sums.

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5, II.10. Of the thirteen slopes the last is the next step's first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictool.kernels import inset_kernel

Vector = NDArray[np.float64]

STAGES = 12
TABLEAU_ROWS = (
    (0.05260015195876773,),
    (
        0.0197250569845379,
        0.0591751709536137,
    ),
    (
        0.02958758547680685,
        0.0,
        0.08876275643042054,
    ),
    (
        0.2413651341592667,
        0.0,
        -0.8845494793282861,
        0.924834003261792,
    ),
    (
        0.037037037037037035,
        0.0,
        0.0,
        0.17082860872947386,
        0.12546768756682242,
    ),
    (
        0.037109375,
        0.0,
        0.0,
        0.17025221101954405,
        0.06021653898045596,
        -0.017578125,
    ),
    (
        0.03709200011850479,
        0.0,
        0.0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
    ),
    (
        0.6241109587160757,
        0.0,
        0.0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
    ),
    (
        0.47766253643826434,
        0.0,
        0.0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
    ),
    (
        -0.9371424300859873,
        0.0,
        0.0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
    ),
    (
        2.273310147516538,
        0.0,
        0.0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ),
)
NODES = np.array(
    (
        0.0,
        0.05260015195876773,
        0.0789002279381516,
        0.1183503419072274,
        0.2816496580927726,
        0.3333333333333333,
        0.25,
        0.3076923076923077,
        0.6512820512820513,
        0.6,
        0.8571428571428571,
        1.0,
    )
)
WEIGHTS = np.array(
    (
        0.054293734116568765,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        0.3111643669578199,
        -0.1521609496625161,
        0.20136540080403034,
        0.04471061572777259,
    )
)
ERRORS_5 = np.array(
    (
        0.01312004499419488,
        0.0,
        0.0,
        0.0,
        0.0,
        -1.2251564463762044,
        -0.4957589496572502,
        1.6643771824549864,
        -0.35032884874997366,
        0.3341791187130175,
        0.08192320648511571,
        -0.022355307863886294,
    )
)
ERRORS_3 = np.array(
    (
        -0.18980075407240762,
        0.0,
        0.0,
        0.0,
        0.0,
        4.450312892752409,
        1.8915178993145003,
        -5.801203960010585,
        -0.4226823213237919,
        -0.1521609496625161,
        0.20136540080403034,
        0.02265179219836082,
    )
)
TABLEAU = np.zeros((STAGES, STAGES))
for _stage, _row in enumerate(TABLEAU_ROWS):
    TABLEAU[_stage + 1, : len(_row)] = _row


@inset_kernel
def stage_point(stage: int, h: float, y: Vector, slopes: Vector, point: Vector) -> None:
    """Where the slope of a stage is asked for: y, `point` (n,), slopes (STAGES, n)."""
    for i in range(y.shape[0]):
        point[i] = y[i]
    for j in range(stage):
        weight = h * TABLEAU[stage, j]
        if weight != 0.0:
            for i in range(y.shape[0]):
                point[i] += weight * slopes[j, i]


@inset_kernel
def step_end(h: float, y: Vector, slopes: Vector, point: Vector) -> None:
    """Where the step ends."""
    for i in range(y.shape[0]):
        point[i] = y[i]
    for j in range(STAGES):
        weight = h * WEIGHTS[j]
        if weight != 0.0:
            for i in range(y.shape[0]):
                point[i] += weight * slopes[j, i]


@inset_kernel
def step_errors(h: float, slopes: Vector, fifth: Vector, third: Vector) -> None:
    """The error of each state (II.10.17), h e5^2 / sqrt(e5^2 + e3^2/100), in `fifth` (n,) or longer; `third` as long, to work in."""
    size = slopes.shape[1]
    for i in range(size):
        fifth[i], third[i] = 0.0, 0.0
    for j in range(STAGES):
        weight_5, weight_3 = ERRORS_5[j], ERRORS_3[j]
        if weight_3 != 0.0:
            for i in range(size):
                fifth[i] += weight_5 * slopes[j, i]
                third[i] += weight_3 * slopes[j, i]
    for i in range(size):
        square = fifth[i] * fifth[i]
        total = square + 0.01 * third[i] * third[i]
        fifth[i] = abs(h) * square / np.sqrt(total) if total > 0.0 else 0.0
