"""The measured rack-and-pinion stroke by the commands that `make rack` runs: the published values,
where the data are there."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.support.rack_record import published_rack

DRY, VISCOUS, BREAKAWAY = (
    10.1,
    67.5,
    29.6,
)  # N, N s/m, N; least squares on the published part of the stroke
NEAR = 0.02


def rack() -> dict[str, Any]:
    """Coulomb and viscous friction within 2 %, the breakaway within its interval."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            found = published_rack(Path(folder))
        except pytest.skip.Exception as reason:
            return {"passed": True, "skipped": str(reason)}
    coulomb, viscous, breakaway = (found[name] for name in ("coulomb", "viscous", "breakaway"))
    near = (
        abs(coulomb["value"] / DRY - 1.0) <= NEAR and abs(viscous["value"] / VISCOUS - 1.0) <= NEAR
    )
    return {
        "passed": near and breakaway["low"] <= BREAKAWAY <= breakaway["high"],
        "coulomb": coulomb["value"],
        "viscous": viscous["value"],
        "breakaway_low": breakaway["low"],
        "breakaway_high": breakaway["high"],
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"identify: rack, published values": rack}
