"""Where an artefact comes from: the command, the version, and the digest of each input. No clock,
no absolute path."""

from __future__ import annotations

import hashlib
from pathlib import Path

import msgspec

from frictool import __version__
from frictool.documents.writing import to_yaml


class Input(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An input file: its base name and its SHA-256."""

    name: str
    sha256: str


class Provenance(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The command line (without `-o`, base names only), the frictool version and each input's
    digest."""

    command: str
    frictool: str
    inputs: tuple[Input, ...] = ()


def digest(path: Path) -> str:
    """SHA-256 of a file, read in blocks."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def provenance_of_call(function: str, **documents: msgspec.Struct | None) -> Provenance:
    """The provenance of what a function made of documents in memory; their digests are those of the
    files that they are saved as."""
    given = {
        name: to_yaml(document) for name, document in documents.items() if document is not None
    }
    inputs = tuple(
        Input(f"{name}.yaml", hashlib.sha256(text.encode()).hexdigest())
        for name, text in given.items()
    )
    return Provenance(f"{function}() in Python", __version__, inputs)


def provenance_of_command(command: str, inputs: list[Path]) -> Provenance:
    """The provenance of an artefact made by `command` from `inputs`."""
    return Provenance(
        readable(command),
        __version__,
        tuple(Input(readable(path.name), digest(path)) for path in inputs),
    )


def readable(text: str) -> str:
    """The same where it is text. Names of files are bytes, and what Python could not decode in one
    no format can hold: it is escaped."""
    return text.encode(errors="backslashreplace").decode()
