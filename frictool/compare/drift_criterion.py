"""Drift test (thesis 3.7.5): displacement under a force that stays below the Coulomb friction."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.compare.input_protocol import FREQUENCY
from frictool.compare.trajectory import LawTrajectory

BEGIN, END = 5.0, 102.0  # s, at the same phase of the wave
CYCLES = round((END - BEGIN) * FREQUENCY)
LIMIT = 1.0  # largest displacement without drift, units of z_max


@dataclass(frozen=True)
class DriftResult:
    """Displacement between 5 s and 102 s of the drift test, in SI and relative to z_max.

    z_max is the largest presliding displacement. Both times scale with the test's unit of time,
    which is 1 s for thesis table 3.1.
    """

    displacement: float
    z_max_units: float

    @property
    def verdict(self) -> str:
        """Return `+` (no drift) if the displacement is below z_max, else `-`."""
        return "+" if self.z_max_units < LIMIT else "-"


def measure(run: LawTrajectory, presliding: float, time_unit: float) -> DriftResult:
    """Return the displacement in the drift test.

    `presliding`: largest presliding displacement z_max [m | rad].
    `time_unit`: unit of time of the test [s].
    """
    moved = abs(run.at(END * time_unit) - run.at(BEGIN * time_unit))
    return DriftResult(moved, moved / presliding)
