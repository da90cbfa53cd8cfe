"""Filters that differ in how far friction over speed may be from the model's, weighed by how well each has foreseen the moves.

    UNMODELLED ──restriction.py──▶ filters ──evidence of each move──▶ weights ──▶ mean and deviation of the mixture

A slope of friction over speed that the model has not looks much like wear on moves that are all alike. Excluded beforehand it costs no
precision and biases the wear of a plant that has it; left open it costs three times the precision on a plant that has not. Here the moves
say which of the two it is, and until they do the interval holds both. A slope is positive, as all viscous friction is, and the less of it,
the likelier beforehand. Moves that repeat each other repeat the errors of the encoder's counts: their evidence counts for EVIDENCE,
and is forgotten in MEMORY moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.observe.wear.change import Change
from frictool.observe.wear.filter import Filter
from frictool.observe.wear.moves import Move
from frictool.observe.wear.restriction import Restriction, Unmodelled

Vector = NDArray[np.float64]

SLOPES = (0.003, 0.03, 0.1, 0.3, 1.0)  # of the dry friction at top speed
BEFOREHAND = (0.0, -2.0, -3.0, -4.0, -5.0)  # natural logarithms of how likely each is
UNMODELLED = tuple(Unmodelled(slope, 0.5 * slope, 0.3 * slope) for slope in SLOPES)
EVIDENCE = 0.5
MEMORY = 50.0  # moves, over which it is kept


class Bank:
    """Filters of the same parameters, one of which, `name`, walks by `walk` a move, and further where it has changed.

    restrictions: one for each of UNMODELLED, in that order.
    """

    def __init__(self, restrictions: Sequence[Restriction], variance: float, inflation: float, name: str, walk: float) -> None:
        self.filters = tuple(Filter(one, variance, inflation) for one in restrictions)
        self._changes, self._name, self._walk = tuple(Change(name) for _ in self.filters), name, walk
        self._evidence = np.zeros(len(self.filters))

    @property
    def weights(self) -> Vector:
        """Of each filter, their sum 1."""
        likely = np.array(BEFOREHAND) + self._evidence
        over = np.exp(likely - np.max(likely))
        return np.asarray(over / np.sum(over))

    def take(self, move: Move) -> bool:
        """Takes a move; whether it tells, with those before it, that the parameter has changed."""
        changed = [change.seen(own, move) for own, change in zip(self.filters, self._changes, strict=True)]
        for own, walked in zip(self.filters, changed, strict=True):
            own.walk(self._name, math.hypot(self._walk, walked))
        noise = min(own.noise for own in self.filters)
        foreseen = np.array([EVIDENCE * own.evidence(move, noise) for own in self.filters])
        self._evidence = (1.0 - 1.0 / MEMORY) * self._evidence + foreseen - np.max(foreseen)
        for own in self.filters:
            own.update(move)
        return changed[int(np.argmax(self.weights))] > 0.0

    def value(self, name: str) -> tuple[float, float]:
        """A parameter's mean and deviation [SI]."""
        values, deviations = np.array([own.value(name) for own in self.filters]).T
        mean = float(self.weights @ values)
        return mean, math.sqrt(float(self.weights @ (deviations**2 + (values - mean) ** 2)))
