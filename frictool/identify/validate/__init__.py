"""A model against a measured log."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.identify.validate.against_log import validate as validate
    from frictool.identify.validate.validation import Validation as Validation
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Validation": "frictool.identify.validate.validation",
            "validate": "frictool.identify.validate.against_log",
        },
    )

__all__ = ["Validation", "validate"]
