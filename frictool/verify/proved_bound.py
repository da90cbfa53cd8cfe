"""Bound that is proved for every constant plant in a box of parameters (zero_exclusion.py)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from frictool.documents.certificate import Bound


@dataclass(frozen=True)
class ProvedBound:
    """Proved bound of a norm or of the sensitivity for all constant plants of a certificate.

    - of: bounded quantity
    - below: upper bound of this quantity; the proof includes stability of the loop
    - cells: number of cells (intervals of frequency and plant) in the proof
    """

    of: Literal["norm", "sensitivity"]
    below: float
    cells: int

    @property
    def modulus_margin(self) -> float | None:
        """Return the modulus margin that a sensitivity bound proves; None for a norm bound."""
        return Bound(self.of, self.below).modulus_margin
