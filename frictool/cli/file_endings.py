"""Endings of output names, and the file formats that they stand for."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from frictool.logs.channels.question import alternatives
from frictool.logs.formats import FORMATS as LOG_FORMATS

# formats that frictool writes; the first ending is the proposed one
FORMATS = {
    "YAML": (".yaml", ".yml"),
    "HTML": (".html", ".htm"),
    "MCAP": (".mcap",),
    "CSV": (".csv",),
    "Parquet": (".parquet", ".pq"),
    "SVG": (".svg",),
    "JSON": (".json",),
    "XML": (".xml",),
    "Markdown": (".md",),
    "text": (".txt",),
    "LaTeX": (".tex",),
}
TABLES = FORMATS["CSV"] + FORMATS["Parquet"]  # tables with one row per log
# endings of formats that frictool does not write
OTHERS: tuple[str, ...] = (
    ".pdf",
    ".png",
    ".jpg",
    ".jpeg",
    ".eps",
    ".xls",
    ".xlsx",
    ".ods",
    ".doc",
    ".docx",
    ".zip",
    ".tar",
    ".gz",
)
OTHERS += (".c", ".h", ".m", ".py", ".ipynb")
OTHERS += tuple(suffix for one in LOG_FORMATS for suffix in one.suffixes)


def says_file(target: Path) -> bool:
    """Return True if the name has the ending of a file format and no folder has this name."""
    ending = target.suffix.lower()
    return not target.is_dir() and (
        ending in OTHERS or any(ending in endings for endings in FORMATS.values())
    )


def is_page(target: Path) -> bool:
    """Return True if the name has the ending of an HTML page."""
    return target.suffix.lower() in FORMATS["HTML"]


def check_folder(target: Path, otherwise: str = "") -> None:
    """Raise click.UsageError if the name of an output folder has the ending of a file.

    `otherwise`: text at the end of the message about other allowed outputs.
    """
    if target != Path("-") and says_file(target):
        raise click.UsageError(
            f"{target.name!r} has the ending of a file; name a folder{otherwise}."
        )


def check_ending(target: Path, writes: Sequence[str], chooses: bool, what: str = "") -> None:
    """Raise click.UsageError if the ending of `target` stands for a format that is not in `writes`.

    - writes: names of formats in FORMATS
    - chooses: True if the ending selects the format, so that an ending is required. Stdout, devices
      and pipes are allowed without ending
    - what: text that names the output in the message
    """
    if target == Path("-") or (target.exists() and not target.is_file()):
        return
    allowed = [ending for name in writes for ending in FORMATS[name]]
    suffix = target.suffix.lower()
    if suffix in allowed or not (chooses or says_file(target)):
        return
    said = "has another ending" if suffix and not chooses else "states no format"
    raise click.UsageError(
        f"{target.name!r} {said}{what}; allowed endings: {alternatives(allowed)}."
    )
