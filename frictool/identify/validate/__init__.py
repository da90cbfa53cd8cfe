"""Compare a model with a measured log."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.validate.against_log import validate as validate
    from frictool.identify.validate.validation import Validation as Validation
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "Validation": "frictool.identify.validate.validation",
            "validate": "frictool.identify.validate.against_log",
        },
    )

__all__ = ["Validation", "validate"]
