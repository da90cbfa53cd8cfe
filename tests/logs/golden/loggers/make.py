"""Writes the golden files of this folder: python -m tests.logs.golden.loggers.make."""

from __future__ import annotations

from pathlib import Path

from tests.support import logger_files
from tests.support.logger_texts import TEXTS

HERE = Path(__file__).parent

if __name__ == "__main__":
    logger_files.write_tdms(HERE / "axis.tdms")
    for ending in (".blf", ".asc"):
        logger_files.write_can(HERE / f"axis{ending}")
    (HERE / "axis.candump").write_text(logger_files.candump())
    (HERE / "axis.ulg").write_bytes(logger_files.ulog())
    (HERE / "axis.dbc").write_text(logger_files.DBC)
    for name, text in TEXTS.items():
        (HERE / name).write_bytes(text().encode())
    for version in ("v7", "v7.3"):
        logger_files.write_timetable(HERE / f"timetable_{version}.mat", version)
