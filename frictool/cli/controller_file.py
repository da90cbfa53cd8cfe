"""Reading a controller document that a command is about to rely on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from frictool.cli.output import note

if TYPE_CHECKING:
    from frictool.documents.controller import Controller


def load_controller(path: Path) -> Controller:
    """Read a controller; warn if a block of it is not the one that was verified. A document without digests says nothing of that."""
    from frictool.documents.controller import Controller
    from frictool.documents.digests import changed_blocks
    from frictool.documents.registry import load

    controller = load(path, Controller)
    changed = changed_blocks(controller) if controller.verified.digests else ()
    if changed:
        note(f"warning: {path}: changed after it was verified: {', '.join(changed)}; `frictool verify` says what still holds")
    return controller
