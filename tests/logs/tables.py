"""Tables read whole, and the losses of damaged files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray

from frictool.errors import LogError
from frictool.logs.raw_table import DataLoss, RawTable, pick


def columns(
    table: RawTable, wanted: Sequence[str] | None = None, losses: list[DataLoss] | None = None
) -> dict[str, NDArray[np.float64]]:
    """The columns, joined; all of them where none is named. The blocks follow one another, and
    their progress ends at `size` at most."""
    chosen = (
        table.names
        if wanted is None
        else tuple(table.find(one) or pick(table.names, one, table.source) for one in wanted)
    )
    parts: dict[str, list[NDArray[np.float64]]] = {name: [] for name in chosen}
    row = done = 0
    for block, reached in table.blocks(chosen, losses):
        assert block.first_row == row
        assert set(block.columns) == set(chosen)
        assert done <= reached <= table.size
        done = reached
        for name in chosen:
            assert block.columns[name].dtype == np.float64
            parts[name].append(block.columns[name])
        row += len(block.columns[chosen[0]])
    return {
        name: np.concatenate(vectors) if vectors else np.empty(0) for name, vectors in parts.items()
    }


def times(table: RawTable, wanted: Sequence[str] = ()) -> NDArray[np.int64]:
    """The times of the rows [ns], joined."""
    return np.concatenate(
        [
            block.time_ns
            for block, _ in table.blocks(wanted or table.names[:1])
            if block.time_ns is not None
        ]
    )


@contextmanager
def one_line() -> Iterator[list[str]]:
    """Lets a refusal pass, and tells it: it has to be one line."""
    refusals: list[str] = []
    try:
        yield refusals
    except LogError as error:
        refusals.append(str(error))
    assert not any("\n" in text for text in refusals)
