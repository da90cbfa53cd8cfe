"""Deadband of a compressed record: the logger leaves out changes below the deadband."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from frictool.documents.bench import Bench
from frictool.errors import LogError
from frictool.logs.quality.quantisation import SEVERAL
from frictool.logs.quality.time_base import FEWEST_LEVELS, encoder_step
from frictool.logs.raw_table import RawTable
from frictool.typing import Vector

# largest probability that a signal without deadband shows the gap below its smallest change
RARE = 1e-6
# least number of changes per multiple of the step, at which a missing multiple is no chance
FEWEST_EACH = 8
MEASURED = ("position", "velocity", "current", "voltage", "effort")


def deadband_doubts(table: RawTable, bench: Bench) -> tuple[str, ...]:
    """Return a warning for each measured column of the table that has a deadband.

    table: table with equidistant rows. Its first block is searched.
    """
    found = {
        channel: name
        for channel in MEASURED
        if channel in bench.columns and (name := _found(table, bench.columns[channel].column))
    }
    with suppress(LogError):
        block, _ = next(iter(table.blocks(list(dict.fromkeys(found.values())), [])), (None, 0))
        columns = {} if block is None else block.columns
        return tuple(
            f"column {name!r} has steps of {band[1]:.4g}, but no change below {band[0]:.4g}: "
            "its deadband hides smaller changes; record it without deadband (compression)"
            for name in found.values()
            if name in columns and (band := deadband(columns[name][np.isfinite(columns[name])]))
        )
    return ()


def _found(table: RawTable, column: str | int) -> str | None:
    """Return the name of a column in the table; None if the table does not contain it."""
    with suppress(LogError):
        return table.find(column)
    return None


def deadband(values: Vector) -> tuple[float, float] | None:
    """Return (smallest change, step) of a column if it has a deadband, else None.

    values: equidistant samples (n,), all multiples of the step.

    A signal with a deadband has no changes of a single step, even where it reverses or begins to
    move. The signal of a fast axis also has no changes of a single step if the axis seldom
    reverses. The result is therefore None for a signal that seldom reverses or begins to move. The
    result is also None in two other cases: chance explains the smallest change of a noisy signal,
    or the signal was rounded twice. After double rounding, a multiple of the step is missing among
    many changes that are at most twice the smallest change.
    """
    changes = np.diff(values)
    moves = changes != 0.0
    turns = np.count_nonzero(moves[1:] & (np.sign(changes[1:]) != np.sign(changes[:-1])))
    step = encoder_step(values)
    if step is None or turns < max(FEWEST_LEVELS, 0.5 * np.count_nonzero(moves)):
        return None
    sizes = np.round(np.abs(changes[moves]) / step)
    least = float(sizes.min())
    near = sizes[sizes <= 2.0 * least]
    # without a deadband, the changes up to 2 least are spread over 2 least multiples of the step
    chance = ((least + 1.0) / (2.0 * least)) ** near.size
    twice = np.unique(near).size <= least and near.size >= FEWEST_EACH * (least + 1.0)
    return (least * step, step) if least > SEVERAL and chance < RARE and not twice else None
