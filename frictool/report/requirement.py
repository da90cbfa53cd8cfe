"""Requirements with their outcomes, and the verdict on all of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, get_args

from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.metric_table import requirement_title
from frictool.documents.proof import Proof
from frictool.documents.spec import Spec
from frictool.logs.log import MAIN_TOPIC, Log
from frictool.report.evidence import StreamEvidence
from frictool.report.hold_metrics import HoldMetrics
from frictool.runtime.object_view import ResultView

if TYPE_CHECKING:
    from matplotlib.figure import Figure

State = Literal["pass", "fail", "undecided"]
STATES: tuple[State, ...] = get_args(State)


@dataclass(frozen=True)
class ValueLocation:
    """Location of a value: a vertex of the controller, a stream of a log, or a hold of a stream.

    A hold is a phase of constant reference.

    - log, stream: name of the log, topic of the stream; None for a vertex
    - step: number of the hold in `stream`, from 1; None for the whole stream
    - time_s: start of the hold [s]
    - vertex: name of the vertex; None for a stream or hold
    """

    log: str | None = None
    stream: str | None = None
    step: int | None = None
    time_s: float | None = None
    vertex: str | None = None

    def __str__(self) -> str:
        if self.vertex is not None:
            return f"vertex {self.vertex}"
        where = f"{self.log} {self.stream}"
        if self.step is not None:
            where += f", step {self.step}"
        return where if self.time_s is None else f"{where} at {self.time_s:.4g} s"


@dataclass(frozen=True)
class Requirement:
    """One key of the specification with its limit and its outcome.

    - name: name of the metric
    - key: key of the specification
    - value: worst value, in `unit`; None if it is unknown or not finite
    - met: True or False; None if the requirement is undecided
    - relation: `<=` if the limit is an upper limit, `>=` if it is a lower limit
    - reason: remark on the outcome, or why the requirement is undecided
    - where: location of the worst value
    - details: additional numbers, by name
    - known: source of the outcome (measured, simulated, computed or proved); empty if undecided
    """

    name: str
    key: str
    value: float | None
    limit: float
    unit: str
    met: bool | None
    relation: Literal["<=", ">="] = "<="
    reason: str = ""
    where: ValueLocation | None = None
    details: dict[str, float] = field(default_factory=dict)
    known: str = ""

    @property
    def outcome(self) -> str:
        """Return MET, NOT MET or UNDECIDED."""
        return "UNDECIDED" if self.met is None else "MET" if self.met else "NOT MET"

    @property
    def title(self) -> str:
        """Return the title of the metric."""
        return requirement_title(self.name)

    @property
    def value_text(self) -> str:
        """Return the value with its unit; empty if the value is unknown."""
        return "" if self.value is None else self._quantity(self.value)

    @property
    def limit_text(self) -> str:
        """Return the limit with its unit."""
        return self._quantity(self.limit)

    @property
    def sign(self) -> str:
        """Return the relation between value and limit as one character, ≤ or ≥."""
        return {"<=": "≤", ">=": "≥"}[self.relation]

    @property
    def remark(self) -> str:
        """Return the worst value's location and `reason` as text; empty if both are missing."""
        return "; ".join(part for part in (str(self.where or ""), self.reason) if part)

    def _quantity(self, value: float) -> str:
        return f"{number(value)} {unit_shown(self.unit)}".rstrip()

    def as_json(self) -> dict[str, Any]:
        """Return the fields as JSON values."""
        where = (
            None
            if self.where is None
            else {k: v for k, v in vars(self.where).items() if v is not None}
        )
        return {**vars(self), "where": where}


@dataclass(frozen=True)
class ReportRequest:
    """Logs and documents from which a verdict is computed.

    - bench: bench of recorded logs; None if it is the controller's bench
    - proof: document `proof.yaml` that `frictool prove` wrote for a step test of the controller
    """

    spec: Spec
    logs: tuple[Log, ...]
    controller: Controller | None = None
    bench: Bench | None = None
    proof: Proof | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Verdict(ResultView):
    """Judgement of logs against a specification: outcome of each requirement, metrics of each log.

    The requirements are in the specification's order.

    - meets: for each stream, True if its values meet every requirement. All are False if a
      simulation among the logs may differ from the axis
    - remarks: warnings
    """

    request: ReportRequest
    requirements: tuple[Requirement, ...]
    evidence: tuple[tuple[StreamEvidence, tuple[HoldMetrics, ...]], ...]
    meets: tuple[bool, ...] = ()
    remarks: tuple[str, ...] = ()

    def plot(self) -> Figure:
        """Return a matplotlib figure with position and drive of every judged stream."""
        from frictool.report.verdict_figure import verdict_figure

        return verdict_figure(self)

    @property
    def name(self) -> str:
        """Return the name of the specification."""
        return self.request.spec.name

    @property
    def undecided(self) -> tuple[str, ...]:
        """Return the names of the undecided requirements."""
        return tuple(r.name for r in self.requirements if r.met is None)

    @property
    def state(self) -> State:
        """Return the state: `fail`, `undecided` or `pass`.

        The state is `fail` if a requirement is not met, else `undecided` if a requirement is
        undecided or the verdict has no requirement, else `pass`.
        """
        if any(r.met is False for r in self.requirements):
            return "fail"
        return "undecided" if self.undecided or not self.requirements else "pass"

    @property
    def passed(self) -> bool:
        """Return True if every requirement is met."""
        return self.state == "pass"

    def acceptable(self, allow_undecided: bool) -> bool:
        """Return True if the verdict is `pass`.

        With `allow_undecided`, undecided requirements do not matter if at least one requirement is
        met and no requirement is violated.
        """
        return self.passed or (
            allow_undecided and self.state == "undecided" and any(r.met for r in self.requirements)
        )

    @property
    def plants(self) -> frozenset[str]:
        """Return the topics of the simulated plants in all logs."""
        return frozenset(
            evidence.stream.topic for evidence, _ in self.evidence if evidence.simulated
        )

    @property
    def played_on(self) -> str:
        """Return the numbers of simulated plants and recorded streams as text."""
        plants = len(self.plants)
        recorded = sum(not evidence.simulated for evidence, _ in self.evidence)
        nominal = " (the nominal one)" if self.plants == {MAIN_TOPIC} else ""
        parts = [f"{plants} plant{'s' if plants > 1 else ''}{nominal}"] if plants else []
        parts += [f"{recorded} recorded stream{'s' if recorded > 1 else ''}"] if recorded else []
        return " and ".join(parts)

    @property
    def headline(self) -> str:
        """Return the verdict as one sentence that begins with its state."""
        if all(r.met is None for r in self.requirements):
            return "UNDECIDED: the logs decide none of the requirements"
        met, broken, undecided = (
            sum(r.met is state for r in self.requirements) for state in (True, False, None)
        )
        parts = [f"{met} of {len(self.requirements)} requirements met"]
        parts += [f"{broken} broken"] if broken else []
        parts += [f"{undecided} undecided"] if undecided else []
        counted = (
            f"; {sum(self.meets)} of {len(self.meets)} streams meet them all"
            if broken and len(self.meets) > 1
            else ""
        )
        return f"{self.state.upper()}: {', '.join(parts)}, on {self.played_on}{counted}"


def number(value: float | None) -> str:
    """Return a number as text with four digits; a dash if it is None or not finite."""
    return "-" if value is None or not math.isfinite(value) else f"{value:.4g}"


def unit_shown(unit: str) -> str:
    """Return the unit with superscript exponents."""
    return unit.replace("^2", "²")
