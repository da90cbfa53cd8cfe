"""Additional observer (observer.yaml), which runs along a log and writes a separate stream."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from frictool.documents.model import Model
from frictool.documents.observer import Observer
from frictool.documents.quantity import si_unit
from frictool.errors import DocumentError
from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.log import MAIN_TOPIC
from frictool.logs.stream_source import SampleBlock
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverOutput, ObserverRun
from frictool.observe.velocity_errors import VelocityErrors

TOPIC = f"{MAIN_TOPIC}/observer"
SAME_PERIOD = 1e-3  # relative tolerance of the sample period


class SecondObserver:
    """Additional observer, and the sums of its velocity errors."""

    def __init__(self, observer: Observer, cutoff: float) -> None:
        """Create the run; `cutoff`: cut-off [Hz] of the zero-phase velocity used for the errors."""
        self.observer = observer
        self._run = ObserverRun(observer)
        self._figures = VelocityErrors(cutoff, observer.sample_period_s)
        self._wear: float | None = None

    def take(self, piece: MotionBlock) -> ObserverOutput:
        """Process a block; return the observer's output at its samples."""
        output = self._run.take(piece)
        self._figures.take(piece.position, output.velocity, piece.velocity, piece.follows)
        self._wear = None if output.wear is None else float(output.wear[-1])
        return output

    @property
    def head(self) -> StreamHeader:
        """Return the names and units of the columns of the output stream.

        An additive observer has the column `added` (added friction) in place of `wear`.
        """
        axis, kind = self.observer.axis, self.observer.kind
        units = {
            name: si_unit(of, axis)
            for name, of in (
                ("position", "position"),
                ("velocity", "velocity"),
                ("friction", "effort"),
            )
        }
        if kind != "tracking":
            units |= {"added": si_unit("effort", axis)} if kind == "additive" else {"wear": "1"}
        return StreamHeader(TOPIC, tuple(units), tuple(units.values()))

    def as_json(self) -> dict[str, Any]:
        """Return kind, velocity errors, and the last estimate of wear or added friction."""
        figures = {
            name: value
            for name, value in self._figures.figures().items()
            if name in ("velocity_rms", "velocity_rms_true")
        }
        last = (
            {}
            if self._wear is None
            else {"added" if self.observer.kind == "additive" else "wear": self._wear}
        )
        return {"name": self.observer.name, "kind": self.observer.kind, **last, **figures}


def samples_of(output: ObserverOutput) -> SampleBlock:
    """Return an output as samples of the output stream."""
    wear = () if output.wear is None else (output.wear,)
    return SampleBlock(
        np.rint(output.time * NS).astype(np.int64),
        (output.position, output.velocity, output.friction, *wear),
    )


def check_observer(path: Path, observer: Observer, model: Model, period: float) -> None:
    """Raise DocumentError if the observer does not fit the model or the log.

    The observer must have the kind of axis of `model`, and the log's sample period, `period` [s].
    `path` is the file of the observer.
    """
    if observer.axis != model.axis:
        raise DocumentError(
            path, f"found {observer.axis}; the model's axis is {model.axis}", line=None, key="axis"
        )
    if abs(observer.sample_period_s / period - 1.0) > SAME_PERIOD:
        difference = (
            f"found {observer.sample_period_s:g} s; the log's period is {period:.6g} s; "
            "design the observer for this period"
        )
        raise DocumentError(path, difference, line=None, key="sample_period_s")
