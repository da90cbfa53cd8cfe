"""Bound that is proved for every constant plant of a box (zero_exclusion.py)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from frictool.documents.certificate import Bound


@dataclass(frozen=True)
class ProvedBound:
    """Proved bound: for all constant plants of a certificate the loop is stable and `of` < `below`.

    of: quantity, norm or sensitivity. cells: number of cells (intervals of frequency and plant) in
    the proof.
    """

    of: Literal["norm", "sensitivity"]
    below: float
    cells: int

    @property
    def modulus_margin(self) -> float | None:
        """Return the modulus margin that this bound proves; None if the bound is of a norm."""
        return Bound(self.of, self.below).modulus_margin
