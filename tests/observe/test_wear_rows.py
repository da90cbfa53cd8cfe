"""The moves of a log: against rows written out plainly, whatever pieces the log comes in, and what
never becomes a row."""

from __future__ import annotations

import itertools
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.laws import (
    FrictionOverTemperature,
    Gravity,
    Laws,
    Load,
    TemperatureChange,
)
from frictool.documents.model import Model
from frictool.documents.quantity import Estimate as Known
from frictool.documents.quantity import Quantity, Span
from frictool.documents.registry import load
from frictool.errors import FrictoolError
from frictool.observe.motion_block import MotionBlock
from frictool.observe.wear.log_moves import Move, MoveCollector
from frictool.observe.wear.weak_form_layout import WeakFormLayout, layout_of
from frictool.observe.wear.weak_form_rows import MOST_ROWS, REST
from frictool.typing import Vector
from studies.rigs.clutch_fleet import Unit, believed, clutch, run, steps
from tests.observe import plain_rows

ROOT = Path(__file__).parents[2]


def stroked(layout: WeakFormLayout, seed: int, seconds: float = 2.0) -> tuple[Vector, Vector]:
    """Position, on the encoder's lattice, and effort of a wild motion over the travel with rests in
    it; no physics in it."""
    draw = np.random.Generator(np.random.PCG64(seed))
    time = np.arange(0.0, seconds, layout.period)
    low, high = layout.edges[[0, -1]]
    waves = sum(
        a * np.sin(w * time + p)
        for a, w, p in zip(
            (1.0, 0.4), draw.uniform(4.0, 22.0, 2), draw.uniform(0, 6, 2), strict=True
        )
    )
    x = 0.5 * (low + high) + 0.4 * (high - low) * np.clip(
        waves, -0.9, 0.8
    )  # it rests where it is clipped
    return np.floor(x / layout.count) * layout.count, draw.normal(size=time.size)


def taken(
    layout: WeakFormLayout, position: Vector, effort: Vector, cuts: list[int] | None = None
) -> list[Move]:
    moves, out = MoveCollector(layout), []
    time = layout.period * np.arange(position.size)
    edges = [0, *sorted(cuts or []), position.size]
    for first, last in itertools.pairwise(edges):
        out += moves.take(
            MotionBlock(time[first:last], position[first:last], effort[first:last], first > 0)
        )
    return out + moves.end()


def with_gravity(model: Model) -> Model:
    unit = "N m"
    gravity = Gravity(
        Known(0.03, 0.03, 0.03, unit, source="identified"),
        Known(-0.02, -0.02, -0.02, unit, source="identified"),
    )
    laws = msgspec.structs.replace(model.laws or Laws(), load=Load(gravity=gravity))
    offset = msgspec.structs.replace(model.parameters.offset, value=0.01)
    return msgspec.structs.replace(
        model, laws=laws, parameters=msgspec.structs.replace(model.parameters, offset=offset)
    )


def layouts() -> list[WeakFormLayout]:
    emps, mass = (
        load(ROOT / "configs" / name, Model) for name in ("emps/published.yaml", "mass/model.yaml")
    )
    return [
        layout_of(clutch()),
        layout_of(with_gravity(clutch()), window=25),
        layout_of(emps, zones=3),
        layout_of(mass, period=2e-3),
    ]


@pytest.mark.parametrize("layout", layouts(), ids=["clutch", "gravity", "emps", "mass"])
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.accept)])
def test_moves_are_those_of_the_rows_written_out(layout: WeakFormLayout, seed: int) -> None:
    position, effort = stroked(layout, seed)
    found, plain = (
        taken(layout, position, effort),
        plain_rows.grams(position, effort, layout, REST, int(MOST_ROWS)),
    )
    assert [move.rows for move in found] == [count for _, count in plain]
    assert len(found) >= 3
    for move, (gram, _) in zip(found, plain, strict=True):
        size = np.sqrt(np.diag(gram))
        np.testing.assert_allclose(
            move.gram, gram, rtol=1e-9, atol=1e-9 * np.max(np.outer(size, size), initial=1e-300)
        )
        np.testing.assert_array_equal(move.gram, move.gram.T)


def test_moves_at_measured_temperatures_are_those_of_the_rows_written_out() -> None:
    """Viscous friction halves in 50 K, the dry friction falls by 0.2 % per K."""

    def slope(value: float) -> TemperatureChange:
        return TemperatureChange(Known(value, value, value, "1/K", source="identified"))

    law = FrictionOverTemperature(
        Quantity(50.0, unit="degC"), Span(30.0, 80.0, "degC"), slope(-0.0139), slope(-0.002)
    )
    laws = msgspec.structs.replace(clutch().laws or Laws(), temperature=law)
    layout = layout_of(msgspec.structs.replace(clutch(), laws=laws))
    position, effort = stroked(layout, 3)
    time = layout.period * np.arange(position.size)
    warm = 40.0 + 15.0 * np.sin(time)
    factors = np.exp(-0.0139 * (warm - 50.0)), np.exp(-0.002 * (warm - 50.0))
    moves = MoveCollector(layout)
    found = moves.take(MotionBlock(time, position, effort, False, None, warm)) + moves.end()
    plain = plain_rows.grams(position, effort, layout, REST, int(MOST_ROWS), factors)
    assert [move.rows for move in found] == [count for _, count in plain]
    for move, (gram, _) in zip(found, plain, strict=True):
        size = np.sqrt(np.diag(gram))
        np.testing.assert_allclose(
            move.gram, gram, rtol=1e-9, atol=1e-9 * np.max(np.outer(size, size))
        )
        assert move.excess == pytest.approx(40.0 + 15.0 * np.sin(move.time) - 50.0)
    alone = taken(layout, position, effort)  # a log without a temperature
    assert alone[0].gram[1, 1] != pytest.approx(found[0].gram[1, 1], rel=1e-3)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**20), cuts=st.lists(st.integers(0, 1200), max_size=12))
