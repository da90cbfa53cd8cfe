"""Immutable outcome of an identification, to which each stage adds its results with `merge`."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from frictool.documents.bench import Bench
from frictool.documents.laws import Laws
from frictool.documents.quantity import Quantity
from frictool.identify.breakaway.breakaway import Breakaway
from frictool.identify.fit_result import SLIDING, Interval, SlidingFit
from frictool.identify.interval_checks import (
    NEVER_NEGATIVE,
    narrowed,
    outside,
    why_uninformative,
    without_negative,
)

Value = TypeVar("Value")


@dataclass(frozen=True)
class Outcome:
    """Identified parameters of an axis, reasons for refused parameters, and the underlying fits.

    A parameter is identified or refused, not both.

    - identified: interval of each identified parameter, SI units
    - refused: reason for each parameter that was not identified
    - fit: fit of the sliding logs, or None
    - ramp: breakaway of the ramps, or None
    - laws: laws of friction and load in addition to the parameters, or None
    - narrowed: intervals in the model for some refused parameters. Such an interval is the
      intersection of the range in bench.yaml and the logs' interval, or it is the range in
      bench.yaml with a value that fits the logs
    """

    identified: Mapping[str, Interval] = field(default_factory=dict)
    refused: Mapping[str, str] = field(default_factory=dict)
    fit: SlidingFit | None = None
    ramp: Breakaway | None = None
    laws: Laws | None = None
    narrowed: Mapping[str, Interval] = field(default_factory=dict)

    @property
    def from_logs(self) -> dict[str, Interval]:
        """Return the intervals of the identified parameters, and the intervals in `narrowed`."""
        return {**self.narrowed, **self.identified}

    def merge(self, later: Outcome) -> Outcome:
        """Return this outcome combined with `later`; entries of `later` take precedence."""
        kept = _without(self.identified, later.refused)
        refused = _without(self.refused, later.identified)
        return Outcome(
            {**kept, **later.identified},
            {**refused, **later.refused},
            later.fit or self.fit,
            later.ramp or self.ramp,
            later.laws or self.laws,
            {
                **_without(self.narrowed, {*later.identified, *later.refused}),
                **later.narrowed,
            },
        )

    def without(self, *names: str) -> Outcome:
        """Return the outcome in which the parameters `names` are neither identified nor refused."""
        return Outcome(
            _without(self.identified, names),
            _without(self.refused, names),
            self.fit,
            self.ramp,
            self.laws,
            _without(self.narrowed, names),
        )


def _without(values: Mapping[str, Value], names: Container[str]) -> dict[str, Value]:
    return {name: value for name, value in values.items() if name not in names}


def accept(
    offered: Mapping[str, Interval], bench: Bench, reasons: Mapping[str, str] | None = None
) -> Outcome:
    """Accept the `offered` parameters that have informative intervals, and refuse the others.

    If a refused interval narrows the range of the parameter in bench.yaml, the outcome contains the
    intersection of interval and range. `reasons` contains the parameters that the method has
    refused, with the reasons.
    """
    identified = dict[str, Interval]()
    refused = dict(reasons or {})
    ranges = dict[str, Interval]()
    for name, interval in offered.items():
        known: Quantity | None = getattr(bench.mechanics, name, None)
        nonnegative = without_negative(name, interval, known)
        reason = why_uninformative(name, nonnegative, known)
        if reason is not None:
            inside = narrowed(nonnegative, known, bench.actuator.constant)
            if inside is None:
                reason += outside(nonnegative, known)
            elif name not in refused:
                ranges[name] = inside
            refused[name] = reason
            continue
        low = max(nonnegative.low, 0.0) if name in NEVER_NEGATIVE else nonnegative.low
        identified[name] = Interval(nonnegative.value, low, nonnegative.high)
    return Outcome(identified, _without(refused, identified), narrowed=ranges)


def sliding_intervals(from_logs: Mapping[str, Interval], bench: Bench) -> dict[str, Interval]:
    """Return the interval of each sliding parameter: from the logs, else from the bench.

    An offset that neither the logs nor the bench state is 0.
    """
    return {name: from_logs.get(name) or bench_interval(bench, name) for name in SLIDING}


def bench_interval(bench: Bench, name: str) -> Interval:
    """Return the interval of a sliding parameter in bench.yaml; [0, 0] for a missing offset."""
    known: Quantity | None = getattr(bench.mechanics, name)
    return Interval(0.0, 0.0, 0.0) if known is None else Interval(known.value, *known.interval)
