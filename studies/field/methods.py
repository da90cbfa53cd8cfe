"""Methods of the field benchmark; each returns values with intervals, or a reason for refusal.

`auto` is the default of `frictool identify`. `plain` is ordinary least squares as in most scripts:
differences, a low-pass, every moving sample, and the usual covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
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
from studies.field.scores import PLAYED, FieldFit

CUTOFF = 0.05  # cutoff of the low-pass of `plain`, relative to the sampling rate
SLOWEST = 0.02  # least speed of a sample, relative to the top speed
CONFIDENCE = 0.95
FEWEST = 50  # samples of a record that the low-pass needs
PEERS = {"MuJoCo system identification": "mujoco.sysid", "BAM M6": "bam"}


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
    """Return the least-squares fit of the effort by [acceleration, velocity, sign(velocity), 1]."""
    b, a = butter(4, 2.0 * CUTOFF)
    parts = []
    for record in records:
        if record.position.size < FEWEST:
            continue
        velocity = np.gradient(filtfilt(b, a, record.position), record.period)
        acceleration = np.gradient(velocity, record.period)
        parts.append(
            np.column_stack(
                (
                    acceleration,
                    velocity,
                    np.sign(velocity),
                    np.ones(velocity.size),
                    filtfilt(b, a, record.effort),
                )
            )
        )
    if not parts:
        return "no record is long enough for the low-pass"
    rows = np.concatenate(parts)
    rows = rows[np.abs(rows[:, 1]) > SLOWEST * np.max(np.abs(rows[:, 1]))]
    x = rows[:, :4]
    value, _, rank, _ = np.linalg.lstsq(x, rows[:, 4], rcond=None)
    if rank < x.shape[1]:
        return f"the regressors have rank {rank} of {x.shape[1]}"
    free = x.shape[0] - x.shape[1]
    variance = float(np.sum((rows[:, 4] - x @ value) ** 2)) / free
    deviation = np.sqrt(variance * np.diag(np.linalg.inv(x.T @ x)))
    half = deviation * float(student.ppf(0.5 + 0.5 * CONFIDENCE, free))
    intervals = {
        name: Interval.around(float(centre), float(reach))
        for name, centre, reach in zip(PLAYED, value, half, strict=True)
    }
    return FieldFit({name: one.value for name, one in intervals.items()}, intervals)


METHODS = {"frictool auto": auto, "plain least squares": plain}


def peer_rows() -> dict[str, str]:
    """Return name -> state of other methods: not installed, or installed and not compared."""
    return {name: _state(module) for name, module in PEERS.items()}


def _state(module: str) -> str:
    try:
        known = find_spec(module) is not None
    except ModuleNotFoundError:
        known = False
    return "installed, not compared" if known else "not installed"
