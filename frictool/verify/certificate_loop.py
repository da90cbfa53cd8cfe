"""Closed loop of a certificate: its plant is that of generalised_plant.py, with stored numbers.

The sampled axis is that of linear_axis.py with the computational delay before it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from frictool.documents.certificate import CertifiedWeights, Filter
from frictool.documents.controller import StateSpace

SENSITIVITY = CertifiedWeights(
    error=Filter(1.0), disturbance=0.0, drive=0.0
)  # with controlled position: (5.54)


@dataclass(frozen=True)
class CertificateLoop:
    """Data of the loop that are the same for every plant; `period` and `lag` in s.

    `sections` replace the controller's matrices if the target runs sections. Each is b0 b1 b2 a0 a1
    a2 with a0 = 1, as stored.
    """

    controller: StateSpace
    controlled: Literal["position", "speed"]
    delay: int
    lag: float
    period: float
    weights: CertifiedWeights
    sections: tuple[tuple[float, ...], ...] = ()


def quantity_loop(loop: CertificateLoop, of: Literal["norm", "sensitivity"]) -> CertificateLoop:
    """Return the loop whose norm is the quantity `of`.

    For the sensitivity this is the unweighted position loop, from s to s - position.
    """
    if of == "norm":
        return loop
    return replace(loop, controlled="position", weights=SENSITIVITY)
