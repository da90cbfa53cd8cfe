"""Files of the measured data, which are not part of the repository."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from studies.rigs.identification_rigs import ROOT


def data(*parts: str) -> Path:
    """Return the path of a file of the measured data; skip the test if there is none."""
    folder = Path(os.environ.get("FRICTOOL_DATA", ROOT.parent / "shared" / "data"))
    path = folder.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"measured data not found: {'/'.join(parts)} (set FRICTOOL_DATA to its folder)")
    return path
