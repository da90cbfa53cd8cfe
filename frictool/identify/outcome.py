"""Immutable outcome of an identification; each stage adds its part with `merge`."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.quantity import Quantity
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.interval_checks import NEVER_NEGATIVE, why_uninformative, without_negative

Value = TypeVar("Value")


@dataclass(frozen=True)
class Outcome:
    """Identified parameters of an axis, reasons for refused ones, and the underlying fits.

    A parameter is identified or refused, not both.

    - identified: parameter -> interval in SI units
    - refused: parameter -> reason
    - fit, ramp: fit of the sliding logs and breakaway of the ramps, or None
    - laws: laws of friction and load in addition to the parameters; None without any
    """

    identified: Mapping[str, Interval] = field(default_factory=dict)
    refused: Mapping[str, str] = field(default_factory=dict)
    fit: SlidingFit | None = None
    ramp: Breakaway | None = None
    laws: Laws | None = None

    def merge(self, later: Outcome) -> Outcome:
        """Return this outcome joined with `later`, whose entries take precedence."""
        kept = _without(self.identified, later.refused)
        refused = _without(self.refused, later.identified)
        return Outcome(
            {**kept, **later.identified},
            {**refused, **later.refused},
            later.fit or self.fit,
            later.ramp or self.ramp,
            later.laws or self.laws,
        )

    def without(self, *names: str) -> Outcome:
        """Return the outcome with the parameters `names` neither identified nor refused."""
        identified, refused = _without(self.identified, names), _without(self.refused, names)
        return Outcome(identified, refused, self.fit, self.ramp, self.laws)


def _without(values: Mapping[str, Value], names: Container[str]) -> dict[str, Value]:
    return {name: value for name, value in values.items() if name not in names}


def accept(
    offered: Mapping[str, Interval], bench: Bench, reasons: Mapping[str, str] | None = None
) -> Outcome:
    """Return an outcome that accepts the informative intervals of `offered` and refuses the others.

    `reasons`: reasons for the parameters that the method itself has refused.
    """
    identified = dict[str, Interval]()
    refused = dict(reasons or {})
    for name, interval in offered.items():
        known: Quantity | None = getattr(bench.mechanics, name, None)
        nonnegative = without_negative(name, interval, known)
        reason = why_uninformative(name, nonnegative, known)
        if reason is not None:
            refused[name] = reason
            continue
        low = max(nonnegative.low, 0.0) if name in NEVER_NEGATIVE else nonnegative.low
        identified[name] = Interval(nonnegative.value, low, nonnegative.high)
    return Outcome(identified, _without(refused, identified))


def sliding_intervals(identified: Mapping[str, Interval], bench: Bench) -> dict[str, Interval]:
    """Return each sliding parameter: the identified interval, else the bench's, else offset 0."""
    return {name: identified.get(name) or bench_interval(bench, name) for name in SLIDING}


def bench_interval(bench: Bench, name: str) -> Interval:
    """Return the bench's interval of a sliding parameter; 0 for an undeclared offset."""
    known: Quantity | None = getattr(bench.mechanics, name)
    return Interval(0.0, 0.0, 0.0) if known is None else Interval(known.value, *known.interval)
