"""The verdict's vocabulary."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Literal

from frictool.logs.log import MAIN_TOPIC
from frictool.report.evidence import Evidence
from frictool.report.measure import Measured


@dataclass(frozen=True)
class Where:
    """What a value was found at: the log, the stream, the hold by its number and start [s]; or a vertex of the controller's polytope."""

    log: str | None = None
    stream: str | None = None
    step: int | None = None
    time_s: float | None = None
    vertex: str | None = None

    def __str__(self) -> str:
        if self.vertex is not None:
            return f"vertex {self.vertex}"
        place = f"{self.log} {self.stream}"
        if self.step is not None:
            place += f", step {self.step}"
        return place if self.time_s is None else f"{place} at {self.time_s:.4g} s"


@dataclass(frozen=True)
class Requirement:
    """One key of the specification. `met` is None where the logs cannot tell; `value` is None there, and where no finite value exists."""

    name: str
    key: str
    value: float | None
    limit: float
    unit: str
    met: bool | None
    relation: Literal["<=", ">="] = "<="
    reason: str = ""
    where: Where | None = None
    details: dict[str, float] = field(default_factory=dict)

    @property
    def outcome(self) -> str:
        """MET, NOT MET or CANNOT TELL."""
        return "CANNOT TELL" if self.met is None else "MET" if self.met else "NOT MET"

    def as_json(self) -> dict[str, Any]:
        """The machine's view."""
        where = None if self.where is None else {k: v for k, v in vars(self.where).items() if v is not None}
        return {**vars(self), "where": where}


@dataclass(frozen=True)
class Verdict:
    """All requirements in the specification's order, and the evidence with the metrics of each hold.

    meets: for each stream, whether it breaks none of them by itself and meets one; the modulus margin, which is the controller's, aside.
    """

    name: str
    requirements: tuple[Requirement, ...]
    evidence: tuple[tuple[Evidence, tuple[Measured, ...]], ...]
    meets: tuple[bool, ...] = ()

    @property
    def undecided(self) -> tuple[str, ...]:
        """The requirements that the logs cannot tell."""
        return tuple(r.name for r in self.requirements if r.met is None)

    @property
    def passed(self) -> bool:
        """No requirement is broken and at least one is met."""
        return all(r.met is not False for r in self.requirements) and any(r.met for r in self.requirements)

    @property
    def outcome(self) -> str:
        """MET, NOT MET, or CANNOT TELL where the logs decide nothing."""
        if any(r.met is False for r in self.requirements):
            return "NOT MET"
        return "MET" if self.passed else "CANNOT TELL"

    @property
    def plants(self) -> frozenset[str]:
        """The simulated plants, by their topics: the same one in two logs counts once."""
        return frozenset(evidence.stream.topic for evidence, _ in self.evidence if evidence.simulated)

    @property
    def played_on(self) -> str:
        """What was judged: how many simulated plants, how many recorded streams."""
        plants, recorded = len(self.plants), sum(not evidence.simulated for evidence, _ in self.evidence)
        nominal = " (the nominal one)" if self.plants == {MAIN_TOPIC} else ""
        parts = [f"{plants} plant{'s' if plants > 1 else ''}{nominal}"] if plants else []
        parts += [f"{recorded} recorded stream{'s' if recorded > 1 else ''}"] if recorded else []
        return " and ".join(parts)

    @property
    def headline(self) -> str:
        """One sentence for people; it begins with the outcome."""
        if self.outcome == "CANNOT TELL":
            return "CANNOT TELL: the logs decide none of the requirements"
        met, broken, undecided = (sum(r.met is state for r in self.requirements) for state in (True, False, None))
        parts = [f"{met} of {len(self.requirements)} requirements met"]
        parts += [f"{broken} broken"] if broken else []
        parts += [f"{undecided} undecided"] if undecided else []
        caveat = " as far as the logs tell" if undecided and not broken else ""
        counted = f"; {sum(self.meets)} of {len(self.meets)} streams meet them all" if broken and len(self.meets) > 1 else ""
        return f"{self.outcome}{caveat}: {', '.join(parts)}, on {self.played_on}{counted}"


def number(value: float | None) -> str:
    """A value for people, four digits."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.4g}"


def unit_shown(unit: str) -> str:
    """A unit for people: `A^2` is written with its exponent."""
    return unit.replace("^2", "²")
