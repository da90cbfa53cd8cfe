"""Provenance of simulated logs in tests."""

from __future__ import annotations

from frictool.documents.provenance import Input, Provenance

HERE = Provenance("frictool simulate", "0", (Input("model.yaml", "ab" * 32),))
