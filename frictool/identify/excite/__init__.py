"""Tests to run on a bench: one kind a file, each a function of what the bench can do; and what a test would tell (information.py)."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.identify.excite.kinds import Settings as Settings
    from frictool.identify.excite.kinds import excite as excite
    from frictool.identify.excite.sequence import Sequence as Sequence
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Sequence": "frictool.identify.excite.sequence",
            "Settings": "frictool.identify.excite.kinds",
            "excite": "frictool.identify.excite.kinds",
        },
    )

__all__ = ["Sequence", "Settings", "excite"]
