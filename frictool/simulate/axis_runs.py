"""Closed loops of all variants of an axis, in parallel on all cores and in batches.

The batches limit the memory for records.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from frictool.control.compiled_program import CompiledProgram, copy_program, hold, start_at
from frictool.documents.controller import Controller
from frictool.engine.batch import closed_loops
from frictool.engine.closed_loop import RECORD_SIZE, measure, run
from frictool.engine.status import MESSAGES, OK
from frictool.errors import NoSolutionError
from frictool.plant.axis import ENCODER_STEP, POSITION, rest
from frictool.plant.position_load import PositionLoad
from frictool.simulate.axis_variants import AxisVariant
from frictool.typing import Vector

AT_ONCE, LEAST = 500_000, 4  # samples of all runs of a batch; least number of runs in a batch


def play(
    variants: Sequence[AxisVariant],
    running: CompiledProgram,
    controller: Controller,
    start: float,
    reference: Vector,
    load: PositionLoad,
    conditions: Vector,
    progress: Callable[[int, int], None],
    told: Sequence[Mapping[int, float]] = (),
) -> Iterator[tuple[AxisVariant, Vector]]:
    """Yield each variant and its record (n, 7) under `reference` (n,), with the program `running`.

    Each run starts at rest at `start` [rad | m], in the middle of the backlash, with the prefilter
    at the measured position. `conditions` are those of engine/conditions.py. `told` has, per
    variant, the scheduled parameters of the controller by state index; such variants run one by
    one. `progress(done, total)` is called before the first batch and after each. Raises
    NoSolutionError if a variant cannot be simulated.
    """
    samples, total, done = reference.size, len(variants), 0
    batch = 1 if told else max(LEAST, AT_ONCE // max(samples, 1))
    progress(0, total)
    while done < total:
        chosen = variants[done : done + batch]
        axes = np.stack([variant.array for variant in chosen])
        states, references = (
            np.stack([rest(start)] * len(chosen)),
            np.stack([reference] * len(chosen)),
        )
        records, statuses = (
            np.zeros((len(chosen), samples, RECORD_SIZE)),
            np.zeros(len(chosen), dtype=np.int64),
        )
        for place, value in told[done].items() if told else ():
            hold(running, place, value)
        timing = controller.sample_period_s, controller.delay_samples
        rest_of = (*timing, records, statuses, load.as_array(), conditions)
        (closed_loops if len(chosen) > 1 else _alone)(axes, states, running, references, *rest_of)
        for variant, status in zip(chosen, statuses, strict=True):
            if status != OK:
                raise NoSolutionError(
                    f"{variant.topic}: {MESSAGES[int(status)]}; check the model's parameters"
                )
        yield from zip(chosen, records, strict=True)
        done += len(chosen)
        progress(done, total)


def _alone(
    axes: Vector,
    states: Vector,
    running: CompiledProgram,
    references: Vector,
    period: float,
    delay_samples: int,
    records: Vector,
    statuses: NDArray[np.int64],
    load: Vector,
    conditions: Vector,
) -> None:
    """Run one loop like engine/batch.py `closed_loops`, without threads.

    Starting the threads takes longer than a short run.
    """
    own = copy_program(running)
    start_at(own, measure(states[0, POSITION], axes[0, ENCODER_STEP]))
    statuses[0] = run(
        axes[0], states[0], own, references[0], period, delay_samples, records[0], load, conditions
    )
