"""Making a log from arrays, and writing a log to a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, get_args

import numpy as np
from numpy.typing import ArrayLike

from frictool.documents.quantity import CHANNEL_DIMENSIONS, Axis, si_unit
from frictool.errors import LogError, OutputError
from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import MAIN_TOPIC, Log, Stream
from frictool.runtime.part_files import part_file


def log_of(time: ArrayLike, signals: Mapping[str, ArrayLike], axis: Axis, name: str = "log") -> Log:
    """Return a log with one stream, `/axis`, made from arrays.

    Parameters
    ----------
    time : array_like, shape (n,)
        Time in s, strictly increasing, at least two samples.
    signals : mapping of str to array_like, shape (n,)
        Signals in SI by channel; channels are `position`, `velocity`, `reference` and others.
    axis : {"rotary", "linear"}
        Kind of the axis, which determines the SI units of the signals.
    name : str
        Name of the log in error messages.

    Returns
    -------
    Log
        The log, without metadata.

    Raises
    ------
    LogError
        If the axis or a channel is unknown, lengths differ, a value is not finite, or time does not
        increase.
    """
    if axis not in get_args(Axis):
        raise LogError(name, f"axis: found {axis!r}; allowed: {', '.join(get_args(Axis))}")
    clock = _vector(name, "time", time)
    unknown = [one for one in signals if one not in CHANNEL_DIMENSIONS]
    if unknown or not signals:
        raise LogError(
            name,
            f"channels: found {', '.join(unknown) or 'none'}; allowed: "
            f"{', '.join(CHANNEL_DIMENSIONS)}",
        )
    values = {one: _vector(name, one, signal) for one, signal in signals.items()}
    for one, vector in values.items():
        if vector.size != clock.size:
            raise LogError(name, f"{one} has {vector.size} samples, time has {clock.size}")
    if clock.size < 2 or not np.all(np.diff(clock) > 0.0):
        raise LogError(
            name, "time does not increase from sample to sample, or has fewer than 2 samples"
        )
    units = {one: si_unit(CHANNEL_DIMENSIONS[one], axis) for one in signals}
    return Log((Stream(MAIN_TOPIC, clock, values, units),), {}, name)


def _vector(name: str, channel: str, values: ArrayLike) -> np.ndarray:
    vector = np.array(values, dtype=np.float64)
    if vector.ndim != 1 or not np.all(np.isfinite(vector)):
        raise LogError(
            name, f"{channel} is not a vector of finite numbers; its shape is {vector.shape}"
        )
    return vector


def write_log(log: Log, path: Path | str) -> None:
    """Write a log as canonical MCAP; after an error `path` is unchanged.

    Raises
    ------
    LogError
        If the file format cannot represent the log (see `write_mcap`).
    OutputError
        If the file cannot be written.
    """
    with new_file(Path(path)) as stream:
        write_mcap(log, stream)


@contextmanager
def new_file(path: Path) -> Iterator[BinaryIO]:
    """Yield a binary stream; its content becomes the file `path` only if the with-block succeeds.

    Raises OutputError if the file cannot be written.
    """
    try:
        with part_file(path) as stream:
            yield stream
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {error.strerror or error}") from None
