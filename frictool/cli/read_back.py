"""Read every document back before it is written: what the next command would refuse is not left behind."""

from __future__ import annotations

import re
from pathlib import Path


def check_document(target: Path, text: str) -> None:
    """Read `text`, which is to be written to `target`, as the next command does; text of another kind passes.

    A model has to describe an axis that the simulation takes. Raises NoSolutionError with what is wrong.
    """
    named = re.match(r"(?:#.*\n|\s*\n)*format: (\w+)/\d+\n", text)
    if named is None:
        return
    from frictool.documents.model import Model
    from frictool.documents.reading import Reader, compose
    from frictool.documents.registry import DOCUMENTS
    from frictool.errors import DocumentError, NoSolutionError

    kind = DOCUMENTS.get(named[1])
    if kind is None:
        return
    try:
        document = Reader(target).read(compose(text, target), kind, "")
        if isinstance(document, Model):
            from frictool.plant.axis_model import axis_of

            axis_of(document)
    except (DocumentError, ValueError) as error:
        raise NoSolutionError(f"not written, since no command would read it: {error}") from None
