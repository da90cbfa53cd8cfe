"""A mechanism.yaml read and put together; what does not fit is told with its file and line."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from frictool.errors import DocumentError

if TYPE_CHECKING:
    from frictool.documents.mechanism import Mechanism
    from frictool.plant.mechanism.assembly import Assembled
    from frictool.plant.mechanism.wrong import WrongElement


def load_mechanism(path: Path) -> tuple[Mechanism, Assembled]:
    """The document at `path` and the mechanism put together. Raises DocumentError with file, line and key."""
    from frictool.documents.mechanism import Mechanism
    from frictool.documents.registry import load
    from frictool.plant.mechanism.assembly import assemble
    from frictool.plant.mechanism.wrong import WrongElement

    document = load(path, Mechanism)
    try:
        return document, assemble(document)
    except WrongElement as wrong:
        raise wrong_in_file(path, wrong) from None


def tell_notes(path: Path, assembled: Assembled) -> None:
    """What was left out or does not fit, on stderr."""
    from frictool.cli.output import note

    for told in assembled.notes:
        note(f"note: {path}: {told}")


def wrong_in_file(path: Path, wrong: WrongElement) -> DocumentError:
    """The same complaint, with the file and the line of the element."""
    from frictool.documents.lines import complaint

    return complaint(path, wrong.key, str(wrong))
