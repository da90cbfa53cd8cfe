"""Outcome of the observation of a log: wear, velocity errors and verdict, as text and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from frictool.adapters.parameter_intervals import absolute
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.logs.losses import as_rows, loss_count_text
from frictool.logs.raw_table import DataLoss
from frictool.observe.commissioning import Commissioning
from frictool.observe.wear_estimate import EstimateRange, WearEstimate
from frictool.observe.wear_limit import WearVerdict, judge
from frictool.presentation.sections import TextTable

KINDS = {
    "none": "no wear visible in the log",
    "multiplicative": "all dry friction by one factor",
    "additive": "one effort added to the dry friction",
    "directional": "a factor for each direction",
    "zones": "a factor for each zone of the travel",
}
NOT_DETERMINED = (
    "not determined by this log (effort too small compared with friction and quantisation)"
)


@dataclass(frozen=True)
class ObservationOutcome:
    """Outcome of the observation of one log.

    - duration: length of the log [s]
    - gaps: number of gaps in time
    - period: sample period [s]
    - estimate: final estimate of the wear
    - figures: errors of the estimated velocity, in SI units. The keys are those of
      `VelocityErrors.figures`; if a sensor measures the velocity, `_true` becomes `_measured`.
    - ratio: wear divided by the wear at commissioning; None if either is unknown
    - reference: file with the wear at commissioning; None if there is no such file
    - verdict: comparison of the wear with its limit; None if there is no limit
    - observer: results of the additional observer; None if there is no such observer
    - losses: parts of the log that could not be read
    - remarks: warnings about the log
    - doubts: reasons why the log may be from another rig
    - confidence: confidence of all intervals, 0 to 1
    """

    source: str
    stream: str
    samples: int
    duration: float
    gaps: int
    period: float
    estimate: WearEstimate
    figures: dict[str, Any]
    ratio: EstimateRange | None = None
    reference: str | None = None
    verdict: WearVerdict | None = None
    observer: dict[str, Any] | None = None
    losses: Sequence[DataLoss] = ()
    remarks: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    confidence: float = 0.95
    unit: str | None = None
    date: str | None = None

    @property
    def warnings(self) -> list[str]:
        """Return all warnings, one line of text each."""
        return [*self.remarks, *self.doubts, *self.estimate.warnings]

    def as_json(self) -> dict[str, Any]:
        """Return the outcome as a JSON object."""
        verdict, ratio = self.verdict, self.ratio
        return {
            "log": Path(self.source).name,
            "stream": self.stream,
            "unit": self.unit,
            "date": self.date,
            "samples": self.samples,
            "duration_s": self.duration,
            "gaps": self.gaps,
            "sample_period_s": self.period,
            "confidence": self.confidence,
            **self.estimate.as_json(),
            **(
                {"ratio": ratio.as_json(), "commissioning": self.reference}
                if ratio is not None
                else {}
            ),
            **self.figures,
            **({"observer": self.observer} if self.observer is not None else {}),
            "wear_limit": None if verdict is None else verdict.limit,
            "alarm": None if verdict is None else verdict.exceeded,
            "reason": None if verdict is None else verdict.reason,
            "lost": as_rows(list(self.losses)),
            "warnings": self.warnings,
        }


def ratio_to(reference: Commissioning | None, estimate: WearEstimate) -> EstimateRange | None:
    """Return the wear divided by the wear at commissioning; None if either is unknown."""
    defined = reference is not None and estimate.moves > 0 and estimate.wear.value > 0.0
    return reference.ratio(estimate) if reference is not None and defined else None


def with_verdict(
    outcome: ObservationOutcome, limit: float | None, reference: Commissioning | None
) -> ObservationOutcome:
    """Return a copy of `outcome` with the ratio to commissioning, and the verdict on the wear.

    The verdict is None if `limit` is None.
    """
    ratio = ratio_to(reference, outcome.estimate)
    verdict = None if limit is None else judge(outcome.estimate, limit, ratio, outcome.doubts)
    return replace(
        outcome,
        ratio=ratio,
        reference=None if reference is None else Path(reference.source).name,
        verdict=verdict,
    )


def heading(outcome: ObservationOutcome) -> str:
    """Return a line with the file name, the duration and the numbers of samples and moves."""
    moves = outcome.estimate.moves
    return (
        f"{Path(outcome.source).name}: {outcome.samples} samples, {outcome.duration:.6g} s, "
        f"{moves} move{'s' * (moves != 1)}"
    )


def lines(outcome: ObservationOutcome, model: Model) -> list[str]:
    """Return the outcome as lines of text; the last line is the verdict."""
    return [
        heading(outcome),
        *facts(outcome, model).lines(),
        *([] if outcome.verdict is None else [_verdict_text(outcome.verdict)]),
    ]


def facts(outcome: ObservationOutcome, model: Model) -> TextTable:
    """Return a table with the name and the value, as text, of each result."""
    estimate = outcome.estimate
    effort = si_unit("effort", model.axis)
    position = si_unit("position", model.axis)
    constant = model.bench.actuator.constant

    def with_constant(one: EstimateRange, unit: str = "") -> str:
        """Return an estimate as text; a second interval includes the actuator constant's error."""
        own = f"{_range(one)} {unit}".rstrip()
        if estimate.scale is None:
            return own
        low, high = absolute(one.low, one.high, constant)
        return f"{own}, absolute [{low:.4g}, {high:.4g}]"

    shown = [
        ("wear", f"{with_constant(estimate.wear)}   ({100.0 * outcome.confidence:g} % interval)"),
        ("kind", KINDS[estimate.kind]),
    ]
    sides = (
        ("forward", estimate.forward, ""),
        ("backward", estimate.backward, ""),
        ("added", estimate.added, effort),
    )
    shown += [
        (f"  {name}", with_constant(one, unit)) for name, one, unit in sides if one is not None
    ]
    shown += [
        (f"  {zone.low:.4g} to {zone.high:.4g} {position}", with_constant(zone.wear))
        for zone in estimate.zones
    ]
    if outcome.ratio is not None:
        shown.append(("to commissioning", _range(outcome.ratio)))
    if estimate.scale is not None:
        shown.append(
            (
                "scale",
                f"{_range(estimate.scale)}   (actuator's constant relative to bench.yaml; "
                "included in the absolute intervals)",
            )
        )
    shown += [
        (
            name.replace("_", " "),
            NOT_DETERMINED
            if name in estimate.undetermined
            else f"{with_constant(one)}   (relative to the model)",
        )
        for name, one in estimate.others.items()
    ]
    shown += [("velocity", text) for text in _velocity(outcome, si_unit("velocity", model.axis))]
    if outcome.observer is not None:
        figures = ", ".join(
            f"{name.replace('_', ' ')} {value:.4g}"
            for name, value in outcome.observer.items()
            if isinstance(value, float)
        )
        shown.append(
            ("observer", f"{outcome.observer['name']}, {outcome.observer['kind']}: {figures}")
        )
    if outcome.losses:
        shown.append(("lost", loss_count_text(list(outcome.losses))))
    return TextTable("Figures", (), tuple(shown))


