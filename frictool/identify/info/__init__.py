"""What a log holds, its quality, and which methods it can feed."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.identify.info.information import Information as Information
    from frictool.identify.info.information import info as info
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "Information": "frictool.identify.info.information",
            "info": "frictool.identify.info.information",
        },
    )

__all__ = ["Information", "info"]
