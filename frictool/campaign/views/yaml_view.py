"""YAML view of a campaign: the JSON view with provenance."""

from __future__ import annotations

import math
from typing import Any

import msgspec

from frictool.campaign.statistics.findings import Findings
from frictool.campaign.views.json_view import as_json
from frictool.documents.provenance import Provenance
from frictool.documents.writing import tree_to_yaml


def as_document(found: Findings, provenance: Provenance) -> str:
    """Return the YAML text; the same inputs give the same bytes.

    An absent or infinite value is null.
    """
    tree = {**as_json(found), "provenance": msgspec.to_builtins(provenance)}
    return tree_to_yaml(_finite(tree))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
