"""Matrices of a mode (thesis 6.18, 6.25), with the states position, speed and wear alpha.

    moving in direction s   A = [1 T 0; 0 1 - T viscous/J -s T c/J; 0 0 1]
                            B = [0; T/J; 0]   Q = [0; T d/J; 0]   C = [1 0 0]
    stuck                   A = [1 T 0; 0 h 0; 0 0 1]
                            B = 0             Q = 0               C = [1 0 0; 0 0 1]

    multiplicative   friction alpha f, so that c = f_m(i) and d = Delta_f(i)       (thesis 6.13)
    additive         friction f + alpha, so that c = 1 and d = 1                   (thesis 6.20)

Q is the input matrix of the model error, T the period, J the inertia, f the friction without wear,
f_m(i) and Delta_f(i) the mean and the deviation of f in interval i. Each sample in mode 0 (stuck)
multiplies the estimated speed by h (0 to 1). The model is discretised by Euler's method.
docs/theory/observers.md lists the entries that differ from the thesis.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from frictool.documents.observer import Observer
from frictool.lmi.switched_observer_gains import ObserverMode


@dataclass(frozen=True)
class ModeConstants:
    """Constants that all modes of an observer have in common, in SI units.

    - wear: kind of wear that the observer estimates
    - viscous: coefficient of the viscous friction
    - stuck_speed: factor h by which each sample of mode 0 (stuck) multiplies the estimated speed
    - weights: weights of the errors of position, speed and wear, the diagonal of C-bar
    """

    wear: Literal["multiplicative", "additive"]
    period: float
    inertia: float
    viscous: float
    stuck_speed: float
    weights: tuple[float, float, float]

    @staticmethod
    def of(observer: Observer) -> ModeConstants:
        """Return the constants of a switched observer; raise ValueError for other observers."""
        switched = observer.switched
        if switched is None:
            raise ValueError("the observer is not a switched observer")
        inertia, viscous = observer.inertia.value, observer.friction.viscous
        return ModeConstants(
            switched.wear,
            observer.sample_period_s,
            inertia,
            viscous,
            switched.stuck_speed,
            switched.weights,
        )


def subsystem(
    facts: ModeConstants, direction: int, friction: float, deviation: float
) -> ObserverMode:
    """Return A (3, 3), C (1 or 2, 3), Q (3, 1) and C-bar (3, 3) of a mode (module docstring).

    - direction: direction s of the motion, 1 or -1; 0 for the stuck mode
    - friction, deviation: f_m(i) and Delta_f(i) in the position interval of the mode [N m | N]
    """
    gain = facts.period / facts.inertia
    a = np.array([[1.0, facts.period, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    weight = np.diag(facts.weights)
    if direction == 0:
        a[1, 1] = facts.stuck_speed
        return ObserverMode(
            a, np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), np.zeros((3, 1)), weight
        )
    coupling, entering = (friction, deviation) if facts.wear == "multiplicative" else (1.0, 1.0)
    a[1, 1] -= gain * facts.viscous
    a[1, 2] = -direction * gain * coupling
    return ObserverMode(
        a, np.array([[1.0, 0.0, 0.0]]), np.array([[0.0], [gain * entering], [0.0]]), weight
    )


def subsystems(observer: Observer) -> dict[int, ObserverMode]:
    """Return the matrices of each mode of a switched observer.

    Raises ValueError for other observers.
    """
    facts = ModeConstants.of(observer)
    switched = observer.switched
    assert switched is not None
    return {
        mode.index: subsystem(facts, mode.direction, mode.friction, mode.deviation)
        for mode in switched.modes
    }
