"""Logs that are made and kept by a program: from arrays, and to a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike

from frictool.documents.quantity import CHANNEL_DIMENSIONS, Axis, si_unit
from frictool.errors import LogError, OutputError
from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.runtime.part_files import part_file


def log_of(time: ArrayLike, signals: Mapping[str, ArrayLike], axis: Axis, name: str = "log") -> Log:
    """A log of one stream from arrays (n,): `time` in s, signals by the names of channels
    (position, current, reference, ...), in SI.

    Raises LogError where the axis is none, a name is no channel, arrays differ in length, a value
    is not finite, or time does not increase.
    """
    if axis not in get_args(Axis):
        raise LogError(name, f"axis: found {axis!r}; allowed: {', '.join(get_args(Axis))}")
    clock = _vector(name, "time", time)
    unknown = [one for one in signals if one not in CHANNEL_DIMENSIONS]
    if unknown or not signals:
        raise LogError(
            name,
            f"no channel: {', '.join(unknown) or 'there is none'}; allowed: {', '.join(CHANNEL_DIMENSIONS)}",
        )
    values = {one: _vector(name, one, given) for one, given in signals.items()}
    for one, vector in values.items():
        if vector.size != clock.size:
            raise LogError(name, f"{one} has {vector.size} samples, time has {clock.size}")
    if clock.size < 2 or not np.all(np.diff(clock) > 0.0):
        raise LogError(
            name, "time does not increase from sample to sample, or there are fewer than 2"
        )
    units = {one: si_unit(CHANNEL_DIMENSIONS[one], axis) for one in signals}
    return Log((Stream(MAIN_TOPIC, clock, values, units),), {}, name)


def _vector(name: str, channel: str, given: ArrayLike) -> np.ndarray:
    vector = np.array(given, dtype=np.float64)
    if vector.ndim != 1 or not np.all(np.isfinite(vector)):
        raise LogError(
            name, f"{channel} is no vector of finite numbers; its shape is {vector.shape}"
        )
    return vector


def write_log(log: Log, path: Path | str) -> None:
    """Writes a log as canonical MCAP to `path`, whole or not at all. Raises LogError as
    `write_mcap`, OutputError where it cannot."""
    path = Path(path)
    try:
        with part_file(path) as stream:
            write_mcap(log, stream)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
