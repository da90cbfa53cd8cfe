"""Reading of any log file into memory; the content of the file determines its format."""

from __future__ import annotations

from pathlib import Path

from frictool.documents.bench import Bench
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.canonical.mcap_reader import is_canonical
from frictool.logs.log import Log
from frictool.logs.log_assembly import assemble, assemble_log


def read_log(path: Path | str, bench: Bench | None = None) -> Log:
    """Read a log into memory.

    A canonical log is read without changes. For a raw file, bench.yaml maps columns to channels.

    Parameters
    ----------
    path : Path or str
        Log file.
    bench : Bench, optional
        Bench for a raw file; not used for a canonical log.

    Returns
    -------
    Log
        The log, with time in s and signals in SI.

    Raises
    ------
    LogError
        If the file cannot be read or does not fit bench.yaml, or if a raw file is read without a
        bench.
    """
    path = Path(path)
    return read_mcap(path) if is_canonical(path) else assemble_log(assemble([path], bench))
