"""Survey of a log: contents, quality, and the methods that can use the log."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.info.log_information import Information as Information
    from frictool.identify.info.log_information import info as info
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__, {"log_information": ["Information", "info"]}
    )
