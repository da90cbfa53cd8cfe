"""Meanings of the keys of documents, for the JSON Schemas and for docs/reference.

The docstring of a struct is a summary and a list of keys. An item explains one key or several:
"- `low`, `high`: Ends of the interval." COMMON explains the keys that have the same meaning in all
documents.
"""

from __future__ import annotations

import inspect
import re
import typing
from typing import Any

import msgspec

from frictool.documents.struct_fields import hints_of

COMMON = {
    "format": "Kind of document and version of its layout.",
    "name": "Name for titles and reports.",
    "axis": "Kind of axis; it decides the SI units of all mechanical quantities.",
    "drive": "Signal that drives the actuator.",
    "sample_period_s": "Sample period of the controller.",
    "delay_samples": "Computational delay between a sample and the command computed from it.",
    "examples": "Keys whose values are still examples of `frictool init`; remove a key when you "
    "have replaced its value.",
    "bench": "Exact copy of the bench.",
    "provenance": "Command, version and input digests of this document.",
    "inertia": "Inertia.",
    "viscous": "Viscous friction: effort per speed.",
    "coulomb": "Coulomb friction: effort in slip, independent of the speed.",
    "breakaway": "Effort at which the axis starts to move.",
    "constant": "Effort per ampere or volt of the drive.",
    "low": "Lower end.",
    "high": "Upper end.",
    "at_s": "Time from the start of the scenario.",
    "duration_s": "Duration.",
    "frequency_hz": "Frequency of a sine.",
    "phase_deg": "Phase of a sine at its start.",
    "between": "Names of the two ends, the driving end first; `ground` is the frame.",
    "efficiency": "Fraction of the power at the first end that reaches the second end.",
    "efficiency_back": "Fraction of the power at the second end that reaches the first end. The "
    "default is 2 - 1/efficiency. If the value is 0 or less, the load cannot drive the link.",
    "compliance": "Elasticity of the link. By default the link is rigid.",
    "backlash": "Free play of the link. By default, the link has no backlash.",
}
ITEM = re.compile(r"^- ((?:`\w+`(?:, )?)+): (.+(?:\n  .+)*)$", re.MULTILINE)


def summary_of(kind: type[msgspec.Struct]) -> str:
    """Return the docstring of a document type without its list of keys, one line per paragraph."""
    text = ITEM.sub("", inspect.cleandoc(kind.__doc__ or "")).strip()
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in re.split(r"\n\s*\n", text))


def meanings_of(kind: type[msgspec.Struct]) -> dict[str, str]:
    """Return the meaning of each key that the docstring of the type or COMMON explains."""
    meanings = {
        key: " ".join(text.split())
        for keys, text in ITEM.findall(inspect.cleandoc(kind.__doc__ or ""))
        for key in re.findall(r"`(\w+)`", keys)
    }
    return {
        key: meanings.get(key) or COMMON[key]
        for key in kind.__struct_fields__
        if key in meanings or key in COMMON
    }


def structs_of(kind: Any, collected: list[type[msgspec.Struct]] | None = None) -> list[Any]:
    """Return the document types that a type contains, in the order of their first use."""
    collected = [] if collected is None else collected
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct) and kind not in collected:
        collected.append(kind)
        for hint in hints_of(kind).values():
            structs_of(hint, collected)
    for part in typing.get_args(kind):
        structs_of(part, collected)
    return collected
