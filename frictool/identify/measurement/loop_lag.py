"""Time constant of the current loop, from commanded and measured current.

    lag i' = command - i
    i[k+1] = a i[k] + (1 - a) command[k],    a = e^(-period/lag)

i is the current, and k the number of the row. The command of a row is held until the next row. The
measured current is gain i + offset + noise. Because i is simulated from the command (output error),
the noise need not be white. The interval of the lag comes from a jackknife over parts of the
record.
"""

from __future__ import annotations

import numpy as np
import scipy

from frictool.identify.fit_result import Interval, UnusableLogs
from frictool.identify.regression.brent_minimum import bounded_minimum
from frictool.identify.regression.regression import SingularRegressors, solve
from frictool.typing import Vector

PARTS = 30  # number of parts of the record, each left out in turn
SHORTEST, LONGEST = 0.25, 500.0  # bounds of the lag, in sample periods
LARGEST_ERROR = 0.3  # largest residual relative to the measured current's standard deviation
SURE = 3.0  # least distance of the lag from 0, in standard deviations


def loop_lag(command: Vector, measured: Vector, period: float, confidence: float) -> Interval:
    """Return the time constant [s] of a current loop from commanded and measured current (n,), A.

    `period` is the sample period [s]. Raises UnusableLogs if the currents do not determine the time
    constant.
    """
    if command.size < 10 * PARTS or float(np.ptp(command)) == 0.0:
        raise UnusableLogs(
            "the commanded current does not change, or the record is too short to "
            "determine the lag of the current loop; record longer, with changes of the command"
        )
    if np.array_equal(command, measured):
        raise UnusableLogs(
            "commanded and measured current are identical; log the current that a sensor measures"
        )

    def squares(logarithm: float) -> float:
        return float(np.sum(_left(np.exp(logarithm), command, measured, period)[0] ** 2))

    logarithms = np.linspace(np.log(SHORTEST * period), np.log(LONGEST * period), 60)
    near = logarithms[int(np.argmin([squares(logarithm) for logarithm in logarithms]))]
    step = logarithms[1] - logarithms[0]
    lag = float(np.exp(bounded_minimum(squares, near - step, near + step, 1e-6)))
    residual, columns = _left(lag, command, measured, period)
    error = float(np.std(residual)) / float(np.std(measured))
    if error > LARGEST_ERROR:
        raise UnusableLogs(
            f"a first-order lag of the current loop leaves {100.0 * error:.3g} % of the current "
            f"unexplained (allowed: at most {100 * LARGEST_ERROR:g} %)"
        )
    gain = float(np.linalg.lstsq(columns, measured, rcond=None)[0][0])
    moved = (
        gain
        * (_current(lag * 1.001, command, period) - _current(lag / 1.001, command, period))
        / (0.002 * lag)
    )
    parts = np.arange(command.size) * PARTS // command.size
    try:
        solution = solve(np.column_stack((columns, moved)), measured, np.ones(command.size), parts)
    except SingularRegressors as fault:
        raise UnusableLogs(f"the current does not determine the lag of the loop: {fault}") from None
    half = float(solution.half_width(confidence)[-1])
    if lag < 1.1 * SHORTEST * period or lag < SURE * float(solution.deviation[-1]):
        raise UnusableLogs(
            f"with a sample period of {period:g} s, the lag of the current loop is too short to be "
            f"measured: {lag:.3g} s, +-{half:.3g} s; log at a higher rate"
        )
    return Interval.around(lag, half, 0.0)


def _current(lag: float, command: Vector, period: float) -> Vector:
    a = float(np.exp(-period / lag))
    return np.asarray(
        command[0] + scipy.signal.lfilter([0.0, 1.0 - a], [1.0, -a], command - command[0])
    )


def _left(lag: float, command: Vector, measured: Vector, period: float) -> tuple[Vector, Vector]:
    """Return the residual current (n,), and the regressors (n, 2) (simulated current and 1)."""
    columns = np.column_stack((_current(lag, command, period), np.ones(command.size)))
    return measured - columns @ np.linalg.lstsq(columns, measured, rcond=None)[0], columns
