"""Excitation sequence: a reference for the position loop, or a drive command, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import drive_dimension, si_unit
from frictool.errors import NoSolutionError
from frictool.logs.canonical.mcap_layout import NS, StreamHeader
from frictool.logs.conversion import OutgoingStream
from frictool.logs.log import EXCITATION, MAIN_TOPIC, Log, Stream
from frictool.logs.stream_source import SampleBlock
from frictool.runtime.object_view import ResultView
from frictool.typing import Vector

LONGEST = 3600.0  # s, longest test whose duration the user has not chosen
MOST_SAMPLES = 10_000_000  # samples of the longest test; a longer test is probably due to an error


@dataclass(frozen=True, eq=False, repr=False)
class ExcitationSequence(ResultView):
    """Test sequence with one row per sample.

    - period: sample period, s
    - columns: samples (n,) of each signal by its name, SI units
    - rule: instruction for playing the sequence, as text
    - figures: numbers that describe the test, by name
    """

    kind: str
    period: float
    columns: dict[str, Vector]
    units: dict[str, str]
    rule: str
    figures: dict[str, float] = field(default_factory=dict)

    @property
    def time(self) -> Vector:
        """Return the time (n,) of each sample, s."""
        return np.asarray(np.arange(self.samples) * self.period, dtype=np.float64)

    @property
    def samples(self) -> int:
        """Return the number of samples."""
        return next(iter(self.columns.values())).size

    @property
    def duration(self) -> float:
        """Return the duration of the sequence, s."""
        return self.samples * self.period

    def as_log(self, source: str) -> Log:
        """Return the sequence as a log, with `rule` and `figures` as metadata."""
        about = {
            "kind": self.kind,
            "rule": self.rule,
            **{name: repr(float(value)) for name, value in self.figures.items()},
        }
        return Log(
            (Stream(MAIN_TOPIC, self.time, self.columns, self.units),), {EXCITATION: about}, source
        )

    def outgoing(self) -> OutgoingStream:
        """Return the sequence as a stream that can be written in the formats of other tools."""
        head = StreamHeader(
            MAIN_TOPIC, tuple(self.columns), tuple(self.units[name] for name in self.columns)
        )
        samples = SampleBlock(
            np.rint(self.time * NS).astype(np.int64), tuple(self.columns.values())
        )
        return OutgoingStream(head, iter([samples]))


def check_samples(duration: float, period: float, remedy: str = "shorten the test") -> None:
    """Raise NoSolutionError if a test of `duration` [s] has more than MOST_SAMPLES samples.

    - period: sample period, s
    - remedy: text on what to do
    """
    if duration > MOST_SAMPLES * period:
        raise NoSolutionError(
            f"duration: {duration:.4g} s is {duration / period:.3g} samples; "
            f"allowed: at most {MOST_SAMPLES:g}; {remedy}"
        )


def reference_sequence(
    kind: str, bench: Bench, motion: tuple[Vector, Vector, Vector], figures: dict[str, float]
) -> ExcitationSequence:
    """Return a sequence with the reference position, velocity and acceleration, each (n,)."""
    position, velocity = si_unit("position", bench.axis), si_unit("velocity", bench.axis)
    names = ("reference", "reference_velocity", "reference_acceleration")
    units = dict(zip(names, (position, velocity, f"{velocity}^2"), strict=True))
    rule = (
        f"start at rest at {motion[0][0]:.6g} {position}; the position loop follows "
        "`reference`, one row a sample"
    )
    return ExcitationSequence(
        kind, bench.sample_period_s, dict(zip(names, motion, strict=True)), units, rule, figures
    )


def command_sequence(
    bench: Bench, command: Vector, segment: Vector, rule: str, figures: dict[str, float]
) -> ExcitationSequence:
    """Return a sequence of drive commands (n,) with the segment number (n,) of each sample."""
    drive = bench.actuator.drive
    units = {drive: si_unit(drive_dimension(drive, constant=False), bench.axis), "segment": "1"}
    return ExcitationSequence(
        "breakaway",
        bench.sample_period_s,
        {drive: command, "segment": segment},
        units,
        rule,
        figures,
    )
