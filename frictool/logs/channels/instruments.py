"""Selection of the columns, layout and sample period of the instrument that recorded a file."""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import msgspec

from frictool.documents.bench import Bench, ClockEstimate
from frictool.errors import LogError
from frictool.logs.canonical.mcap_layout import NS


@dataclass(frozen=True)
class InstrumentBench:
    """Bench with the keys that apply to the files of one instrument.

    name: name of the instrument in bench.yaml; None if the file belongs to no instrument.
    bench: bench with the instrument's columns, layout, quadrature encoders and sample period.
    ahead_ns: time in ns by which the instrument's clock leads the log's clock, from the key
        `clock_offset`; 0 without this key.
    estimate: settings for the estimation of this lead from the samples; None if the lead is not
        estimated.
    """

    name: str | None
    bench: Bench
    ahead_ns: int = 0
    estimate: ClockEstimate | None = None


def view_of(path: Path, bench: Bench) -> InstrumentBench:
    """Return the bench with the columns of the instrument that recorded a file.

    The name of the file determines the instrument. Raises LogError if the name fits several
    instruments.
    """
    fitting = {
        name: one
        for name, one in (bench.instruments or {}).items()
        if fnmatchcase(path.name, one.files)
    }
    if not fitting:
        return InstrumentBench(None, bench)
    if len(fitting) > 1:
        raise LogError(
            path,
            f"matches `files` of several instruments of bench {bench.name!r}: "
            f"{', '.join(fitting)}; write `files` patterns that exclude each other",
        )
    ((name, one),) = fitting.items()
    seen = msgspec.structs.replace(
        bench,
        columns=one.columns,
        layout=one.layout or bench.layout,
        quadrature=one.quadrature,
        sample_period_s=one.sample_period_s or bench.sample_period_s,
    )
    ahead = 0 if one.clock_offset is None else round(one.clock_offset.value * NS)
    return InstrumentBench(name, seen, ahead, one.clock_estimate)