def test_the_pieces_of_a_log_do_not_matter(seed: int, cuts: list[int]) -> None:
    layout = layout_of(clutch())
    position, effort = stroked(layout, seed)
    whole, parts = taken(layout, position, effort), taken(layout, position, effort, cuts)
    assert len(whole) == len(parts)
    for one, other in zip(whole, parts, strict=True):
        assert (one.rows, one.direction, one.speed, one.time) == (
            other.rows,
            other.direction,
            other.speed,
            other.time,
        )
        np.testing.assert_array_equal(one.gram, other.gram)


def test_memory_does_not_grow_with_the_log() -> None:
    layout = layout_of(clutch())
    moves = MoveCollector(layout)
    position, effort = stroked(layout, 3)
    for k in range(20):
        moves.take(MotionBlock(layout.period * np.arange(position.size), position, effort, k > 0))
        assert moves.sample_count <= 2 * (layout.window + layout.reach)


def test_a_gap_of_the_log_ends_the_move_and_forgets_where_the_load_is() -> None:
    layout = layout_of(clutch())
    time = layout.period * np.arange(200)
    position = np.floor(150.0 * time / layout.count) * layout.count + 3.0  # 30 rad in one go
    moves = MoveCollector(layout)
    assert moves.take(MotionBlock(time, position, np.ones(200), False)) == []
    ended = moves.take(MotionBlock(time + 1.0, position + 30.0, np.ones(200), False))
    assert [move.rows > 0 for move in ended] == [True]
    assert ended[0].time < 0.2
    again = moves.end()
    assert again[0].rows == ended[0].rows  # as much was lost to the gap as at the beginning


def test_what_is_slow_turns_or_is_at_an_end_stop_is_no_row() -> None:
    layout = layout_of(clutch())
    n, reach = 600, layout.reach
    time = layout.period * np.arange(n)
    slow = np.floor(0.9 * layout.slowest * time / layout.count) * layout.count
    assert taken(layout, slow, np.ones(n)) == []
    dithered = 30.0 + layout.gap * 0.45 * np.sign(np.sin(40.0 * time))  # within the gap
    assert taken(layout, dithered, np.ones(n)) == []
    turned = 31.5 - 30.0 * np.cos(12.0 * time)
    for k, side in enumerate(plain_rows.directions(turned, layout)):
        if side:
            assert side * (turned[k + reach] - turned[k - reach]) > 0.0
            assert layout.stops[0] <= turned[k] <= layout.stops[1]


def test_slip_starts_at_two_counts_in_the_slope_or_at_a_fiftieth_of_the_top_speed() -> None:
    coarse, fine = (
        layout_of(clutch()),
        layout_of(load(ROOT / "configs" / "emps" / "published.yaml", Model)),
    )
    assert coarse.slowest == pytest.approx(
        2.0 * coarse.count / (coarse.reach * coarse.period), rel=1e-5
    )
    assert coarse.slowest > 400.0 / 50.0  # rad/s: the encoder decides
    assert fine.slowest == pytest.approx(0.3 / 50.0)  # m/s: the top speed decides
    assert fine.slowest > 2.0 * fine.count / (fine.reach * fine.period)


def test_a_window_is_as_long_as_the_encoder_asks_for() -> None:
    coarse, fine = (
        layout_of(clutch()),
        layout_of(load(ROOT / "configs" / "emps" / "published.yaml", Model)),
    )
    assert coarse.window > fine.window
    finer = msgspec.structs.replace(
        clutch().bench,
        encoder=msgspec.structs.replace(clutch().bench.encoder, counts_per_revolution=5600),
    )
    assert layout_of(msgspec.structs.replace(clutch(), bench=finer)).window < coarse.window
    noise = (
        clutch().parameters.inertia.value
        * coarse.count
        / np.sqrt(12.0)
        * np.linalg.norm(coarse.second)
    )
    assert noise <= 0.007 * coarse.friction


def test_the_accelerations_column_is_exact_on_parabolas() -> None:
    layout = layout_of(clutch())
    k = np.arange(layout.window) * layout.period
    assert layout.second @ (3.0 + 2.0 * k + 0.5 * 7.0 * k**2) == pytest.approx(7.0, rel=1e-9)
    assert layout.phi.sum() == pytest.approx(1.0, rel=1e-12)


def test_a_model_without_dry_friction_and_a_wrong_window_are_refused() -> None:
    model = load(ROOT / "configs" / "mass" / "model.yaml", Model)
    none = msgspec.structs.replace(model.parameters.coulomb, value=0.0)
    with pytest.raises(FrictoolError, match="coulomb: found 0; allowed: > 0"):
        layout_of(
            msgspec.structs.replace(
                model, parameters=msgspec.structs.replace(model.parameters, coulomb=none)
            )
        )
    with pytest.raises(
        FrictoolError, match="window: found 8 samples; allowed: an odd number of at least 5"
    ):
        layout_of(clutch(), window=8)


def test_moves_of_a_log_are_its_steps() -> None:
    log = run(Unit(), steps(4.0), 1).pieces[0]
    layout = layout_of(believed())
    found = taken(layout, log.position, log.effort)
    assert [move.direction for move in found[:4]] == [1, -1, 1, -1]
    assert len(found) == 8
    truth = np.abs(log.velocity) if log.velocity is not None else np.zeros(1)
    assert all(move.speed < truth.max() for move in found)
    assert [round(move.time / 0.5 - 0.5) for move in found] == list(range(8))
