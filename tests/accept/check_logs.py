"""Mutated input files of every format at full count: each is read or refused in one line; nothing else is raised, nothing takes long."""

from __future__ import annotations

from typing import Any

from tests.fuzz.__main__ import COUNT
from tests.fuzz.harness import fuzz


def mutated_inputs() -> dict[str, Any]:
    """20 000 of them, as `make fuzz`."""
    return fuzz(COUNT)


CHECKS = {"logs.fuzz": mutated_inputs}
