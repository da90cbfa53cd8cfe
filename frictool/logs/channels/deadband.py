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

MEASURED = ("position", "velocity", "current", "voltage", "effort")


def deadband_doubts(table: RawTable, bench: Bench) -> tuple[str, ...]:
    """Return a warning for each measured column of the table that has a deadband.

    table: table with equidistant rows. Its first block is searched.
    """
    doubts = []
    for channel in MEASURED:
        if channel not in bench.columns:
            continue
        with suppress(LogError):
            name = table.find(bench.columns[channel].column)
            block, _ = next(iter(table.blocks([name], [])), (None, 0)) if name else (None, 0)
            values = np.empty(0) if block is None or name is None else block.columns[name]
            if found := deadband(values[np.isfinite(values)]):
                least, step = found
                doubts.append(
                    f"column {name!r} has steps of {step:.4g}, but no change below {least:.4g}: "
                    "its deadband hides smaller changes; record it without deadband (compression)"
                )
    return tuple(doubts)


def deadband(values: Vector) -> tuple[float, float] | None:
    """Return (smallest change, step) of a column if it has a deadband, else None.

    values: equidistant samples (n,), all multiples of the step.

    A signal with a deadband has no changes of a single step, even where it reverses or begins to
    move. The signal of a fast axis also has no changes of a single step if the axis seldom
    reverses. The result is therefore None for a signal that seldom reverses or begins to move.
    """
    changes = np.diff(values)
    moves = changes != 0.0
    turns = np.count_nonzero(moves[1:] & (np.sign(changes[1:]) != np.sign(changes[:-1])))
    step = encoder_step(values)
    if step is None or turns < max(FEWEST_LEVELS, 0.5 * np.count_nonzero(moves)):
        return None
    least = float(np.abs(changes[moves]).min())
    return (least, step) if least > SEVERAL * step else None
