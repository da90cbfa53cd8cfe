"""A log's provenance as an MCAP metadata record."""

from __future__ import annotations

from dataclasses import replace

from frictool.documents.provenance import Provenance
from frictool.logs.log import Log

PROVENANCE = "provenance"  # metadata record: command, frictool, input_1, input_2, ...


def with_provenance(log: Log, provenance: Provenance) -> Log:
    """The same log, made by this command from these inputs."""
    inputs = {f"input_{number}": f"{one.name} sha256:{one.sha256}" for number, one in enumerate(provenance.inputs, start=1)}
    entries = {"command": provenance.command, "frictool": provenance.frictool, **inputs}
    return replace(log, metadata={**log.metadata, PROVENANCE: entries})
