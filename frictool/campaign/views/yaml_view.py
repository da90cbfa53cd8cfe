"""YAML view of a campaign: the JSON view with provenance."""

from __future__ import annotations

import msgspec

from frictool.campaign.statistics.findings import Findings
from frictool.campaign.views.json_view import as_json
from frictool.documents.provenance import Provenance
from frictool.documents.writing import tree_to_yaml
from frictool.presentation.json_text import finite


def as_document(findings: Findings, provenance: Provenance) -> str:
    """Return the campaign as YAML text, reproducible; absent or infinite values are null."""
    tree = {**as_json(findings), "provenance": msgspec.to_builtins(provenance)}
    return tree_to_yaml(finite(tree))
