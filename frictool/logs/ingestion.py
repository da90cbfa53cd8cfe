"""Conversion of raw log files to one canonical log (the work of `frictool ingest`)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import BinaryIO

from msgspec.structs import replace

from frictool.documents.bench import Bench
from frictool.documents.provenance import Input, Provenance, digest, provenance_of_call, readable
from frictool.errors import FrictoolError
from frictool.logs.canonical.mcap_layout import DATE, KIND, NS, UNIT, StreamHeader
from frictool.logs.log_assembly import EVERYTHING, LogAssembly, TimeWindow, assemble, write
from frictool.logs.log_from_arrays import new_file
from frictool.logs.provenance import PROVENANCE, provenance_record
from frictool.logs.quality.log_kinds import KINDS, TEST
from frictool.logs.quality.time_base import TimeBase
from frictool.logs.recordings.recording_files import sources
from frictool.runtime.object_view import ResultView


@dataclass(frozen=True)
class IngestRequest:
    """Options of a conversion of raw log files to a canonical log.

    Attributes
    ----------
    window : TimeWindow
        Part of the log's time that is kept; `TimeWindow.between(2.0, 5.0)` keeps 2 s to 5 s.
    period_s : float or None
        Sample period [s] to which all streams are resampled on one time grid; None to keep the
        samples.
    kind : str or None
        Kind of test, a key of KINDS; None to use the kind that `info` recognises.
    unit : str or None
        Serial number of the actuator.
    date : str or None
        Date of the recording (ISO 8601); None to use the date in the files, if any.
    salvage : bool
        If True, the readable part of a damaged file is kept; if False, damage raises LogError.
    """

    window: TimeWindow = EVERYTHING
    period_s: float | None = None
    kind: str | None = None
    unit: str | None = None
    date: str | None = None
    salvage: bool = False

    def check(self) -> None:
        """Raise FrictoolError if an option has a value that is not allowed."""
        if self.period_s is not None and not 1e-6 <= self.period_s <= 10.0:
            raise FrictoolError(f"period_s: found {self.period_s:g} s; allowed: 1e-6 s to 10 s")
        if self.kind is not None and self.kind not in KINDS:
            raise FrictoolError(f"kind: found {self.kind!r}; allowed: {', '.join(KINDS)}")
        try:
            datetime.fromisoformat(self.date or "2000-01-01")
        except ValueError:
            raise FrictoolError(
                f"date: found {self.date!r}; allowed: 2026-01-03 or 2026-01-03T08:15:00"
            ) from None

    @property
    def facts(self) -> dict[str, str]:
        """Return the requested kind, unit and date as entries of the metadata record `log`."""
        entries = ((TEST, self.kind), (UNIT, self.unit), (DATE, self.date))
        return {key: text for key, text in entries if text}


USUAL = IngestRequest()


@dataclass(frozen=True, eq=False, repr=False)
class IngestedLog(ResultView):
    """Result of `ingest`.

    streams: header and time base of each written stream.
    assembly: the streams as read from the files, with their warnings and losses.
    """

    streams: tuple[tuple[StreamHeader, TimeBase], ...]
    assembly: LogAssembly


def ingest(
    paths: Sequence[Path | str],
    target: Path | str,
    bench: Bench | None = None,
    request: IngestRequest = USUAL,
) -> IngestedLog:
    """Convert raw log files of one rig to a canonical log (MCAP), in bounded memory.

    Parameters
    ----------
    paths : sequence of Path or str
        Files of any format that frictool reads. The first file becomes `/axis`, each other file
        becomes `/axis/NAME`.
    target : Path or str
        File to write. After an error, the file is unchanged.
    bench : Bench, optional
        Bench with `columns` that describe the files; not needed for canonical logs.
    request : IngestRequest
        Options of the conversion.

    Returns
    -------
    IngestedLog
        Headers and time bases of the written streams. `assembly.warnings` and `assembly.losses`
        list the defects of the files.

    Raises
    ------
    LogError
        If a file cannot be read or does not fit bench.yaml, or if no sample is in the window.
    OutputError
        If the target cannot be written.
    FrictoolError
        If the request has a value that is not allowed.
    """
    request.check()
    files = [Path(path) for path in paths]
    made = assemble(files, bench, request.salvage)
    origin = provenance_of_call("frictool.logs.ingest", bench=bench)
    read = tuple(
        Input(readable(path.name), digest(path)) for parts in sources(files) for path in parts
    )
    with new_file(Path(target)) as stream:
        return write_assembly(made, stream, request, replace(origin, inputs=read + origin.inputs))


def write_assembly(
    made: LogAssembly,
    stream: BinaryIO,
    request: IngestRequest,
    provenance: Provenance,
    tick: Callable[[float], None] = lambda part: None,
) -> IngestedLog:
    """Write the requested part of the assembled streams and the metadata of the request.

    tick: callback that receives the completed fraction, 0 to 1.

    Raises LogError if a sample cannot be read, or if no sample is in the requested window.
    """
    notes = {PROVENANCE: provenance_record(provenance)}
    if request.facts:
        notes[KIND] = {**made.notes.get(KIND, {}), **request.facts}
    period_ns = None if request.period_s is None else round(request.period_s * NS)
    streams = write(made, stream, notes, request.window, period_ns, tick)
    return IngestedLog(tuple(streams), made)
