"""Conversion of frictool's documents to and from linear systems of python-control and scipy."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.systems.document_systems import controller_system as controller_system
    from frictool.systems.document_systems import loop_system as loop_system
    from frictool.systems.document_systems import plant_system as plant_system
    from frictool.systems.lti_conversion import as_lti as as_lti
    from frictool.systems.lti_conversion import to_control as to_control
    from frictool.systems.lti_conversion import to_scipy as to_scipy
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "document_systems": ["controller_system", "loop_system", "plant_system"],
            "lti_conversion": ["as_lti", "to_control", "to_scipy"],
        },
    )
