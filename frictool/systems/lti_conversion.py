"""The systems of python-control and scipy as frictool's own."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import signal

from frictool.errors import FrictoolError
from frictool.plant.lti import Lti, tustin

SAME_PERIOD = 1e-9  # relative


def as_lti(system: Any, period: float) -> Lti:
    """A system of one input and one output at `period` [s]: of python-control (StateSpace,
    TransferFunction), of scipy.signal, or an Lti.

    A continuous one is discretised by Tustin. Raises FrictoolError where it has more inputs or
    outputs, another period, or is improper.
    """
    a, b, c, d, dt = _matrices(system)
    n = len(a)
    if d.shape != (1, 1):
        raise FrictoolError(
            f"the system has {d.shape[1]} inputs and {d.shape[0]} outputs; allowed: one of each"
        )
    if not all(np.all(np.isfinite(matrix)) for matrix in (a, b, c, d)):
        raise FrictoolError("the system has coefficients that are not finite")
    if not dt:
        return tustin(Lti(a.reshape(n, n), b.reshape(n, 1), c.reshape(1, n), d, 0.0), period)
    if dt is not True and abs(dt / period - 1.0) > SAME_PERIOD:
        raise FrictoolError(
            f"the system is sampled at {dt:g} s; allowed: continuous, or the bench's period of {period:g} s"
        )
    return Lti(a.reshape(n, n), b.reshape(n, 1), c.reshape(1, n), d, period)


def _matrices(system: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Any]:
    """a, b, c, d and the period, None or 0 for continuous time."""
    if isinstance(system, Lti):
        return system.a, system.b, system.c, system.d, system.period
    if hasattr(system, "num_list"):  # a TransferFunction of python-control, read without it
        if (system.ninputs, system.noutputs) != (1, 1):
            raise FrictoolError(
                f"the system has {system.ninputs} inputs and {system.noutputs} outputs; allowed: one of each"
            )
        return (*_space(system.num_list[0][0], system.den_list[0][0]), system.dt)
    if hasattr(system, "to_tf") and not hasattr(system, "A"):  # scipy's in another form
        transfer = system.to_tf()
        return (*_space(np.atleast_2d(transfer.num)[0], transfer.den), system.dt)
    missing = [name for name in "ABCD" if not hasattr(system, name)]
    if missing:
        raise FrictoolError(
            f"a {type(system).__name__} is no linear system; allowed: those of python-control and scipy.signal, or an Lti"
        )
    a, b, c, d = (
        np.atleast_2d(np.asarray(getattr(system, name), dtype=np.float64)) for name in "ABCD"
    )
    return a, b, c, d, getattr(system, "dt", None)


def _space(
    numerator: ArrayLike, denominator: ArrayLike
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A transfer function's state space. Raises FrictoolError where it is improper."""
    above, below = (
        np.trim_zeros(np.asarray(numerator), "f"),
        np.trim_zeros(np.asarray(denominator), "f"),
    )
    if len(above) > len(below):
        raise FrictoolError(
            "the system is improper: its numerator is of a higher order than its denominator; filter its derivative"
        )
    a, b, c, d = signal.tf2ss(above if len(above) else [0.0], below)
    return a, b, c, d
