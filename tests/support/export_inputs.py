"""Inputs that wander as an axis under a bad driver might: references held, positions in counts that
follow, jump, shake and stand still."""

from __future__ import annotations

import numpy as np

from frictool.control.program import Program
from frictool.documents.controller import Controller
from frictool.typing import Matrix

HELD = 250  # samples of a reference


def rows_for(controller: Controller, program: Program, samples: int, seed: int) -> Matrix:
    """Rows (samples, m) of the program's inputs in their order, then its scheduled parameters."""
    random, step = np.random.default_rng(seed), controller.bench.encoder.resolution
    references = np.repeat(random.uniform(-5.0, 68.0, samples // HELD + 1), HELD)[:samples]
    positions, x = np.empty(samples), step * float(np.round(references[0] / step))
    for k, reference in enumerate(references):
        phase = k % HELD
        if phase == HELD // 2 and random.random() < 0.5:
            x += random.normal(0.0, 3.0)
        elif phase < 0.7 * HELD:
            x += 0.06 * (reference - x) + step * random.normal() * (random.random() < 0.3)
        positions[k] = step * np.floor(x / step)
    columns = {"reference": references, "position": positions}
    columns["velocity"] = np.diff(positions, prepend=positions[0]) / controller.sample_period_s
    held = [node for node in program.states.values() if node.index not in program.updates]
    scheduled = [
        np.repeat(random.uniform(0.9 * one.low, 1.1 * one.high, samples // HELD + 1), HELD)[
            :samples
        ]
        for one in held
    ]
    return np.column_stack([*(columns[name] for name in program.inputs), *scheduled])


def with_losses(rows: Matrix, program: Program, seed: int) -> Matrix:
    """Return `rows` with a lost input in a tenth of the holds for as long as it is bridged, and one
    loss at the end that is longer."""
    assert program.guard is not None
    random, bridged = np.random.default_rng(seed), int(program.guard.hold.value)
    lost = rows.copy()
    for start in range(HELD, len(rows) - HELD, HELD):
        if bridged and random.random() < 0.1:
            begin = start + int(random.integers(HELD // 2))
            lost[
                begin : begin + int(random.integers(1, bridged + 1)),
                random.integers(len(program.inputs)),
            ] = np.nan
    lost[-HELD:, random.integers(len(program.inputs))] = np.nan
    return lost
