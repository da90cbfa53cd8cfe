"""The switched observers as the program that runs: equal to a plain reference bit by bit, frozen
where stuck, in whatever pieces."""

from __future__ import annotations

from itertools import pairwise

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.observer_composition import observer_program, switched_facts
from frictool.control.compiled_program import compile_program, run_values
from frictool.documents.observer import Observer
from frictool.observe.motion_block import MotionBlock
from frictool.observe.observer_run import ObserverOutput, ObserverRun, run_along
from frictool.typing import Vector
from tests.observe.plain_observer import PlainObserver
from tests.support.example_observers import drawn_observer
from tests.support.interpreted_program import InFloat

PERIOD = 1e-3
observers = st.builds(
    drawn_observer,
    seed=st.integers(0, 999),
    wear=st.sampled_from(["multiplicative", "additive"]),
    kept=st.sampled_from([0.0, 1.0]),
    viscous=st.sampled_from([0.0, 4e-4]),
    offset=st.sampled_from([0.0, 0.01]),
    cells=st.integers(1, 5),
)


def _moves(seed: int, samples: int) -> tuple[Vector, Vector]:
    """Positions (n,) over the travel and somewhat beyond, in smooth strokes with rests, and efforts
    (n,) of either sign."""
    draw = np.random.Generator(np.random.PCG64([seed, 78]))
    t = np.arange(samples) * PERIOD
    strokes = 31.5 + 36.0 * np.sin(
        2.0 * np.pi * float(draw.uniform(1.0, 4.0)) * t + float(draw.uniform(0.0, 6.0))
    )
    resting = np.floor(t / 0.15).astype(int) % 3 == 0
    positions = np.where(
        resting, strokes[np.maximum.accumulate(np.where(~resting, np.arange(samples), 0))], strokes
    )
    return positions, draw.uniform(-0.4, 0.4, samples)


def _piece(positions: Vector, efforts: Vector, first: int = 0, follows: bool = True) -> MotionBlock:
    return MotionBlock((first + np.arange(positions.size)) * PERIOD, positions, efforts, follows)


def _along(observer: Observer, positions: Vector, efforts: Vector) -> ObserverOutput:
    return next(run_along(observer, [_piece(positions, efforts)]))


def _columns(found: ObserverOutput) -> Vector:
    assert found.wear is not None
    return np.column_stack([found.position, found.velocity, found.friction, found.wear])


@settings(max_examples=40, deadline=None)
@given(observers, st.integers(0, 999))
def test_the_program_is_the_plain_observer_bit_by_bit(observer: Observer, seed: int) -> None:
    positions, efforts = _moves(seed, 600)
    plain = PlainObserver(observer, float(positions[0])).run(positions, efforts)
    assert np.array_equal(_columns(_along(observer, positions, efforts)), plain)


def test_every_mode_of_the_reference_is_visited() -> None:
    """So that the equality above says something of each."""
    observer, visited = drawn_observer(1, "multiplicative"), set()
    for seed in range(3):
        positions, efforts = _moves(seed, 600)
        plain = PlainObserver(observer, float(positions[0]))
        for position, effort in zip(positions, efforts, strict=True):
            visited.add(plain.mode().index)
            plain.step(position, effort)
    assert visited == {-3, -2, -1, 0, 1, 2, 3}


@settings(max_examples=15, deadline=None)
@given(
    observers,
    st.integers(0, 999),
    st.lists(st.integers(1, 399), min_size=1, max_size=5, unique=True),
)
def test_pieces_of_a_log_are_the_log(observer: Observer, seed: int, cuts: list[int]) -> None:
    positions, efforts = _moves(seed, 400)
    whole = _columns(_along(observer, positions, efforts))
    ends = [0, *sorted(cuts), 400]
    pieces = [_piece(positions[a:b], efforts[a:b], a) for a, b in pairwise(ends)]
    assert np.array_equal(
        np.vstack([_columns(part) for part in run_along(observer, pieces)]), whole
    )


@settings(max_examples=15, deadline=None)
@given(observers, st.integers(0, 999))
def test_over_a_gap_the_wear_is_kept_and_the_motion_is_not(observer: Observer, seed: int) -> None:
    positions, efforts = _moves(seed, 500)
    run = ObserverRun(observer)
    run.take(_piece(positions[:400], efforts[:400]))
    wear = float(run.machine.real[run.program.states["estimated_wear"].index])
    after = run.take(_piece(positions[450:], efforts[450:], 450, follows=False))
    assert after.wear is not None
    assert (after.position[0], after.velocity[0], after.wear[0]) == (positions[450], 0.0, wear)
    fresh = ObserverRun(observer)
    fresh.machine.real[fresh.program.states["estimated_wear"].index] = wear
    fresh.is_begun = True
    again = fresh.take(_piece(positions[450:], efforts[450:], 450, follows=False))
    assert np.array_equal(_columns(again), _columns(after))


@settings(max_examples=15, deadline=None)
@given(observers, st.integers(0, 999))
def test_stuck_it_freezes_the_wear_and_observes_no_friction(observer: Observer, seed: int) -> None:
    """(6.14): alpha's own estimate is taken for a measurement of it."""
    positions, efforts = _moves(seed, 400)
    found = _along(observer, positions, efforts)
    assert observer.switched is not None
    assert found.wear is not None
    stuck = np.abs(found.velocity) < observer.switched.switch_speed.value
    assert np.array_equal(found.wear[1:][stuck[:-1]], found.wear[:-1][stuck[:-1]])
    assert not np.any(found.friction[stuck])
    assert np.all(
        np.sign(found.velocity[~stuck])
        * found.friction[~stuck]
        * np.sign(_size(observer, found)[~stuck])
        >= 0.0
    )


def _size(observer: Observer, found: ObserverOutput) -> Vector:
    """Return the magnitude of the estimated friction, because an observer far off may have its sign
    wrong."""
    assert found.wear is not None
    if observer.kind == "multiplicative":
        return found.wear
    known, x = (
        observer.friction,
        np.clip(found.position, observer.friction.over.low, observer.friction.over.high),
    )
    curves = [np.polynomial.Polynomial(curve)(x) for curve in (known.forward, known.backward)]
    return np.where(found.velocity > 0.0, *curves) + found.wear


@settings(max_examples=10, deadline=None)
@given(observers, st.integers(0, 999))
def test_in_float_it_is_the_program_an_operation_at_a_time(observer: Observer, seed: int) -> None:
    positions, efforts = _moves(seed, 60)
    program = observer_program(observer).program
    running, slow = (
        compile_program(program, single=True),
        InFloat(program, float(np.float32(positions[0]))),
    )
    for place in running.starts:
        running.single[place] = np.float32(positions[0])
    for position, effort in zip(positions, efforts, strict=True):
        for name, value in (("position", position), ("effort", effort)):
            running.single[program.inputs[name].index] = value
        slow.step({"position": position, "effort": effort})
        run_values(running.code, running.terms, running.writes, running.single)
        for state in program.states.values():
            assert running.single[state.index] == slow.states[state.index]


def test_a_document_without_a_direction_is_refused() -> None:
    observer = drawn_observer(1, "additive")
    assert observer.switched is not None
    modes = tuple(mode for mode in observer.switched.modes if mode.direction >= 0)
    one_way = msgspec.structs.replace(observer.switched, modes=modes, transitions=((0, 1), (1, 0)))
    with pytest.raises(ValueError, match="a direction is missing; needed: modes"):
        switched_facts(msgspec.structs.replace(observer, switched=one_way))
