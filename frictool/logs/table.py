"""What a raw bench file gives before its columns mean anything: tables of named columns, read in blocks.

A file holds one table for each of its time bases: the rows of a CSV, a channel group of an MDF file, a topic of a recording. A table is
read block after block, so that a log of hours fits in little memory; mapping (mapping.py) and the canonical writer follow block by block.

    Table ──blocks──▶ Block, Block, ... ──mapping──▶ samples in SI ──▶ canonical log
       └─ damage: LogError, or a Loss each where the user asked to salvage
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from frictool.logs.log import Vector

BLOCK_ROWS = 1 << 16  # rows of a block, at most; a reader whose file has its own blocks (chunks, records) gives those, split
Nanoseconds = NDArray[np.int64]


@dataclass(frozen=True)
class Loss:
    """Samples that could not be read, and why: of which channels, in which span of the log's time [s], how many where that is known."""

    channels: tuple[str, ...]
    reason: str
    start_s: float | None = None
    end_s: float | None = None
    samples: int | None = None


@dataclass(frozen=True)
class Block:
    """Rows of a table that follow one another.

    first_row: index of the first of them in the table, from 0. columns: name -> (n,) numbers as they stand in the file, those that were
    asked for; nan where the cell is empty. time_ns: (n,) where the file itself dates its rows (a recording's messages, ISO 8601): exact,
    of any epoch; None where time is a column like any other, or where there is none.
    """

    first_row: int
    columns: dict[str, Vector]
    time_ns: Nanoseconds | None = None


class Table(Protocol):
    """One time base of a raw file.

    source: the file, for messages. topic: what the file calls the table, "" where it has but one. names: its columns in their order, so
    that one can be asked for by its number. units: name -> unit that the file gives, or None. clock: what dates its rows (`header.stamp`,
    `log time`, ...), None where a column does. size: bytes that `blocks` works through, for its progress.
    """

    source: str
    topic: str
    names: tuple[str, ...]
    units: Mapping[str, str | None]
    clock: str | None
    size: int

    def blocks(self, wanted: Sequence[str], losses: list[Loss] | None = None) -> Iterator[tuple[Block, int]]:
        """The rows of the columns `wanted`, block after block, each with the bytes worked through so far.

        Without `losses` damage raises LogError that names line or time, column, what was found and what is allowed. With it what cannot
        be read is left out and appended to it, and the rest is read.
        """
        ...

    def line(self, row: int) -> int | None:
        """The line of a row in the file, or None where the file has no lines."""
        ...
