"""A controller as source code with golden vectors."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.export.export_result import ExportResult as ExportResult
    from frictool.export.export_result import export as export
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "ExportResult": "frictool.export.export_result",
            "export": "frictool.export.export_result",
        },
    )

__all__ = ["ExportResult", "export"]
