"""The methods by name, and when each is right. Nothing heavy is imported until one is run, so that `--help` can show the table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from frictool.documents.bench import Bench
    from frictool.identify.inverse_dynamic import Pipeline
    from frictool.identify.outcome import Fit
    from frictool.identify.record import Record

DEFAULT = "least-squares"


@dataclass(frozen=True)
class Method:
    """`what` it does and `when` it is right, for people."""

    what: str
    when: str


METHODS: dict[str, Method] = {
    "least-squares": Method(
        "power balance (4.23): velocity-weighted, zero-phase Savitzky-Golay, only samples certain to slip, QR",
        "any encoder, sticks and backlash; refuses the inertia that quantisation hides",
    ),
    "inverse-dynamic": Method(
        "the published EMPS pipeline: Butterworth, central differences, decimation, ordinary least squares",
        "a fine encoder, no backlash, long strokes; to compare with published values",
    ),
}


@dataclass(frozen=True)
class Settings:
    """What a user may set: `window` [samples] of least-squares, `pipeline` of inverse-dynamic; None is the method's own choice."""

    confidence: float = 0.95
    window: int | None = None
    pipeline: Pipeline | None = None


def run(method: str, records: list[Record], bench: Bench, settings: Settings) -> Fit:
    """The sliding parameters by the method called `method`. Raises NothingUsable where the records do not give any."""
    if method == "inverse-dynamic":
        from frictool.identify.inverse_dynamic import PUBLISHED, inverse_dynamic

        return inverse_dynamic(records, bench, settings.confidence, settings.pipeline or PUBLISHED)
    from frictool.identify.least_squares import least_squares

    return least_squares(records, bench, settings.confidence, settings.window)
