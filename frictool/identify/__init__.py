"""Logs to parameters with intervals, one method per file."""

from typing import TYPE_CHECKING

from frictool.exports import lazily

if TYPE_CHECKING:
    from frictool.identify.from_logs import Identified as Identified
    from frictool.identify.from_logs import identify as identify
    from frictool.identify.identification import NothingIdentified as NothingIdentified
    from frictool.identify.methods import METHODS as METHODS
    from frictool.identify.methods import Settings as Settings
else:
    __getattr__, __dir__ = lazily(
        __name__,
        {
            "Identified": "frictool.identify.from_logs",
            "METHODS": "frictool.identify.methods",
            "NothingIdentified": "frictool.identify.identification",
            "Settings": "frictool.identify.methods",
            "identify": "frictool.identify.from_logs",
        },
    )

__all__ = ["METHODS", "Identified", "NothingIdentified", "Settings", "identify"]
