"""Logs in memory, their readers and writers, and the mapping of raw columns to channels."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.logs.in_memory import log_of as log_of
    from frictool.logs.in_memory import write_log as write_log
    from frictool.logs.log import Log as Log
    from frictool.logs.log import Stream as Stream
    from frictool.logs.reading import read_log as read_log
else:
    __getattr__, __dir__ = lazy_exports(
        __name__,
        {
            "Log": "frictool.logs.log",
            "Stream": "frictool.logs.log",
            "log_of": "frictool.logs.in_memory",
            "read_log": "frictool.logs.reading",
            "write_log": "frictool.logs.in_memory",
        },
    )

__all__ = ["Log", "Stream", "log_of", "read_log", "write_log"]
