"""Identification of friction, breakaway and inertia of an axis from logs, with intervals.

Docstrings state the units of a rotary and of a linear axis separated by |, as in "rad | m".
"""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.from_logs import IdentifiedModel as IdentifiedModel
    from frictool.identify.from_logs import identify as identify
    from frictool.identify.identification import NothingIdentified as NothingIdentified
    from frictool.identify.methods import METHODS as METHODS
    from frictool.identify.methods import IdentificationRequest as IdentificationRequest
    from frictool.identify.methods import IdentificationSettings as IdentificationSettings
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "from_logs": ["IdentifiedModel", "identify"],
            "identification": ["NothingIdentified"],
            "methods": ["IdentificationRequest", "IdentificationSettings", "METHODS"],
        },
    )
