"""Check of a document before the document is written: other commands must be able to read it."""

from __future__ import annotations

import re
from pathlib import Path


def check_document(target: Path, text: str) -> None:
    """Raise NoSolutionError if `text` is a YAML document that commands would refuse to read.

    A model must describe an axis that can be simulated. A text that is not a document is allowed.
    """
    named = re.match(r"(?:#.*\n|\s*\n)*format: (\w+)/\d+\n", text)
    if named is None:
        return
    from frictool.documents.document_reader import DocumentReader
    from frictool.documents.document_text import compose
    from frictool.documents.model import Model
    from frictool.documents.registry import DOCUMENTS
    from frictool.errors import DocumentError, NoSolutionError

    kind = DOCUMENTS.get(named[1])
    if kind is None:
        return
    try:
        document = DocumentReader(target).read(compose(text, target), kind, "")
        if isinstance(document, Model):
            from frictool.adapters.axis_model import axis_of

            axis_of(document)
    except (DocumentError, ValueError) as error:
        raise NoSolutionError(
            f"not written, because the document would be invalid: {error}"
        ) from None
