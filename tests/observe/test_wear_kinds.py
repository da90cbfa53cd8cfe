"""Kinds of wear: the evidence against its definition, each kind told on the clutch with its values,
and what cannot be told."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.observe.motion_block import MotionBlock
from frictool.observe.sample_stream import open_stream
from frictool.observe.wear.bayesian_evidence import best_fit, evidences, mixture, posterior
from frictool.observe.wear.constant_error import scale_of
from frictool.observe.wear.log_moves import Move
from frictool.observe.wear.parameter_restriction import dry_columns, level_columns
from frictool.observe.wear.repeated_moves import MoveRepeats
from frictool.observe.wear.weak_form_layout import layout_of
from frictool.observe.wear.wear_estimator import WearEstimator
from frictool.observe.wear.wear_kinds import KINDS, WearClassifier
from frictool.observe.wear.zone_weights import friction_share
from frictool.observe.wear_estimate import EstimateRange, Kind, WearEstimate
from frictool.typing import Vector
from studies.rigs.clutch_fleet import (
    EDGE,
    Loop,
    Unit,
    believed,
    clutch,
    run,
    spread,
    steps,
    targets,
)
from tests.support.measured_data import data

ROOT = Path(__file__).parents[2]


def estimated(unit: Unit, reference: Vector, seed: int, loop: Loop) -> WearEstimate:
    estimator = WearEstimator(believed())
    for piece in run(unit, reference, seed, loop).pieces:
        estimator.take(piece)
    estimator.finish()
    return estimator.estimate


@given(st.integers(0, 2**32 - 1), st.integers(1, 5), st.integers(1, 30))
@settings(max_examples=40, deadline=None)
def test_evidence_and_posterior_are_those_of_the_rows(seed: int, rank: int, count: int) -> None:
    draw = np.random.Generator(np.random.PCG64(seed))
    rows, effort = draw.normal(size=(count, 5)), draw.normal(size=count)
    half, mean = draw.normal(size=(5, rank)), draw.normal(size=5)
    beliefs = [half @ half.T, 2.0 * half @ half.T, np.zeros((5, 5))]
    gram, right = rows.T @ rows, rows.T @ effort
    best = best_fit(gram, right)
    found = evidences(gram, best, np.stack([mean] * 3), np.stack(beliefs))
    dense = [
        multivariate_normal.logpdf(effort, rows @ mean, rows @ belief @ rows.T + np.eye(count))
        for belief in beliefs
    ]
    np.testing.assert_allclose(found - found[2], np.array(dense) - dense[2], rtol=1e-6, atol=1e-6)
    theta, covariance = posterior(gram, right, mean, beliefs[0] + np.eye(5))
    precision = np.linalg.inv(beliefs[0] + np.eye(5)) + gram
    np.testing.assert_allclose(covariance @ precision, np.eye(5), atol=1e-8)
    np.testing.assert_allclose(precision @ (theta - mean), right - gram @ mean, atol=1e-7)
    # one belief alone is its posterior; two that are the same are one
    for same in (1, 2):
        both = mixture(
            gram,
            right,
            best,
            np.stack([mean] * same),
            np.stack([beliefs[0]] * same),
            np.zeros(same),
        )
        for one, other in zip(both, posterior(gram, right, mean, beliefs[0]), strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


def holds(found: EstimateRange | None, truth: float) -> bool:
    return found is not None and found.low <= truth <= found.high


UNITS: list[tuple[Kind, Unit]] = [
    ("none", Unit()),
    ("multiplicative", Unit(wear=1.2)),
    ("additive", Unit(added=0.03)),
    ("directional", Unit(forward=1.2)),
    ("directional", Unit(backward=1.3)),
    ("zones", Unit(zone=1.3)),
]


@pytest.mark.parametrize(
    ("kind", "unit", "loop"),
    [
        *((*one, "speed") for one in UNITS),
        (*UNITS[1], "linear"),
        *(
            pytest.param(*one, "linear", marks=pytest.mark.accept)
            for one in UNITS
            if one[0] != "multiplicative"
        ),
    ],
)
def test_each_kind_is_told_with_its_values(kind: Kind, unit: Unit, loop: Loop) -> None:
    found = estimated(unit, steps(), 11, loop)
    assert found.kind == kind
    if kind == "additive":
        assert holds(found.added, unit.added)
        assert found.wear.value > 1.1  # of the mean friction
    else:
        assert found.added is None
    if kind in ("none", "multiplicative", "directional"):
        assert holds(found.forward, unit.forward * unit.wear)
        assert holds(found.backward, unit.backward * unit.wear)
    assert bool(found.zones) == (kind == "zones")
    for zone in found.zones:
        if zone.high <= EDGE or zone.low >= EDGE:
            assert holds(zone.wear, unit.zone if zone.low >= EDGE else 1.0)


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.accept) for seed in (1, 2, 3))]
)
def test_wear_is_told_on_spread_plants_too(seed: int) -> None:
    units: dict[Kind, Unit] = {
        "none": spread(seed),
        "multiplicative": spread(seed, wear=1.3),
        "additive": spread(seed, added=0.04),
        "directional": spread(seed, forward=1.3),
        "zones": spread(seed, zone=1.3),
    }
    for kind, unit in units.items():
        assert estimated(unit, targets(seed), seed, "speed").kind == kind


@pytest.mark.parametrize("since", [10.0, 18.0])  # 20 moves before the end, and 4
def test_a_change_at_once_is_not_mixed_with_what_was_before(since: float) -> None:
    found = estimated(Unit(wear=1.5, since=since), targets(3), 3, "speed")
    assert found.kind == "multiplicative"
    assert holds(found.forward, 1.5)
    assert holds(found.backward, 1.5)


def test_a_wrong_constant_is_a_scale_and_no_wear() -> None:
    scale = scale_of(believed())
    assert scale is not None
    for end in clutch().bench.actuator.constant.interval:
        constant = end / clutch().bench.actuator.constant.value
        found = estimated(Unit(constant=constant), targets(5), 5, "speed")
        assert found.kind == "none"
        assert found.scale == scale
        assert found.wear.value == pytest.approx(1.0 / constant, rel=0.02)
        assert scale.low * 0.999 <= 1.0 / constant <= scale.high * 1.001
        # inertia is scaled alike: their ratio is that of the unit
        inertia = (
            found.others["inertia"].value
            * believed().parameters.inertia.value
            / clutch().parameters.inertia.value
        )
        assert inertia / found.wear.value == pytest.approx(1.0, rel=0.03)


def test_a_bench_that_gives_no_range_of_the_constant_has_no_scale() -> None:
    model = believed()
    constant = msgspec.structs.replace(model.bench.actuator.constant, low=None, high=None)
    actuator = msgspec.structs.replace(model.bench.actuator, constant=constant)
    known = msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, actuator=actuator)
    )
    assert scale_of(known) is None


def test_where_friction_is_the_same_everywhere_a_factor_is_told_and_not_an_addition() -> None:
    model = believed()
    flat = msgspec.structs.replace(model, laws=None)
    layout = layout_of(flat)
    kinds, draw = WearClassifier(flat, layout), np.random.Generator(np.random.PCG64(8))
    names = list(layout.names)
    for index in range(12):
        kinds.take(drawn(draw, names, 1.0 if index % 2 else -1.0, layout.friction, wear=1.4))
    assert kinds.classification is not None
    assert kinds.classification.kind == "multiplicative"
    assert kinds.classification.evidence["additive"] == pytest.approx(
        kinds.classification.evidence["multiplicative"], abs=0.5
    )
    assert kinds.classification.wear.value == pytest.approx(1.4, abs=0.03)


def drawn(
    draw: np.random.Generator, names: list[str], direction: float, friction: float, wear: float
) -> Move:
    """Rows of one move in zone 2 of a friction that is the same everywhere."""
    side, count = "forward" if direction > 0.0 else "backward", 60
    columns = np.zeros((count, len(names) + 1))
    columns[:, names.index("inertia")] = draw.normal(0.0, 3000.0, count)
    columns[:, names.index("viscous")] = direction * draw.uniform(50.0, 200.0, count)
    columns[:, names.index(f"dry_{side}_2")] = direction * friction
    columns[:, names.index(f"level_{side}")] = direction
    columns[:, -1] = (
        1.056e-5 * columns[:, 0] + wear * direction * friction + draw.normal(0.0, 0.002, count)
    )
    return Move(columns.T @ columns, count, 1.0, int(direction), 100.0)


def test_shares_are_the_friction_over_the_models() -> None:
    layout = layout_of(believed())
    everywhere = tuple(range(layout.zones))
    for side in (None, "forward", "backward"):
        for zones in (everywhere, (0,), (2, 3), ()):
            share = friction_share(layout, zones, side)
            assert share @ dry_columns(layout) == pytest.approx(1.0)
            assert share @ (1.3 * dry_columns(layout)) == pytest.approx(1.3)
    both = friction_share(layout, everywhere)
    assert both @ level_columns(layout, layout.friction, layout.friction) == pytest.approx(
        1.0, rel=1e-6
    )
    for side in (None, "forward", "backward"):
        assert friction_share(layout, everywhere, side) @ level_columns(
            layout, -1.0, 1.0
        ) == pytest.approx(0.0)  # an offset is no friction
    sides = [both @ dry_columns(layout, side) for side in ("forward", "backward")]
    assert sum(sides) == pytest.approx(1.0)
    assert friction_share(layout, everywhere, "forward") @ dry_columns(layout, "backward") == 0.0


def test_too_few_moves_tell_no_kind() -> None:
    estimator = WearEstimator(believed())
    assert estimator.estimate.kind == "none"
    assert estimator.kinds.classification is None
    assert KINDS[0] == "none"


def test_coulomb_friction_along_emps() -> None:
    """Measured: within 10 % of the identified value from the first move back on, before it the
    interval holds it."""
    model = load(ROOT / "configs" / "emps" / "published.yaml", Model)
    estimator = WearEstimator(model)
    moves = [
        move
        for piece in open_stream(data("emps", "DATA_EMPS.mat"), model.bench).pieces()
        for move in estimator.moves.take(piece)
    ]
    found = [estimator.learn(move) for move in moves]
    turned = next(index for index, move in enumerate(moves) if move.direction < 0)
    assert all(holds(one.wear, 1.0) for one in found[:turned])
    assert all(0.9 <= one.wear.value <= 1.1 for one in found[turned:])
    assert (
        found[-1].kind == "zones"
    )  # the record's friction varies along its travel, which the published model has not


def test_directions_keep_up_with_wear_that_goes_on() -> None:
    estimator, time = WearEstimator(believed()), 0.0
    for index, wear in enumerate(np.linspace(1.0, 1.5, 11)):
        (piece,) = run(Unit(wear=float(wear)), targets(index, 3.0), index, "speed").pieces
        estimator.take(MotionBlock(piece.time + time, piece.position, piece.effort, follows=False))
        time += 3.0
    found = estimator.estimate
    assert found.wear.value == pytest.approx(1.5, abs=0.03)
    assert holds(found.forward, 1.5)
    assert holds(found.backward, 1.5)


def test_moves_that_are_alike_count_as_one() -> None:
    repeats = MoveRepeats()
    assert repeats.each == 1.0
    forth, back = np.diag([4.0, 1.0, 0.0, 0.0]), np.diag([0.0, 0.0, 1.0, 4.0])
    for part in (1.0, 1.05, 0.95):
        repeats.take(part * forth)
        repeats.take(np.diag([0.0, 0.0, 1.0, 4.0 * part]))
    assert repeats.each == 3.0
    repeats.take(forth + back)
    assert repeats.each == pytest.approx(7.0 / 3.0)


def test_components_that_are_left_out_leave_their_weight_to_the_others() -> None:
    """Priors that are alike give one posterior, whatever the weights of the priors are."""
    gram = np.array([[4.0, 1.0], [1.0, 3.0]])
    right = np.array([2.0, -1.0])
    mean, belief = np.array([0.3, 0.1]), np.diag([0.5, 2.0])
    alike = [mean] * 20, [belief] * 20
    rare = np.full(20, np.log(9e-4))
    rare[0] = 0.0
    best = np.linalg.solve(gram, right)
    theta, spread = mixture(gram, right, best, *map(np.array, alike), rare)
    expected, covariance = posterior(gram, right, mean, belief)
    np.testing.assert_allclose(theta, expected, rtol=1e-12)
    np.testing.assert_allclose(spread, covariance, rtol=1e-12)
