"""Loading of a mechanism.yaml; errors state file and line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from frictool.errors import DocumentError

if TYPE_CHECKING:
    from frictool.documents.mechanism import Mechanism
    from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
    from frictool.plant.mechanism.element_error import ElementError


def load_mechanism(path: Path) -> tuple[Mechanism, AssembledMechanism]:
    """Load the document at `path`; return the document and the assembled mechanism.

    Raises DocumentError with file, line and key.
    """
    from frictool.adapters.mechanism.assembly import assemble
    from frictool.documents.mechanism import Mechanism
    from frictool.documents.registry import load
    from frictool.plant.mechanism.element_error import ElementError

    document = load(path, Mechanism)
    try:
        return document, assemble(document)
    except ElementError as wrong:
        raise mechanism_error(path, wrong) from None


def print_notes(path: Path, assembled: AssembledMechanism) -> None:
    """Print on stderr the notes from the assembly of a mechanism."""
    from frictool.cli.console_output import note

    for message in assembled.notes:
        note(f"note: {path}: {message}")


def mechanism_error(path: Path, wrong: ElementError) -> DocumentError:
    """Return a DocumentError with the file and line of the element that `wrong` names."""
    from frictool.documents.key_lines import document_error

    return document_error(path, wrong.key, str(wrong))
