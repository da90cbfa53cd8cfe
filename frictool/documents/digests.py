"""Digests of a controller's blocks, to detect changes after the controller's verification.

No property of the linear loop depends on the gain of a position law, on the prefilter or on the
specified margin. Therefore only a digest reveals a change of these values. Proofs do not use
digests.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

import msgspec

from frictool.documents.controller import Controller, Verified

UNTOUCHED = (
    "format",
    "name",
    "provenance",
    "verified",
)  # fields without a digest: titles, and figures that `verify` recomputes
HEADER = (
    "axis",
    "structure",
    "method",
    "domain",
    "sample_period_s",
    "delay_samples",
    "drive",
    "drive_limit",
    "sign_convention",
)
GIVEN = (
    "gamma_asked",
    "modulus_margin_specified",
)  # fields of `verified` that follow from the design and the specification
SOLVED = (
    "structured",
    "parameter_dependent",
    "common",
)  # fields of `verified.robustness` that need a solver


def block_digests(controller: Controller) -> dict[str, str]:
    """Return the SHA-256 of each block of a controller, by the name of the block.

    The digest `header` is computed from the scalar fields at the top level of the document. The
    digest `verified` is computed from those values under `verified` that `frictool verify` cannot
    recompute. Digests are computed from values. Number format, comments and layout of the file do
    not affect them.
    """
    fields = msgspec.to_builtins(controller)
    blocks = {name: fields[name] for name in sorted(fields) if name not in (*UNTOUCHED, *HEADER)}
    blocks["header"] = {name: fields[name] for name in HEADER}
    blocks["verified"] = uncomputed_figures(controller.verified)
    return {name: _digest(block) for name, block in sorted(blocks.items())}


def uncomputed_figures(verified: Verified) -> dict[str, float]:
    """Return the values under `verified` that `frictool verify` cannot recompute, by key."""
    figures = {f"verified.{name}": getattr(verified, name) for name in GIVEN}
    if verified.robustness is not None:
        figures |= {
            f"verified.robustness.{name}": getattr(verified.robustness, name) for name in SOLVED
        }
    return {key: value for key, value in figures.items() if value is not None}


def with_digests(controller: Controller, *blocks: str) -> Controller:
    """Return a copy of the controller with new digests of its blocks.

    blocks: names of the blocks for which digests are computed; by default, all blocks.

    The digests of all other blocks are kept, so that earlier changes of those blocks are still
    detected.
    """
    now = block_digests(controller)
    kept = (
        {name: value for name, value in controller.verified.digests.items() if name not in blocks}
        if blocks
        else {}
    )
    made = {name: value for name, value in now.items() if not blocks or name in blocks}
    verified = msgspec.structs.replace(
        controller.verified, digests=dict(sorted((kept | made).items()))
    )
    return msgspec.structs.replace(controller, verified=verified)


def changed_blocks(controller: Controller) -> tuple[str, ...]:
    """Return the names of the blocks that were changed, added or removed since verification."""
    now = block_digests(controller)
    then = controller.verified.digests
    return tuple(name for name in sorted({*now, *then}) if now.get(name) != then.get(name))


def changed_words(controller: Controller) -> str:
    """Return a message on the changed blocks.

    The message is empty if no block changed, or if the controller has no digests.
    """
    changed = changed_blocks(controller) if controller.verified.digests else ()
    return (
        (
            f"changed after it was verified: {', '.join(changed)}; `frictool verify` lists the "
            "properties that still hold"
        )
        if changed
        else ""
    )


def _digest(block: Any) -> str:
    return hashlib.sha256(json.dumps(_plain(block), sort_keys=True).encode()).hexdigest()


def _plain(value: Any) -> Any:
    """Return the value with numbers as doubles, and without keys whose value is None.

    Documents of another version may omit such keys.
    """
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items() if one is not None}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    return (
        float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else value
    )
