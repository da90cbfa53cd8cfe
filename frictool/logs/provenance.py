"""Provenance of a log (command, version and input files), stored as a metadata record."""

from __future__ import annotations

from dataclasses import replace

from frictool.documents.provenance import Provenance
from frictool.logs.log import Log

PROVENANCE = "provenance"  # metadata record: command, frictool, input_1, input_2, ...


def provenance_record(provenance: Provenance) -> dict[str, str]:
    """Return the entries of the metadata record `provenance`."""
    inputs = {
        f"input_{number}": f"{one.name} sha256:{one.sha256}"
        for number, one in enumerate(provenance.inputs, start=1)
    }
    return {"command": provenance.command, "frictool": provenance.frictool, **inputs}


def with_provenance(log: Log, provenance: Provenance) -> Log:
    """Return a copy of the log with the metadata record `provenance`."""
    return replace(log, metadata={**log.metadata, PROVENANCE: provenance_record(provenance)})
