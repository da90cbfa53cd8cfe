"""Validate a model against a measured log in memory."""

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
    """Replay a measured log through a model, and return the errors.

    Parameters
    ----------
    model
        Model to validate.
    log
        Log with the measured position and effort, or drive.
    skip
        Samples left out at the start of each unbroken piece.
    cutoff_hz
        Cut-off of the low-pass for velocity and acceleration, Hz.
    servo
        Gains from position to effort. With them, the loop is closed along the measured reference;
        without them, the measured effort drives the model.
    moving
        Start with the measured speed, and not at rest.

    Returns
    -------
    Validation
        Measured and simulated signals (n,) in SI units, and their errors.

    Raises
    ------
    LogError
        If the log has no unbroken piece longer than `skip`, no motion, or no reference for a closed
        loop, or does not fit the model's bench.
    NoSolutionError
        If the simulation fails.
    """
    return replayed(
        model, record_of(match_bench(log, model.bench), model.bench), skip, cutoff_hz, servo, moving
    )
