"""Logs in memory, their readers and writers, and the mapping of raw columns to channels."""

from typing import TYPE_CHECKING

from frictool.runtime.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from frictool.logs.ingestion import IngestRequest as IngestRequest
    from frictool.logs.ingestion import ingest as ingest
    from frictool.logs.log import Log as Log
    from frictool.logs.log import Stream as Stream
    from frictool.logs.log_from_arrays import log_of as log_of
    from frictool.logs.log_from_arrays import write_log as write_log
    from frictool.logs.log_reader import read_log as read_log
else:
    __getattr__, __dir__, __all__ = lazy_exports(
        __name__,
        {
            "log_from_arrays": ["log_of", "write_log"],
            "ingestion": ["IngestRequest", "ingest"],
            "log": ["Log", "Stream"],
            "log_reader": ["read_log"],
        },
    )
