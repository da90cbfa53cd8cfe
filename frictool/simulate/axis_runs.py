"""Simulation of the closed loop for all plant variants of an axis.

The variants are simulated in parallel on all cores, in batches that limit the memory. They are
simulated one after another if the controller is compiled C code, has scheduled parameters, or gets
commands of a supervisor.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from frictool.control.compiled_program import copy_program, hold, start_at
from frictool.control.machine_code import started_values
from frictool.control.supervision import CommandName, SupervisedProgram
from frictool.engine.closed_loop import (
    RECORD_SIZE,
    advance_sample,
    encoder_reading,
    load_of_run,
    measure,
    run,
)
from frictool.engine.coded_loop import run_coded
from frictool.engine.status_codes import MESSAGES, OK
from frictool.errors import NoSolutionError
from frictool.plant.axis import ENCODER_STEP, POSITION, VELOCITY
from frictool.plant.position_load import PositionLoad, with_load
from frictool.simulate.axis_variants import AxisVariant
from frictool.simulate.compiled_target import CompiledTarget
from frictool.simulate.scenario_conditions import command_samples
from frictool.simulate.simulated_plant import SimulatedLoop
from frictool.typing import Vector

AT_ONCE, LEAST = 500_000, 4  # most samples in a batch of runs; least number of runs in a batch


def play(
    variants: Sequence[AxisVariant], loop: SimulatedLoop, load: PositionLoad
) -> Iterator[tuple[AxisVariant, Vector]]:
    """Simulate the closed loop with each variant; yield the variant and its record (n, 7).

    engine/closed_loop.py names the columns of a record. `load` is an effort that depends on the
    position. The axis starts at rest, in the middle of the backlash, with the reference prefilter
    in steady state at the measured position. Raises NoSolutionError if a variant cannot be
    simulated.
    """
    samples = loop.reference.size
    total = len(variants)
    done = 0
    commands = command_samples(loop.scenario.commands, loop.controller.sample_period_s)
    alone = loop.target is not None or bool(loop.scheduled) or bool(commands)
    batch = 1 if alone else max(LEAST, AT_ONCE // max(samples, 1))
    loop.progress(0, total)
    while done < total:
        chosen = variants[done : done + batch]
        records = np.zeros((len(chosen), samples, RECORD_SIZE))
        scheduled = loop.scheduled[done] if loop.scheduled else {}
        if loop.target is not None:
            loop.target.scheduled = list(scheduled.values())
            status = _run_sampled(chosen[0], loop.target, commands, loop, load, records[0])
            statuses: Iterable[int] = (status,)
        elif commands:
            for index, value in scheduled.items():
                hold(loop.running, index, value)
            supervised = SupervisedProgram(loop.program, loop.running)
            status = _run_sampled(chosen[0], supervised, commands, loop, load, records[0])
            statuses = (status,)
        else:
            for index, value in scheduled.items():
                hold(loop.running, index, value)
            statuses = _run_program(chosen, loop, load.as_array(), records)
        for variant, status in zip(chosen, statuses, strict=True):
            if status != OK:
                raise NoSolutionError(
                    f"{variant.topic}: {MESSAGES[int(status)]}; check the model's parameters"
                )
        yield from zip(chosen, records, strict=True)
        done += len(chosen)
        loop.progress(done, total)


def _run_program(
    variants: Sequence[AxisVariant], loop: SimulatedLoop, load: Vector, records: Vector
) -> list[int]:
    def status(index: int) -> int:
        return _run_alone(variants[index], loop, load, records[index])

    first = status(0)  # in this thread, since the first run may have to compile the kernels
    if len(variants) == 1:
        return [first]
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        return [first, *threads.map(status, range(1, len(variants)))]


def _run_alone(variant: AxisVariant, loop: SimulatedLoop, load: Vector, record: Vector) -> int:
    axis = variant.array
    state = variant.rest(loop.start)
    measured = measure(loop.start, axis[ENCODER_STEP])
    period, delay = loop.controller.sample_period_s, loop.controller.delay_samples
    others = loop.reference, period, delay, record, load_of_run(axis, load), loop.conditions
    if loop.code is not None:
        values = started_values(loop.running, measured)
        return int(run_coded(axis, state, values, loop.code.address, *others))
    copy = copy_program(loop.running)
    start_at(copy, measured)
    return int(run(axis, state, copy, *others))


def _run_sampled(
    variant: AxisVariant,
    controller: CompiledTarget | SupervisedProgram,
    commands: Mapping[int, Sequence[CommandName]],
    loop: SimulatedLoop,
    load: PositionLoad,
    record: Vector,
) -> int:
    values = load.as_array()
    axis = with_load(variant.array, values)
    used = load_of_run(variant.array, values)
    state = variant.rest(loop.start)
    p = axis.copy()
    waiting = np.zeros(loop.controller.delay_samples + 1)
    period = loop.controller.sample_period_s
    conditions = loop.conditions
    measured = float(measure(state[POSITION], axis[ENCODER_STEP]))
    controller.start(measured)
    for k in range(loop.reference.size):
        measured = encoder_reading(axis, state, measured, conditions, k)
        for name in commands.get(k, ()):
            controller.command(name, measured)
        command = controller.step(loop.reference[k], measured, state[VELOCITY])
        status = advance_sample(
            axis, state, p, waiting, k, measured, command, period, record[k], used, conditions
        )
        if status != OK:
            return int(status)
    return OK
