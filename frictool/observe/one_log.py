"""One log from its first sample to what it has told in the end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from frictool.documents.model import Model
from frictool.logs.assembly import EVERYTHING, Window
from frictool.observe.estimate import Estimate
from frictool.observe.feed import Feed, feed
from frictool.observe.origin import Name, Patterns, origin_of
from frictool.observe.outcome import Outcome
from frictool.observe.run import Part, Velocity, Wear, along


@dataclass(frozen=True)
class Settings:
    """How logs are read and judged. topic: of the stream, where it is not /axis. confidence: of all intervals."""

    window: Window = EVERYTHING
    topic: str | None = None
    salvage: bool = False
    confidence: float = 0.95
    patterns: Patterns = field(default_factory=Patterns)


def estimated_wear(model: Model, confidence: float) -> Wear:
    """The estimator of wear."""
    from frictool.observe.wear.estimator import WearEstimator

    return WearEstimator(model, confidence=confidence)


def estimated_velocity(model: Model, confidence: float) -> Velocity:
    """The estimator of the velocity."""
    from frictool.observe.velocity import VelocityEstimator

    return VelocityEstimator(model, confidence)


@dataclass(frozen=True)
class Estimators:
    """What estimates, made for a model and a confidence."""

    wear: Callable[[Model, float], Wear] = estimated_wear
    velocity: Callable[[Model, float], Velocity] = estimated_velocity


THESE = Estimators()


class OneLog:
    """A log that is being observed: `parts` once, then `outcome`."""

    def __init__(self, path: Path, model: Model, settings: Settings, name: Name | None = None, estimators: Estimators = THESE) -> None:
        self.name, self.settings = name or Name(path.name), settings
        self.feed: Feed = feed(path, model.bench, settings.window, settings.topic, settings.salvage)
        bench = msgspec.structs.replace(model.bench, sample_period_s=self.feed.period)
        self.model = msgspec.structs.replace(model, bench=bench)
        self.wear = estimators.wear(self.model, settings.confidence)
        self.velocity = estimators.velocity(self.model, settings.confidence)

    def parts(self) -> Iterator[Part]:
        """What is known at its samples, piece after piece. Raises LogError as `Feed.pieces`."""
        yield from along(self.feed.pieces(), self.model, self.wear, self.velocity, self.settings.confidence)
        self.wear.finish()

    def wear_alone(self) -> Estimate:
        """The wear in the end, nothing else: in place of `parts`."""
        for piece in self.feed.pieces():
            self.wear.take(piece)
        self.wear.finish()
        return self.wear.estimate

    @property
    def progress(self) -> float:
        """The part of the log that has been worked through."""
        return self.feed.made.progress

    def outcome(self) -> Outcome:
        """What is known in the end."""
        log, found = self.feed, origin_of(self.feed, self.name, self.settings.patterns)
        return Outcome(
            source=log.source,
            stream=log.topic,
            samples=log.samples,
            duration=log.duration,
            gaps=log.gaps,
            period=log.period,
            estimate=self.wear.estimate,
            figures=self.velocity.figures(),
            losses=log.losses,
            remarks=log.remarks(),
            confidence=self.settings.confidence,
            unit=found.unit,
            date=found.date,
        )
