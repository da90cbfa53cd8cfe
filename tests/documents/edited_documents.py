"""A golden document with one line changed, and what its refusal says."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents.registry import load
from frictool.errors import DocumentError


def refusal(golden: Path, old: str, new: str, kind: type, folder: Path) -> DocumentError:
    """Why `golden` is refused where `new` stands in place of its first `old`; the message begins
    with the path."""
    text = golden.read_text()
    assert old in text
    path = folder / golden.name
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(DocumentError) as caught:
        load(path, kind)
    assert str(caught.value).startswith(f"{path}:")
    return caught.value
