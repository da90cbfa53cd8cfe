"""Excitation tests for a bench, with the expected precision of the parameters."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.excite.excitation_kinds import ExcitationSettings as ExcitationSettings
    from frictool.identify.excite.excitation_kinds import excite as excite
    from frictool.identify.excite.excitation_sequence import (
        ExcitationSequence as ExcitationSequence,
    )
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "excitation_kinds": ["ExcitationSettings", "excite"],
            "excitation_sequence": ["ExcitationSequence"],
        },
    )
