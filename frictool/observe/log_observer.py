"""Observation of one log, from its first sample to its outcome."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.logs.canonical.mcap_layout import KIND
from frictool.logs.log_assembly import EVERYTHING, TimeWindow
from frictool.logs.origin import LogName, NamePatterns, origin_of
from frictool.observe.combined_estimator import (
    EstimateBlock,
    VelocityEstimation,
    WearEstimation,
    estimate_along,
)
from frictool.observe.design.tracking import design_tracking
from frictool.observe.observation_outcome import ObservationOutcome
from frictool.observe.rig_plausibility import implausible
from frictool.observe.sample_stream import SampleStream, open_stream
from frictool.observe.second_observer import SecondObserver, check_observer
from frictool.observe.velocity import VelocityEstimator
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.observe.wear_estimate import WearEstimate

# temperature range of a log, K, above which the model should have friction over temperature
LEAST_RANGE = 5.0
BEYOND = 2.0  # K outside the temperatures of the model's logs, above which a warning is issued
UNKNOWN_LAW = (
    "the model's friction does not depend on temperature: a change of friction with the log's "
    "temperature is part of the wear; identify the model from logs with a temperature"
)
OFTEN = 100  # samples per gap; if gaps are more frequent, every move contains a gap


@dataclass(frozen=True)
class ObservationSettings:
    """Options for reading and judging logs.

    - window: time window of the log that is read
    - topic: name of the stream; None for /axis
    - salvage: True to read the undamaged parts of a damaged file
    - confidence: confidence of all intervals, 0 to 1
    - patterns: patterns that extract unit and date from file names
    """

    window: TimeWindow = EVERYTHING
    topic: str | None = None
    salvage: bool = False
    confidence: float = 0.95
    patterns: NamePatterns = field(default_factory=NamePatterns)


def estimated_wear(model: Model, confidence: float) -> WearEstimation:
    """Create the wear estimator for a model."""
    return WearEstimator(model, confidence=confidence)


def estimated_velocity(model: Model, confidence: float) -> VelocityEstimation:
    """Create the velocity estimator for a model."""
    return VelocityEstimator(model, confidence)


@dataclass(frozen=True)
class EstimatorFactories:
    """Functions that create the wear and velocity estimators for a model and a confidence."""

    wear: Callable[[Model, float], WearEstimation] = estimated_wear
    velocity: Callable[[Model, float], VelocityEstimation] = estimated_velocity


THESE = EstimatorFactories()


class LogObserver:
    """Observer of one log; `outcome` is complete after `parts` has yielded all estimates."""

    def __init__(
        self,
        path: Path,
        model: Model,
        settings: ObservationSettings,
        name: LogName | None = None,
        estimators: EstimatorFactories = THESE,
        observer: tuple[Path, Observer] | None = None,
    ) -> None:
        """Open the log and create the estimators.

        `observer` contains path and document of an additional observer. A tracking observer
        replaces the velocity estimator.

        Raises LogError if the log cannot be observed (`open_stream`). Raises DocumentError if the
        observer does not fit the model's kind of axis or the log's sample period. Raises
        FrictoolError if the model has no dry friction.
        """
        self.name = name or LogName(path.name)
        self.settings = settings
        self.feed: SampleStream = open_stream(
            path, model.bench, settings.window, settings.topic, settings.salvage
        )
        bench = msgspec.structs.replace(model.bench, sample_period_s=self.feed.period)
        self.model = msgspec.structs.replace(model, bench=bench)
        self.wear = estimators.wear(self.model, settings.confidence)
        self.velocity = estimators.velocity(self.model, settings.confidence)
        self.second: SecondObserver | None = None
        if observer is not None:
            check_observer(*observer, self.model, self.feed.period)
            self._take_along(observer[1])

    def _take_along(self, observer: Observer) -> None:
        if observer.tracking is not None:
            self.velocity = VelocityEstimator(self.model, self.settings.confidence, observer)
            return
        tracking = design_tracking(self.model, observer.provenance).tracking
        assert tracking is not None
        self.second = SecondObserver(observer, tracking.bandwidth_rad_s / (2.0 * math.pi))

    def parts(self) -> Iterator[EstimateBlock]:
        """Yield the estimates block by block; raise LogError for damage or too many gaps."""
        yield from estimate_along(
            self.feed.pieces(),
            self.model,
            self.wear,
            self.velocity,
            self.settings.confidence,
            self.second,
        )
        self.wear.finish()

    def _warm(self) -> list[str]:
        """Return a warning if the wear estimate may depend on the temperature of the log."""
        log, laws = self.feed, self.model.laws
        law = laws.temperature if laws is not None else None
        measured = log.coldest <= log.hottest
        if not measured and law is not None and (law.viscous or law.coulomb):
            return [
                f"the log has no temperature: the wear assumes {law.reference.value:.4g} degC, "
                "the model's reference; map the temperature in columns.temperature of the bench"
            ]
        if not measured or law is None:
            return [] if not measured or log.hottest - log.coldest < LEAST_RANGE else [UNKNOWN_LAW]
        beyond = max(law.over.low - log.coldest, log.hottest - law.over.high)
        if beyond <= BEYOND:
            return []
        return [
            f"the log's temperatures, {log.coldest:.4g} to {log.hottest:.4g} degC, are not "
            f"within the {law.over.low:.4g} to {law.over.high:.4g} degC of the model's logs: "
            "friction is extrapolated"
        ]

    def _silent(self) -> list[str]:
        """Return [reason why no wear was estimated], or [] if the wear was estimated."""
        if self.wear.estimate.moves:
            return []
        if self.feed.gaps * OFTEN > self.feed.samples:
            grid = f"resample the log first: `frictool ingest --resample {self.feed.period:.6g}`"
            return [
                f"no move determines the wear: the log has {self.feed.gaps} gaps in time, "
                f"and a move must not contain a gap; {grid}"
            ]
        return [
            "no move determines the wear: within the bench's travel, the axis never slips long "
            "and fast enough outside the backlash"
        ]

    def _figures(self) -> dict[str, Any]:
        """Return the velocity errors by name; `_measured` marks errors relative to a sensor."""
        figures = self.velocity.figures()
        return (
            figures
            if self.feed.truth
            else {name.replace("_true", "_measured"): value for name, value in figures.items()}
        )

    def wear_alone(self) -> WearEstimate:
        """Read the whole log, estimate the wear only, and return the final estimate."""
        for piece in self.feed.pieces():
            self.wear.take(piece)
        self.wear.finish()
        return self.wear.estimate

    @property
    def progress(self) -> float:
        """Return the fraction of the log that has been read (0 to 1)."""
        return self.feed.made.progress

    def outcome(self) -> ObservationOutcome:
        """Return the outcome, which is complete only after `parts` has ended."""
        log = self.feed
        made = self.feed.made
        origin = origin_of(
            made.notes.get(KIND, {}), made.origin, log.first, self.name, self.settings.patterns
        )
        return ObservationOutcome(
            source=log.source,
            stream=log.topic,
            samples=log.samples,
            duration=log.duration,
            gaps=log.gaps,
            period=log.period,
            estimate=self.wear.estimate,
            figures=self._figures(),
            observer=None if self.second is None else self.second.as_json(),
            losses=log.losses,
            remarks=(*log.remarks(), *self._warm(), *self._silent()),
            doubts=implausible(self.model, self.wear.estimate),
            confidence=self.settings.confidence,
            unit=origin.unit,
            date=origin.date,
        )