def _range(estimate: EstimateRange) -> str:
    return f"{estimate.value:.4g} in [{estimate.low:.4g}, {estimate.high:.4g}]"


def _velocity(outcome: ObservationOutcome, unit: str) -> list[str]:
    """Return the rms errors of the velocity and of the best low-pass (thesis 5.70) as text."""
    figures = outcome.figures
    shown: list[str] = []
    cutoff = figures.get("zero_phase_cutoff_hz")
    zero_phase = "the zero-phase velocity" + (f" of {cutoff:.3g} Hz" if cutoff is not None else "")
    for ending, reference in (
        ("", zero_phase),
        ("_true", "the true velocity"),
        ("_measured", "the measured velocity"),
    ):
        rms, other, at = (
            figures.get(f"{name}{ending}")
            for name in ("velocity_rms", "velocity_rms_filter", "filter_cutoff_hz")
        )
        if rms is not None:
            against = (
                ""
                if other is None
                else "; best low-pass of the difference quotient"
                f"{f', {at:.3g} Hz' if at is not None else ''}: {other:.4g} {unit}"
            )
            shown.append(f"{rms:.4g} {unit} rms from {reference}{against}")
    return shown


def _verdict_text(verdict: WearVerdict) -> str:
    word = {True: "EXCEEDED", False: "not exceeded", None: "UNDECIDED"}[verdict.exceeded]
    return f"wear limit {verdict.limit:g}: {word}: {verdict.reason}"
