"""A controller as source code with golden vectors."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.export.exported import Exported as Exported
    from frictool.export.exported import export as export
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Exported": "frictool.export.exported",
            "export": "frictool.export.exported",
        },
    )

__all__ = ["Exported", "export"]
