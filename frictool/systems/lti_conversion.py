"""Conversion of linear systems from and to python-control and scipy.

python-control is an optional dependency and imported only here, in `to_control`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from frictool.documents.controller import Controller
from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.plant.lti import Lti, tustin
from frictool.systems.document_systems import DRIVE, ETA, POSITION, as_linear_system

SAME_PERIOD = 1e-9  # relative tolerance of equal sample periods


def as_lti(system: Any, period: float) -> Lti:
    """Return a system with one input and one output as an `Lti` with a sample period.

    Parameters
    ----------
    system : Any
        System of python-control (StateSpace, TransferFunction), of scipy.signal, or an `Lti`. A
        continuous system is discretised by Tustin's method.
    period : float
        Sample period [s].

    Returns
    -------
    Lti
        The sampled system, a (n, n), b (n, 1), c (1, n), d (1, 1).

    Raises
    ------
    FrictoolError
        If `system` is not a linear system, is improper, has several inputs or outputs, has a
        sample period other than `period`, or has coefficients that are not finite.
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
            f"the system is sampled at {dt:g} s; allowed: continuous, or the sample period "
            f"of {period:g} s"
        )
    return Lti(a.reshape(n, n), b.reshape(n, 1), c.reshape(1, n), d, period)


def _matrices(system: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Any]:
    if isinstance(system, Lti):
        return system.a, system.b, system.c, system.d, system.period
    if hasattr(system, "num_list"):  # TransferFunction of python-control, without its import
        if (system.ninputs, system.noutputs) != (1, 1):
            raise FrictoolError(
                f"the system has {system.ninputs} inputs and {system.noutputs} outputs; "
                "allowed: one of each"
            )
        return (*_space(system.num_list[0][0], system.den_list[0][0]), system.dt)
    if hasattr(system, "to_tf") and not hasattr(system, "A"):  # scipy system without matrices
        transfer = system.to_tf()
        return (*_space(np.atleast_2d(transfer.num)[0], transfer.den), system.dt)
    missing = [name for name in "ABCD" if not hasattr(system, name)]
    if missing:
        raise FrictoolError(
            f"a {type(system).__name__} is not a linear system; allowed: systems of python-control "
            "and scipy.signal, or an Lti"
        )
    a, b, c, d = (
        np.atleast_2d(np.asarray(getattr(system, name), dtype=np.float64)) for name in "ABCD"
    )
    return a, b, c, d, getattr(system, "dt", None)


def _space(
    numerator: ArrayLike, denominator: ArrayLike
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    above, below = (
        np.trim_zeros(np.asarray(numerator), "f"),
        np.trim_zeros(np.asarray(denominator), "f"),
    )
    if len(above) > len(below):
        raise FrictoolError(
            "the system is improper: the order of its numerator exceeds the order of its "
            "denominator; add a low-pass filter"
        )
    a, b, c, d = scipy.signal.tf2ss(above if len(above) else [0.0], below)
    return a, b, c, d


def to_control(system: Lti | Model | Controller) -> Any:
    """Return a `control.StateSpace` of a controller, a model or a system.

    Parameters
    ----------
    system : Lti, Model or Controller
        A controller is converted to its sampled linear controller, from the position error eta to
        the drive [A | V]. A model is converted to its axis in continuous time, from the drive to
        the position [rad | m].

    Returns
    -------
    control.StateSpace
        The system. If it comes from a Model or a Controller, inputs and outputs have names.

    Raises
    ------
    FrictoolError
        If `system` has another type.
    ImportError
        If python-control is not installed; the message says how to install it.
    """
    try:
        import control
    except ImportError as error:
        raise ImportError(
            "to_control needs python-control: pip install 'frictool[control]'"
        ) from error
    lti = as_linear_system(system)
    names = dict[str, Any]()
    if isinstance(system, Controller):
        names = {"inputs": [ETA], "outputs": [DRIVE], "name": system.name}
    elif isinstance(system, Model):
        names = {"inputs": [DRIVE], "outputs": [POSITION], "name": system.name}
    return control.ss(lti.a, lti.b, lti.c, lti.d, lti.period, **names)


def to_scipy(system: Lti | Model | Controller) -> Any:
    """Return a `scipy.signal.StateSpace` of a controller, a model or a system.

    Parameters
    ----------
    system : Lti, Model or Controller
        A controller or a model is converted to the same system as in `to_control`.

    Returns
    -------
    scipy.signal.StateSpace
        The system, with `dt` [s] if it is sampled.

    Raises
    ------
    FrictoolError
        If `system` has another type.
    """
    lti = as_linear_system(system)
    matrices = (lti.a, lti.b, lti.c, lti.d)
    return (
        scipy.signal.StateSpace(*matrices, dt=lti.period)
        if lti.period
        else scipy.signal.StateSpace(*matrices)
    )
