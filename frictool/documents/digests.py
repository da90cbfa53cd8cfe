"""Digests of a controller's blocks: whether a document is the one that was verified.

The gain of a position law, a prefilter or a specified margin follows from the model, the
specification and the design. These are not in the document, and no figure of the linear loop
depends on the blocks, so that they cannot be checked by computation. A digest shows changes. No
proof uses it.
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
)  # fields without a digest: titles, and figures that `verify` computes again
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
    """Return the SHA-256 of each block of the document, by the name of the block.

    `header` holds the fields of one value at the top, `verified` those figures of `verified` that
    cannot be computed again. The digest is of the values of numbers, so that their spelling,
    comments and the layout of the file may change.
    """
    fields = msgspec.to_builtins(controller)
    blocks = {name: fields[name] for name in sorted(fields) if name not in (*UNTOUCHED, *HEADER)}
    blocks["header"] = {name: fields[name] for name in HEADER}
    blocks["verified"] = uncomputed_figures(controller.verified)
    return {name: _digest(block) for name, block in sorted(blocks.items())}


def uncomputed_figures(verified: Verified) -> dict[str, float]:
    """Return the figures of `verified` that `frictool verify` cannot compute again, by their key in
    the document."""
    found = {f"verified.{name}": getattr(verified, name) for name in GIVEN}
    if verified.robustness is not None:
        found |= {
            f"verified.robustness.{name}": getattr(verified.robustness, name) for name in SOLVED
        }
    return {key: value for key, value in found.items() if value is not None}


def with_digests(controller: Controller, *blocks: str) -> Controller:
    """Return the controller with the digests of its blocks as they are now.

    blocks: names of the blocks to digest, all by default; the other digests stay and still show an
    earlier change of their blocks.
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
    """Return the names of the blocks that were changed, added or removed since the controller was
    verified."""
    now, then = block_digests(controller), controller.verified.digests
    return tuple(name for name in sorted({*now, *then}) if now.get(name) != then.get(name))


def changed_words(controller: Controller) -> str:
    """Say which blocks were changed; empty if none was, or if the document has no digests."""
    changed = changed_blocks(controller) if controller.verified.digests else ()
    return (
        f"changed after it was verified: {', '.join(changed)}; `frictool verify` says what still holds"
        if changed
        else ""
    )


def _digest(block: Any) -> str:
    return hashlib.sha256(json.dumps(_plain(block), sort_keys=True).encode()).hexdigest()


def _plain(value: Any) -> Any:
    """Return the value with each number as a double and without empty keys, which another version's
    documents may omit."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items() if one is not None}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    return (
        float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else value
    )
