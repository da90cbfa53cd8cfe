"""A mechanism from the text of its document."""

from __future__ import annotations

import tempfile
from pathlib import Path

from frictool.documents.mechanism import Mechanism
from frictool.documents.registry import load


def mechanism(text: str) -> Mechanism:
    """The document that the text says."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mechanism.yaml"
        path.write_text(text)
        return load(path, Mechanism)
