"""Tests to run on a bench: one kind a file, each a function of what the bench can do; and what a
test would tell (information.py)."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.excite.excitation_kinds import ExcitationSettings as ExcitationSettings
    from frictool.identify.excite.excitation_kinds import excite as excite
    from frictool.identify.excite.excitation_sequence import (
        ExcitationSequence as ExcitationSequence,
    )
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "ExcitationSequence": "frictool.identify.excite.excitation_sequence",
            "ExcitationSettings": "frictool.identify.excite.excitation_kinds",
            "excite": "frictool.identify.excite.excitation_kinds",
        },
    )

__all__ = ["ExcitationSequence", "ExcitationSettings", "excite"]
