"""Provenance of an output file: command, version of frictool and digest of each input.

The provenance contains no time and no absolute path.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

import msgspec

from frictool import __version__
from frictool.documents.writing import to_yaml


class Input(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Input file: base name and SHA-256.

    - `name`: Base name of the file.
    - `sha256`: SHA-256 of its content, in hexadecimal digits.
    """

    name: str
    sha256: str


class Provenance(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Command line (without `-o`, base names only), frictool version and digest of each input.

    - `command`: Command line that wrote the file.
    - `frictool`: Version of frictool.
    - `inputs`: Input files.
    """

    command: str
    frictool: str
    inputs: tuple[Input, ...] = ()


def digest(path: Path) -> str:
    """Return the SHA-256 of a file as hexadecimal digits; the file is read in blocks."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def provenance_of_call(function: str, **documents: msgspec.Struct | None) -> Provenance:
    """Return the provenance of a result that a function computed from documents in memory.

    The documents' digests equal the digests of the files that `save` would write.
    """
    texts = {
        name: to_yaml(document) for name, document in documents.items() if document is not None
    }
    inputs = tuple(
        Input(f"{name}.yaml", hashlib.sha256(text.encode()).hexdigest())
        for name, text in texts.items()
    )
    return Provenance(f"{function}() in Python", __version__, inputs)


def provenance_of_command(command: str, inputs: list[Path]) -> Provenance:
    """Return the provenance of a file that `command` made from the files `inputs`."""
    return Provenance(
        readable(command),
        __version__,
        tuple(Input(readable(path.name), digest(path)) for path in inputs),
    )


def readable(text: str) -> str:
    """Return the text with undecodable bytes replaced by escapes.

    File names are bytes. No file format can store bytes that Python could not decode.
    """
    return text.encode(errors="backslashreplace").decode()
