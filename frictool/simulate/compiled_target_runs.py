"""Closed loops with compiled controller code: engine/closed_loop.py, sample by sample."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from frictool.documents.controller import Controller
from frictool.engine.closed_loop import RECORD_SIZE, advance_sample, encoder_reading, measure
from frictool.engine.status import MESSAGES, OK
from frictool.errors import NoSolutionError
from frictool.plant.axis import ENCODER_STEP, POSITION, VELOCITY, rest
from frictool.plant.position_load import PositionLoad, with_load
from frictool.simulate.axis_variants import AxisVariant
from frictool.simulate.compiled_target import CompiledTarget
from frictool.typing import Vector


def play_target(
    variants: Sequence[AxisVariant],
    target: CompiledTarget,
    controller: Controller,
    start: float,
    reference: Vector,
    load: PositionLoad,
    conditions: Vector,
    progress: Callable[[int, int], None],
    told: Sequence[Mapping[int, float]] = (),
) -> Iterator[tuple[AxisVariant, Vector]]:
    """Yield variants and records like `play` of simulate/axis_runs.py, with `target`.

    The variants run one by one.
    """
    progress(0, len(variants))
    for done, variant in enumerate(variants):
        record = np.zeros((reference.size, RECORD_SIZE))
        target.told = list(told[done].values()) if told else []
        status = _run(
            variant.axis.as_array(),
            target,
            controller,
            start,
            reference,
            record,
            load.as_array(),
            conditions,
        )
        if status != OK:
            raise NoSolutionError(
                f"{variant.topic}: {MESSAGES[status]}; check the model's parameters"
            )
        yield variant, record
        progress(done + 1, len(variants))


def _run(
    axis: Vector,
    target: CompiledTarget,
    controller: Controller,
    start: float,
    reference: Vector,
    record: Vector,
    load: Vector,
    conditions: Vector,
) -> int:
    """Run engine/closed_loop.py `run` with the step of the compiled controller."""
    axis = with_load(axis, load)
    state, p, waiting = rest(start), axis.copy(), np.zeros(controller.delay_samples + 1)
    measured = float(measure(state[POSITION], axis[ENCODER_STEP]))
    target.start(measured)
    for k in range(reference.size):
        measured = encoder_reading(axis, state, measured, conditions, k)
        command = target.step(reference[k], measured, state[VELOCITY])
        status = advance_sample(
            axis,
            state,
            p,
            waiting,
            k,
            measured,
            command,
            controller.sample_period_s,
            record[k],
            conditions,
        )
        if status != OK:
            return int(status)
    return OK
