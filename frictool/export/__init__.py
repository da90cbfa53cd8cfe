"""Export of controllers as code and coefficients, and of models to simulators and drives."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.export.controller_export import ExportResult as ExportResult
    from frictool.export.controller_export import export as export
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__, {"controller_export": ["ExportResult", "export"]}
    )
