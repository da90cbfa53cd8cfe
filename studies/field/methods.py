"""Methods of the field benchmark; each returns values with intervals, or a reason for refusal.

`auto` is the default of `frictool identify`. `plain` is ordinary least squares as in most scripts:
differences, a low-pass, every moving sample, and the usual covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec

import numpy as np
from scipy.signal import butter, filtfilt
from scipy.stats import t as student

from frictool.documents.bench import Bench
from frictool.errors import FrictoolError
from frictool.identify.fit_result import Interval
from frictool.identify.identification import identify_records
from frictool.identify.methods import IdentificationSettings
from frictool.identify.motion_record import MotionRecord
from frictool.identify.outcome import sliding_intervals
from studies.field.mujoco_sysid import mujoco_sysid
from studies.field.scores import GRAVITY, PLAYED, FieldFit, Method, fit_of, has_gravity

CUTOFF = 0.05  # cutoff of the low-pass of `plain`, relative to the sampling rate
SLOWEST = 0.02  # least speed of a sample, relative to the top speed
CONFIDENCE = 0.95
FEWEST = 50  # samples of a record that the low-pass needs
MUJOCO = "mujoco.sysid"


def auto(records: Sequence[MotionRecord], bench: Bench) -> FieldFit | str:
    """Return the fit of frictool's default method, or the reason of its refusal."""
    try:
        result = identify_records(list(records), [], bench, "auto", IdentificationSettings())
    except FrictoolError as error:
        return str(error)
    used = sliding_intervals(result.from_logs, bench)
    values = {name: one.value for name, one in {**used, **result.from_logs}.items()}
    found = {name: one for name, one in result.identified.items() if name in PLAYED}
    if not found:
        return "; ".join(result.refused.values())
    return FieldFit(values, found, result.laws)


def plain(records: Sequence[MotionRecord], bench: Bench) -> FieldFit | str:
    """Return the fit of ordinary least squares, or the reason why there is none."""
    intervals = _least_squares(records, bench)
    return intervals if isinstance(intervals, str) else fit_of(intervals)


def mujoco(records: Sequence[MotionRecord], bench: Bench) -> FieldFit | str:
    """Return the fit of `mujoco.sysid`, which begins at the values of least squares."""
    first = _least_squares(records, bench)
    start = {} if isinstance(first, str) else {name: one.value for name, one in first.items()}
    return mujoco_sysid(records, bench, start)


def _least_squares(records: Sequence[MotionRecord], bench: Bench) -> dict[str, Interval] | str:
    """Fit the effort by [acceleration, velocity, sign(velocity), 1]; return intervals by name.

    If the bench declares gravity, sine and cosine of the position are regressors, too.
    """
    b, a = butter(4, 2.0 * CUTOFF)
    pendulum = has_gravity(bench)
    parts = []
    for record in records:
        if record.position.size < FEWEST:
            continue
        velocity = np.gradient(filtfilt(b, a, record.position), record.period)
        loads = (np.sin(record.position), np.cos(record.position)) if pendulum else ()
        parts.append(
            np.column_stack(
                (
                    np.gradient(velocity, record.period),
                    velocity,
                    np.sign(velocity),
                    np.ones(velocity.size),
                    *loads,
                    filtfilt(b, a, record.effort),
                )
            )
        )
    if not parts:
        return "no record is long enough for the low-pass"
    rows = np.concatenate(parts)
    rows = rows[np.abs(rows[:, 1]) > SLOWEST * np.max(np.abs(rows[:, 1]))]
    x, effort = rows[:, :-1], rows[:, -1]
    value, _, rank, _ = np.linalg.lstsq(x, effort, rcond=None)
    if rank < x.shape[1]:
        return f"the regressors have rank {rank} of {x.shape[1]}"
    free = x.shape[0] - x.shape[1]
    variance = float(np.sum((effort - x @ value) ** 2)) / free
    deviation = np.sqrt(variance * np.diag(np.linalg.inv(x.T @ x)))
    half = deviation * float(student.ppf(0.5 + 0.5 * CONFIDENCE, free))
    names = (*PLAYED, *(GRAVITY if pendulum else ()))
    return dict(zip(names, map(Interval.around, value.tolist(), half.tolist()), strict=True))


METHODS: dict[str, Method] = {"frictool": auto, "least squares": plain}


def installed_methods() -> dict[str, Method]:
    """Return the methods that are installed.

    `mujoco.sysid` lacks its functions if `mujoco` is installed without its extra `sysid`.
    """
    if find_spec("mujoco") is None or not hasattr(import_module("mujoco.sysid"), "optimize"):
        return METHODS
    return METHODS | {MUJOCO: mujoco}
