"""What the ending of an output's name says: the format, and which one it is not."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

# what frictool writes, the first ending the one that is proposed
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
TABLES = FORMATS["CSV"] + FORMATS["Parquet"]  # of many logs, a row each
# what somebody may take an output for
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
OTHERS += (".mat", ".npz", ".mf4", ".mdf", ".bag", ".db3", ".c", ".h", ".m", ".py", ".ipynb")


def says_file(target: Path) -> bool:
    """Whether the name ends as that of a file of some format, where a folder is to be made."""
    ending = target.suffix.lower()
    return not target.is_dir() and (
        ending in OTHERS or any(ending in endings for endings in FORMATS.values())
    )


def is_page(target: Path) -> bool:
    """Whether the name is that of an HTML page."""
    return target.suffix.lower() in FORMATS["HTML"]


def check_folder(target: Path, otherwise: str = "") -> None:
    """Raises click.UsageError where the name of a folder ends as that of a file; otherwise: what
    else may be named."""
    if target != Path("-") and says_file(target):
        raise click.UsageError(f"{target.name!r} ends as a file: name a folder{otherwise}.")


def check_ending(target: Path, writes: Sequence[str], chooses: bool, what: str = "") -> None:
    """Raises click.UsageError where the name of a file says another format than those of FORMATS
    that are written.

    chooses: it is the ending that says which of them, so that it has to be one of theirs. Without
    that a name may end in anything that is no other format's. Stdout, devices and pipes have no
    ending. what: of which output, where that is not plain.
    """
    if target == Path("-") or (target.exists() and not target.is_file()):
        return
    allowed = [ending for name in writes for ending in FORMATS[name]]
    found = target.suffix.lower()
    if found in allowed or not (chooses or says_file(target)):
        return
    proposed = " or ".join([", ".join(allowed[:-1]), allowed[-1]] if len(allowed) > 1 else allowed)
    said = "says another format" if found and not chooses else "does not say its format"
    raise click.UsageError(f"{target.name!r} {said}{what}: end it in {proposed}.")
