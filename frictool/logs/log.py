"""Logs in memory.

A `Log` has one `Stream` per time base: `/axis`, and `/axis/NAME` for each additional instrument or
simulated variant. A stream has a time vector in s and signals of the same length in SI. Signals
have the names of the canonical log, such as `position`, `reference` or `current`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from frictool.errors import LogError
from frictool.runtime.object_view import ResultView
from frictool.typing import Vector

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

MAIN_TOPIC = "/axis"
MECHANISM_TOPIC = "/mechanism"  # stream of all blocks of a simulated mechanism
EXCITATION = "excitation"  # metadata record of a `frictool excite` test: kind, rule, figures


@dataclass(frozen=True, eq=False, repr=False)
class Stream(ResultView):
    """Signals that share one time base.

    Attributes
    ----------
    topic : str
        Topic, such as `/axis` or `/axis/NAME`.
    time : ndarray, shape (n,)
        Time in s, strictly increasing.
    signals : dict of str to ndarray, shape (n,)
        Signals by name, in SI.
    units : dict of str to str
        SI unit of each signal.

    Raises
    ------
    ValueError
        If a signal has another length than `time`.
    """

    topic: str
    time: Vector
    signals: dict[str, Vector]
    units: dict[str, str]

    def __post_init__(self) -> None:
        for name, values in self.signals.items():
            if values.shape != self.time.shape:
                raise ValueError(
                    f"signal {name!r} has {values.shape[0]} samples, time has {self.time.shape[0]}"
                )

    def to_pandas(self) -> DataFrame:
        """Return the signals as a DataFrame: a column for each signal in SI, indexed by `time`.

        Returns
        -------
        pandas.DataFrame
            Shape (n, signals); `attrs["units"]` has the unit of each column.

        Raises
        ------
        LogError
            If pandas is not installed.
        """
        try:
            import pandas
        except ModuleNotFoundError:
            raise LogError(
                self.topic, "needs pandas, which is not installed: pip install 'frictool[pandas]'"
            ) from None
        frame: DataFrame = pandas.DataFrame(
            self.signals, index=pandas.Index(self.time, name="time")
        )
        frame.attrs["units"] = dict(self.units)
        return frame

    @property
    def period(self) -> float:
        """Return the median sample period in s; NaN for fewer than two samples."""
        return float(np.median(np.diff(self.time))) if self.time.size > 1 else float("nan")


@dataclass(frozen=True, eq=False, repr=False)
class Log(ResultView):
    """Streams of one log with their metadata.

    Attributes
    ----------
    streams : tuple of Stream
        Streams in the order of the file.
    metadata : dict of str to dict of str to str
        Metadata records by name; each record maps keys to texts. An example is `provenance`.
    source : str
        Name of the log in error messages, such as its file name.
    warnings : tuple of str
        Warnings about the raw file from which the log was read. They are not written to a file.
    """

    streams: tuple[Stream, ...]
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    source: str = "log"
    warnings: tuple[str, ...] = ()

    def plot(self) -> Figure:
        """Return a matplotlib figure with one panel for each signal, plotted against time."""
        from frictool.logs.log_figure import log_figure

        return log_figure(self)

    @property
    def axes(self) -> tuple[Stream, ...]:
        """Return all streams except the streams of a mechanism (`/mechanism` and below)."""
        return tuple(one for one in self.streams if one.topic.split("/")[1] != MECHANISM_TOPIC[1:])

    @property
    def main(self) -> Stream:
        """Return the stream `/axis` or, if the log has a single stream, this stream.

        Raises LogError if the log has no stream, or several streams without `/axis`.
        """
        for stream in self.streams:
            if stream.topic == MAIN_TOPIC:
                return stream
        if len(self.streams) == 1:
            return self.streams[0]
        raise LogError(
            self.source,
            f"has no stream {MAIN_TOPIC}; found: "
            f"{', '.join(s.topic for s in self.streams) or 'nothing'}",
        )

    def require(self, stream: Stream, *names: str) -> tuple[Vector, ...]:
        """Return the named signals of a stream, each with shape (n,).

        Parameters
        ----------
        stream : Stream
            Stream of this log.
        *names : str
            Names of the required signals.

        Returns
        -------
        tuple of ndarray, shape (n,)
            The signals in the order of `names`, in SI.

        Raises
        ------
        LogError
            If a signal is missing. The message lists the missing signals and the stream's signals.
        """
        missing = [name for name in names if name not in stream.signals]
        if missing:
            raise LogError(
                self.source,
                f"stream {stream.topic} has no {' and no '.join(missing)}; found: "
                f"{', '.join(stream.signals)}",
            )
        return tuple(stream.signals[name] for name in names)
