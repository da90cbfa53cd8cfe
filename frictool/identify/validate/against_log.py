"""A model against a measured log in memory."""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.engine.servo import PositionServo
from frictool.identify.motion_record import record_of
from frictool.identify.validate.validation import Validation
from frictool.identify.validate.validation import validate as replayed
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log import Log

SKIP, CUTOFF_HZ = 20, 100.0


def validate(
    model: Model,
    log: Log,
    *,
    skip: int = SKIP,
    cutoff_hz: float = CUTOFF_HZ,
    servo: PositionServo | None = None,
    moving: bool = False,
) -> Validation:
    """The measured effort of `log` through `model`, or with a servo (its gains from position to
    effort) the measured reference.

    Errors are of what remains after `skip` samples, velocity and acceleration through a low-pass of
    `cutoff_hz`; `moving`: begin with the measured speed and not at rest. Raises LogError,
    NoSolutionError as `validation.validate`.
    """
    return replayed(
        model, record_of(match_bench(log, model.bench), model.bench), skip, cutoff_hz, servo, moving
    )
