"""Simulation of the variants of a mechanism in parallel threads, which share no state."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import NamedTuple

import numpy as np

from frictool.control.compiled_program import CompiledProgram as Controller
from frictool.control.compiled_program import copy_program, start_at
from frictool.engine.closed_loop import RECORD_SIZE, measure
from frictool.engine.disturbances_and_faults import CONSTANT_FACTOR, FRICTION, VISCOUS_FACTOR
from frictool.engine.mechanism.array_layout import (
    BLOCKS,
    CONSTANT,
    LAW_VALUES,
    LIMIT,
    PRESSING,
    SOURCE,
    SOURCE_WIDTH,
    CompiledMechanism,
)
from frictool.engine.mechanism.closed_loop import (
    NOBODY,
    ControlPorts,
    DriftedNumbers,
    MechanismInputs,
    MechanismRecord,
    advance_controlled_sample,
    encoder_reading,
    follow,
    run,
)
from frictool.engine.mechanism.energy import EnergyBalance, balance
from frictool.engine.mechanism.events import ELEMENTS, EVENT_SIZE, NAMES
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import MechanismState, rest
from frictool.engine.status_codes import MESSAGES, OK
from frictool.errors import NoSolutionError
from frictool.friction.law_registry import ROWS
from frictool.plant.mechanism.packed_mechanism import PackedMechanism
from frictool.simulate.compiled_target import CompiledTarget
from frictool.simulate.mechanism_variants import MechanismVariant
from frictool.typing import Vector

AT_ONCE = 500_000  # most samples in a batch of runs
PIECE = 5000  # samples between two checks for progress and an interrupt
MOST_EVENTS = 200_000  # most stored events of a run; further events are only counted


class MechanismOutcome(NamedTuple):
    """Result of the simulation of one variant of a mechanism.

    - machine: compiled mechanism
    - state: final state
    - before: energies at the start
    - out: signals at each sample, and events
    """

    variant: MechanismVariant
    machine: CompiledMechanism
    state: MechanismState
    before: EnergyBalance
    out: MechanismRecord


class MechanismTask(NamedTuple):
    """Inputs of the simulation of one variant of a mechanism.

    - samples: number of samples
    - ports: blocks and source that a controller uses
    - inputs: signals of sources and efforts on blocks
    - conditions: drifts and sensor faults (engine/disturbances_and_faults.py)
    - reference (samples,): reference of the controller; None without a controller

    A mechanism with a controller has either `controller` or the compiled code `target`; the other
    field is None.
    """

    samples: int
    ports: ControlPorts
    inputs: MechanismInputs
    conditions: Vector
    reference: Vector | None
    delay_samples: int
    controller: Controller | None
    target: CompiledTarget | None


def play_all(
    variants: Sequence[MechanismVariant],
    tasks: Sequence[tuple[MechanismTask, Vector]],
    progress: Callable[[int, int], None],
) -> Iterator[MechanismOutcome]:
    """Simulate all variants in parallel; yield the outcome of each variant.

    With exported C code, the variants are simulated one after another.

    tasks: pairs (task, initial positions (n,) [rad | m]); each run starts at rest.
    `progress(done, total)` counts variants, or samples if there is a single variant. Raises
    NoSolutionError if a variant cannot be simulated; the message states the time and the element.
    """
    total = len(variants)
    done = 0
    alone = progress if total == 1 else lambda done, total: None
    batch = 1 if tasks[0][0].target is not None else max(1, AT_ONCE // max(tasks[0][0].samples, 1))
    progress(0, total)
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        while done < total:
            chosen = range(done, min(done + batch, total))
            # in this thread, so that an interrupt is handled between two pieces
            if len(chosen) == 1:
                yield simulate_variant(variants[done], *tasks[done], alone)
            else:
                yield from threads.map(
                    lambda index, context: context.run(
                        simulate_variant, variants[index], *tasks[index], alone
                    ),
                    chosen,
                    [copy_context() for _ in chosen],
                )
            done = chosen.stop
            if total > 1:
                progress(done, total)


def simulate_variant(
    variant: MechanismVariant,
    task: MechanismTask,
    start: Vector,
    progress: Callable[[int, int], None],
) -> MechanismOutcome:
    """Simulate one variant from rest at the positions `start` (n,) [rad | m].

    `progress(done, total)` receives numbers of samples. Raises NoSolutionError if the variant
    cannot be simulated.
    """
    packed = variant.assembled.packed
    machine = prepare(packed)
    state = rest(packed, machine, start)
    before = balance(machine, state)
    drifting = _drifting(packed, machine, task)
    n = packed.inertia.size
    u = packed.sources.block.size
    out = MechanismRecord(
        np.zeros((task.samples, RECORD_SIZE)),
        np.zeros((task.samples, 2 * n + u)),
        np.zeros((task.samples, state.modes.size), dtype=np.int8),
        np.zeros((MOST_EVENTS, EVENT_SIZE)),
        np.zeros(1, dtype=np.int64),
    )
    status = (_by_target if task.target is not None else _by_kernel)(
        task, machine, state, drifting, out, progress
    )
    kept = out.events[: min(int(out.happened[0]), MOST_EVENTS)].copy()
    outcome = MechanismOutcome(variant, machine, state, before, out._replace(events=kept))
    if status != OK:
        raise NoSolutionError(_failure_message(outcome, status))
    return outcome


def _by_kernel(
    task: MechanismTask,
    machine: CompiledMechanism,
    state: MechanismState,
    drifting: DriftedNumbers,
    out: MechanismRecord,
    progress: Callable[[int, int], None],
) -> int:
    shown = np.array([measure(state.y[task.ports.sensor], task.ports.step)])
    waiting = np.zeros(task.delay_samples + 1)
    program = None if task.controller is None else copy_program(task.controller)
    if program is not None:
        start_at(program, float(shown[0]))
    reference = np.empty(0) if task.reference is None else task.reference
    for begin in range(0, task.samples, PIECE):
        end = min(begin + PIECE, task.samples)
        rest_of = (task.inputs, drifting, out)
        if program is None:
            status, _ = follow(machine, state, task.ports, begin, end, shown, *rest_of)
        else:
            status, _ = run(
                machine, state, program, task.ports, reference, begin, end, waiting, shown, *rest_of
            )
        if status != OK:
            return int(status)
        progress(end, task.samples)
    return OK


def _by_target(
    task: MechanismTask,
    machine: CompiledMechanism,
    state: MechanismState,
    drifting: DriftedNumbers,
    out: MechanismRecord,
    progress: Callable[[int, int], None],
) -> int:
    target, reference, ports = task.target, task.reference, task.ports
    assert target is not None
    assert reference is not None
    waiting = np.zeros(task.delay_samples + 1)
    shown = float(measure(state.y[ports.sensor], ports.step))
    target.start(shown)
    for k in range(task.samples):
        shown = float(encoder_reading(ports, state, shown, drifting.conditions, k))
        command = target.step(
            float(reference[k]), shown, float(state.y[machine.whole[BLOCKS] + ports.sensor])
        )
        status = advance_controlled_sample(
            machine, state, ports, waiting, k, shown, command, task.inputs, drifting, out
        )
        if status != OK:
            return int(status)
        if (k + 1) % PIECE == 0:
            progress(k + 1, task.samples)
    progress(task.samples, task.samples)
    return OK


def _drifting(
    packed: PackedMechanism, machine: CompiledMechanism, task: MechanismTask
) -> DriftedNumbers:
    whole, numbers = machine.whole, machine.numbers
    indices: list[int] = []
    columns: list[int] = []
    for place, row in enumerate(packed.frictions.law.tolist()):
        first = int(whole[LAW_VALUES]) + int(packed.frictions.law_start[place])
        for index, parameter in enumerate(ROWS[row].parameters):
            if parameter.name == "viscous" or parameter.linear_unit.startswith("N"):
                indices.append(first + index)
                columns.append(VISCOUS_FACTOR if parameter.name == "viscous" else FRICTION)
    for place in range(packed.pressings.block.size):
        indices.append(int(whole[PRESSING]) + 2 * place)
        columns.append(FRICTION)
    limit = np.inf
    if task.ports.source != NOBODY:
        row = int(whole[SOURCE]) + task.ports.source * SOURCE_WIDTH
        indices.append(row + CONSTANT)
        columns.append(CONSTANT_FACTOR)
        limit = float(numbers[row + LIMIT])
        if task.conditions.size:
            numbers[row + LIMIT] = np.inf  # `true_command` has already limited the command
    at = np.array(indices, dtype=np.int64)
    return DriftedNumbers(
        task.conditions, at, np.array(columns, dtype=np.int64), numbers[at], limit
    )


def _failure_message(outcome: MechanismOutcome, status: int) -> str:
    instant = float(outcome.state.pace[1])
    text = f"{outcome.variant.topic}: at {instant:.6g} s {MESSAGES[status]}"
    events = outcome.out.events
    if events.size and int(outcome.out.happened[0]) <= MOST_EVENTS:
        last = events[-1]
        text += (
            f"; last event at {last[0]:.6g} s: {element_of(outcome.variant, last)} "
            f"{NAMES[int(last[1])]}"
        )
    return text + "; check the parameters of the mechanism"


def element_of(variant: MechanismVariant, event: Vector) -> str:
    """Return the name of the element at which an event (row of 4 numbers) occurred."""
    made = variant.assembled
    names: Mapping[str, tuple[str, ...]] = {
        "block": made.blocks,
        "joint": made.joints,
        "coupling": made.couplings,
        "stop": made.stops,
    }
    return names[ELEMENTS[int(event[1])]][int(event[2])]
