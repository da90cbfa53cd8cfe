"""Validation of a model: comparison of a simulation with a measured log."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.validate.validation import Validation as Validation
    from frictool.identify.validate.validation import ValidationRequest as ValidationRequest
    from frictool.identify.validate.validation import validate as validate
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__, {"validation": ["Validation", "ValidationRequest", "validate"]}
    )
