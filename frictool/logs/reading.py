"""Any log to a `Log` in memory: the canonical MCAP as it is, raw bench files through the bench's
mapping. The content tells the format."""

from __future__ import annotations

from pathlib import Path

from frictool.documents.bench import Bench
from frictool.logs.assembly import assemble, assemble_log
from frictool.logs.canonical.mcap_format import read_mcap
from frictool.logs.canonical.mcap_reader import is_canonical
from frictool.logs.log import Log


def read_log(path: Path | str, bench: Bench | None = None) -> Log:
    """The log at `path`. A raw file needs the bench, which a canonical log ignores.

    Raises LogError where the file cannot be read or mapped.
    """
    path = Path(path)
    return read_mcap(path) if is_canonical(path) else assemble_log(assemble([path], bench))
