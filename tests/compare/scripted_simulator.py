"""A simulator whose laws behave as they are told: what it hands to the criteria is known in closed
form."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from frictool.compare.input_protocol import Segment
from frictool.compare.thesis_tables import PROPERTIES, TABLE_2_1
from frictool.compare.trajectory import LawTrajectory
from frictool.errors import NoSolutionError
from frictool.typing import Vector

Z_MAX = 1e-5


class Told:
    """`stribeck` is rigid and regular; `lugre` drifts, complies and leaks; `hybrid_a` is rigid and
    3 % slow."""

    pace: ClassVar = {"stribeck": 1.0, "lugre": 1.01, "hybrid_a": 1.03}
    wander: ClassVar = {"stribeck": 0.0, "lugre": 86.0, "hybrid_a": 0.0}

    def names(self) -> tuple[str, ...]:
        return tuple(self.pace)

    def title(self, law: str) -> str:
        return law.title()

    def parameters(self, law: str) -> int:
        return 7

    def run(self, law: str, segments: tuple[Segment, ...], samples: int) -> LawTrajectory:
        """Return the scripted trajectory; the duration identifies the test."""
        end = segments[-1][0]
        time, pace = np.linspace(0.0, end, samples), self.pace[law]
        if end == 300.0:
            phase = 2.0 * math.pi * time / (24.0 * pace)
            return LawTrajectory(time, 1.0 + 0.067 * np.sin(phase), np.cos(phase), 0.0 * time, ())
        if end == 60.0:
            edges = 6.5 * pace * np.arange(9) + 1.0
            position = sum(0.65 * np.clip(time - edge, 0.0, 1.0) for edge in edges)
            sticks = tuple(zip([0.0, *(edges + 1.0)], [*edges, end], strict=True))
            return LawTrajectory(time, position, np.gradient(position, time), 0.0 * time, sticks)
        position = self.wander[law] * Z_MAX * time / 97.0
        return LawTrajectory(time, position, np.gradient(position, time), 0.0 * time, ())

    def creep(self, law: str, path: Vector, speed: float) -> Vector | None:
        return None if law != "lugre" else 1.5 * path / Z_MAX - 1e-4 * np.arange(path.size)

    def properties(self, law: str, compliance: bool, drift: LawTrajectory) -> dict[str, str]:
        return dict(zip(PROPERTIES, TABLE_2_1.get(law, TABLE_2_1["coulomb"]), strict=True))


class Failing(Told):
    """As `Told`, but LuGre cannot be simulated."""

    def creep(self, law: str, path: Vector, speed: float) -> Vector | None:
        if law == "lugre":
            raise NoSolutionError("lugre: at 1 s it fails")
        return super().creep(law, path, speed)
