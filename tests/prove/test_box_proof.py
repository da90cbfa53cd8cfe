"""Cells of the parameter box: every run of the engine is in the tube of its cell."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of
from frictool.control.compiled_program import copy_program, start_at
from frictool.documents.controller import Controller
from frictool.documents.proof import Proof, proof_digest
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.engine.axis_motion import advance
from frictool.engine.closed_loop import (
    MEASURED,
    RECORD_SIZE,
    TRUE_POSITION,
    load_of_run,
    run,
)
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.status_codes import OK
from frictool.errors import NoSolutionError
from frictool.plant import axis as ax
from frictool.plant.position_load import PositionLoad
from frictool.prove import affine_forms as af
from frictool.prove import axis_forms as forms
from frictool.prove import box_proof, step_proof
from frictool.prove.box_proof import (
    BoxTest,
    _divided,
    _next_start,
    box_test,
    first_cells,
    halves,
    intervals_of,
    is_partition,
    is_proved,
    ratios_of,
    search,
    share_of,
    sizes,
    total_share,
)
from frictool.prove.box_tube import (
    NODES,
    WEIGHTS,
    CellRatios,
    StepStart,
    UnprovedCell,
    _started,
    step_bounds,
)
from frictool.prove.encoder_phases import phase_runs
from frictool.prove.proof_view import lines
from frictool.prove.step_proof import (
    ProofRequest,
    _with_cells,
    differences,
    prove_again,
    prove_box,
    prove_step,
)
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.affine_form_kernels import advanced, operate, reduced
from tests.support.certified_controllers import certified

SEED = 20261129
RIG = ROOT / "configs/clutch"
HERE = Provenance("a test", "0")


def _test(controller: Controller) -> BoxTest:
    scenario = load(RIG / "scenarios/prove.yaml", Scenario)
    found = box_test(clutch_model(), controller, scenario, load(RIG / "spec.yaml", Spec))
    assert isinstance(found, BoxTest)
    return found


@cache
def _speed() -> BoxTest:
    return _test(certified("speed"))


@cache
def _first_cells() -> list[str]:
    """Return first cells of a part of the box, near the middle; all of them take two seconds."""
    queue, cells = ["fCFCFCFVC"], []
    while queue:
        path = queue.pop()
        if max(sizes(_speed(), path)) > 1.0:
            queue += halves(_speed(), path)
        else:
            cells.append(path)
    return sorted(cells)


@cache
def _is_proved(path: str) -> bool:
    return is_proved(_speed(), path)


@cache
def _proved_cells(count: int) -> tuple[str, ...]:
    """Return some proved cells from the middle of the box."""
    found = []
    for path in _first_cells():
        if _is_proved(path):
            found.append(path)
            if len(found) == count:
                return tuple(found)
    raise AssertionError(found)


def _plants(test: BoxTest, path: str, count: int) -> list[ax.AxisParameters]:
    """Draw plants of a cell, many of them at its ends."""
    random = np.random.default_rng(SEED)
    ratio, friction, viscous = intervals_of(test, path)
    model = clutch_model()
    plants: list[ax.AxisParameters] = []
    while len(plants) < count:
        share = np.clip(random.uniform(-0.3, 1.3, 3), 0.0, 1.0)
        inertia = random.uniform(*test.box["inertia"])
        values = {
            name: float(inertia * (low + one * (high - low)))
            for name, one, (low, high) in zip(
                ("constant", "coulomb", "viscous"), share, (ratio, friction, viscous), strict=True
            )
        }
        if all(test.box[key][0] <= value <= test.box[key][1] for key, value in values.items()):
            plants.append(axis_of(model, inertia=float(inertia), **values))
    return plants


def _play(test: BoxTest, plant: ax.AxisParameters, start: float) -> np.ndarray:
    """Return the record of a run of both holds, of which the last is shortened to 2 s."""
    reference = np.concatenate([np.full(1100, 55.0), np.full(2000, 5.0)])
    machine = copy_program(test.loop.compiled)
    start_at(machine, math.floor(start / test.loop.step) * test.loop.step)
    record = np.empty((reference.size, RECORD_SIZE))
    array = plant.as_array()
    load = load_of_run(array, PositionLoad().as_array())
    delay = test.loop.delay
    status = run(
        array, ax.rest(start), machine, reference, 1e-3, delay, record, load, NO_CONDITIONS
    )
    assert status == OK
    return record


@pytest.mark.parametrize(
    ("cells", "runs"), [(1, 12), pytest.param(12, 400, marks=pytest.mark.accept)]
)
def test_every_run_of_the_engine_is_in_the_tube_of_its_cell(cells: int, runs: int) -> None:
    test = _speed()
    random = np.random.default_rng(SEED)
    narrowest = math.inf
    for path in _proved_cells(cells):
        ratios = ratios_of(test, path)
        first = step_bounds(test.loop, ratios, test.start, test.goals[0].plan)
        following = _next_start(test, test.goals[1], test.goals[0], first)
        for plant in _plants(test, path, runs):
            start = float(random.uniform(*test.start.position))
            position = _play(test, plant, start)[:, TRUE_POSITION]
            rest, far = float(position[1099]), float(position[:1100].max())
            part = replace(following, position=(rest - 0.1, rest + 0.2), far=(far - 0.1, far + 0.2))
            second = step_bounds(test.loop, ratios, part, test.goals[1].plan)
            for bounds, played, response in (
                (first, position[:1100], test.goals[0].plan.response),
                (second, position[1100:], test.goals[1].plan.response),
            ):
                low = np.min([one.positions[:, 0] for one in bounds], axis=0)
                high = np.max([one.positions[:, 1] for one in bounds], axis=0)
                assert (low <= played[: low.size]).all()
                assert (played[: low.size] <= high).all()
                assert min(one.final[0] for one in bounds) <= played[-1]
                assert played[-1] <= max(one.final[1] for one in bounds)
                distance = np.abs(played[response:] - played[-1]).max()
                assert distance <= max(one.error for one in bounds)
                narrowest = min(narrowest, float((high - played[: low.size]).min()))
    assert 0.0 <= narrowest < 0.02  # the tube is not so wide that the test could not fail


def test_runs_with_an_uncertain_direction_at_the_start_are_in_the_tube() -> None:
    """With little friction, encoder errors may turn the axis inside its backlash."""
    test = _speed()
    middle = np.array([897.0, 1695.0, 44.0])
    low, high = 0.999 * middle, 1.001 * middle
    ratios = CellRatios(*zip(low, high, strict=True), ratios_of(test, "").offset)
    (*bounds,) = step_bounds(test.loop, ratios, test.start, test.goals[0].plan)
    random = np.random.default_rng(SEED)
    lowest = np.min([one.positions[:, 0] for one in bounds], axis=0)
    highest = np.max([one.positions[:, 1] for one in bounds], axis=0)
    for _ in range(40):
        inertia = 1.3e-5
        constant, coulomb, viscous = inertia * random.uniform(low, high)
        plant = axis_of(
            clutch_model(), inertia=inertia, constant=constant, coulomb=coulomb, viscous=viscous
        )
        start = float(random.uniform(*test.start.position))
        position = _play(test, plant, start)[: lowest.size, TRUE_POSITION]
        assert (lowest <= position).all()
        assert (position <= highest).all()


@pytest.mark.parametrize("contact", [forms.IN_FRONT, forms.BEHIND])
def test_the_parts_of_a_set_of_starts_contain_every_start(contact: int) -> None:
    side = 1.0 if contact == forms.IN_FRONT else -1.0
    whole = StepStart((4.0, 5.5), np.zeros(1), contact, (0.0, 3.0), (4.0, 6.0))
    if contact == forms.BEHIND:
        whole = replace(whole, position=(4.5, 6.0))
    parts = [whole]
    while any(_divided(part, 0.25) for part in parts):
        parts = [one for part in parts for one in (_divided(part, 0.25) or [part])]
    random = np.random.default_rng(SEED)
    for _ in range(500):
        position, far = random.uniform(*whole.position), random.uniform(*whole.far)
        inside = [
            part.position[0] <= position <= part.position[1] and part.far[0] <= far <= part.far[1]
            for part in parts
        ]
        if side * (far - position) >= 0.0:  # the contact is in front of (behind) the axis
            assert any(inside)
    assert len(parts) < 4 * 3 * 2**2  # parts without such a start are left out


def test_a_proved_cell_contains_no_violation() -> None:
    test = _speed()
    path = _proved_cells(2)[1]
    for plant in _plants(test, path, 60):
        measured = _play(test, plant, 5.0)[:, MEASURED]
        for goal, (first, last) in zip(test.goals, ((0, 1100), (1100, 3100)), strict=True):
            hold = measured[first:last]
            sign = math.copysign(1.0, goal.target - goal.origin)
            assert (sign * (hold - goal.target)).max() <= goal.overshoot
            assert abs(hold[-1] - goal.target) <= goal.static
            assert np.abs(hold[goal.plan.response :] - hold[-1]).max() <= goal.response


def _changed(controller: Controller, gain: float, law: dict[str, float]) -> Controller:
    """Return a controller with another gain of its linear part or another position law."""
    discrete = controller.linear.discrete
    assert discrete is not None
    louder = msgspec.structs.replace(
        discrete,
        c=[[gain * value for value in row] for row in discrete.c],
        d=[[gain * value for value in row] for row in discrete.d],
    )
    linear = msgspec.structs.replace(controller.linear, discrete=louder)
    assert controller.position_law is not None
    position_law = msgspec.structs.replace(controller.position_law, **law)
    return msgspec.structs.replace(controller, linear=linear, position_law=position_law)


@pytest.mark.parametrize(
    ("gain", "law"),
    [(4.0, {}), (0.2, {}), (1.0, {"band": 0.1}), (1.0, {"gain": 400.0}), (1.0, {"gain": 10.0})],
)
def test_no_cell_of_a_broken_controller_is_proved(gain: float, law: dict[str, float]) -> None:
    test = _test(_changed(certified("speed"), gain, law))
    assert not any(is_proved(test, path) for path in _proved_cells(2))


def test_the_cells_of_a_search_divide_the_box(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(box_proof, "FIRST_SIZE", tuple(2.0 * size for size in box_proof.FIRST_SIZE))
    test = _speed()
    cells = first_cells(test)
    assert len(cells) > 1000
    assert total_share(test, cells) == pytest.approx(1.0, abs=1e-9)
    assert is_partition(test, cells[:80])
    path = cells[17]
    both = tuple(halves(test, path))
    assert total_share(test, both) == pytest.approx(share_of(test, path), rel=1e-9)
    assert not is_partition(test, [path, both[0]])
    assert not is_partition(test, [path, path])
    assert not is_partition(test, [path[::-1]])
    random = np.random.default_rng(SEED)
    names = ("inertia", "constant", "coulomb", "viscous")
    drawn = {name: random.uniform(*test.box[name], 200_000) for name in names}
    part = path[:7]
    inside = np.ones(200_000, dtype=bool)
    for (low, high), name in zip(intervals_of(test, part), names[1:], strict=True):
        inside &= (low <= drawn[name] / drawn["inertia"]) & (drawn[name] / drawn["inertia"] < high)
    expected = share_of(test, part)
    assert inside.mean() == pytest.approx(expected, abs=4.0 * math.sqrt(expected / 200_000))


@cache
def _proof() -> tuple[ProofRequest, Proof]:
    scenario = load(RIG / "scenarios/prove.yaml", Scenario)
    single = msgspec.structs.replace(scenario, variants="none")
    request = ProofRequest(
        clutch_model(), certified("speed"), single, load(RIG / "spec.yaml", Spec)
    )
    with pytest.MonkeyPatch.context() as patch:  # of a few starts, which are not the subject here
        patch.setattr(step_proof, "phase_runs", lambda loop: itertools.islice(phase_runs(loop), 3))
        return request, prove_step(request, HERE)


def test_a_proof_lists_its_cells_and_edits_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    proof = _proof()[1]
    monkeypatch.setattr(step_proof, "prove_step", lambda *_, **__: proof)  # the same each time
    monkeypatch.setattr(box_proof, "is_proved", lambda _, path: _is_proved(path))
    test = _speed()
    cells = _proved_cells(2)[:1]
    boxed = _with_cells(proof, test, cells)
    share = total_share(test, cells)
    assert {one.key for one in boxed.requirements if one.share == share} == {
        "response_time_95_s",
        "overshoot_percent",
        "static_error",
        "rest",
    }
    assert any(
        f"limit proved for {100.0 * share:.3g} % of the box" in line for line in lines(boxed)
    )
    assert differences(boxed, prove_again(boxed)) == ()
    stripped = msgspec.structs.replace(boxed, cells=())
    wider = msgspec.structs.replace(boxed, cells=(cells[0][:-2],))
    for edited in (stripped, wider):
        again = msgspec.structs.replace(edited, digest=proof_digest(edited))
        assert "requirements" in differences(again, prove_again(again))


def test_a_search_stops_after_its_time_and_proves_what_it_lists(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    judged: list[str] = []

    def is_proved(_: BoxTest, path: str) -> bool:
        judged.append(path)
        return _is_proved(path)

    clock = itertools.count()  # a second passes between two looks at it
    monkeypatch.setattr(box_proof, "time", SimpleNamespace(monotonic=clock.__next__))
    monkeypatch.setattr(box_proof, "first_cells", lambda _: _first_cells())
    monkeypatch.setattr(box_proof, "is_proved", is_proved)
    test = _speed()
    cells = search(test, 6.0, cores=1)
    assert judged == _first_cells()[:5]
    assert cells
    assert set(cells) == {path for path in judged if _is_proved(path)}
    assert is_partition(test, cells)


def test_other_loops_are_refused_with_a_reason() -> None:
    request, proof = _proof()
    fast = msgspec.structs.replace(proof, controller=certified("fast"))
    with pytest.raises(NoSolutionError, match="action: cut"):
        prove_box(fast, 1.0)
    with pytest.raises(NoSolutionError, match="number format"):
        prove_box(msgspec.structs.replace(proof, number="q31"), 1.0)
    assert request.number == "double"


def test_a_tube_that_becomes_too_wide_is_undecided() -> None:
    test = _speed()
    with pytest.raises(UnprovedCell, match="too wide"):
        step_bounds(test.loop, ratios_of(test, ""), test.start, test.goals[0].plan)


def test_branches_of_a_tube_share_no_memory() -> None:
    test = _speed()
    tube = _started(test.loop, ratios_of(test, ""), test.start, test.goals[0].plan)
    branch = tube.copy()
    for one, other in ((tube.forms, branch.forms), (tube.past, branch.past)):
        assert not any(map(np.shares_memory, one, other))
    assert not np.shares_memory(tube.motion, branch.motion)
    assert not np.shares_memory(tube.record, branch.record)


def test_affine_forms_contain_every_value() -> None:
    random = np.random.default_rng(SEED)
    score = np.empty(60)
    for _ in range(30):
        for signs in (True, False):
            f = af.empty_forms(6, 60)
            f.size[0] = 6
            noise = random.choice([-1.0, 1.0], 30) if signs else random.uniform(-1.0, 1.0, 30)
            draws = random.choice([-1.0, 1.0], 6) if signs else random.uniform(-1.0, 1.0, 6)
            f.center[:] = random.uniform(-1.0, 1.0, 6)
            for row in range(6):
                f.gen[row, row] = 0.1
                f.extent[row] = row + 1
            af.measure(f, np.arange(6))
            values = f.center + 0.1 * draws
            steps = np.column_stack(
                [
                    random.integers(0, 6, (30, 3)),
                    random.integers(0, 4, 30),
                    random.uniform(-1, 1, (30, 3)),
                ]
            )
            assert operate(f, steps, values, noise) <= 0.0
            reduced(f, np.arange(6), score)
            for row in range(6):
                assert af.lowest(f, row) <= values[row] <= af.highest(f, row)
                size = math.fsum([*np.abs(f.gen[row, : f.extent[row]]), f.error[row]])
                assert size <= af.radius(f, row) <= size * (1.0 + 1e-9)


def _margins(
    random: np.random.Generator,
    plant: ax.AxisParameters,
    before: np.ndarray,
    after: np.ndarray,
    command: float,
    contact: int,
) -> tuple[float, float]:
    """Return by how much the new errors exceed what speed and position need, for drawn old errors.

    The forms before the sample have drawn radii; the old errors are those of the engine's state.
    """
    test = _speed()
    error = random.choice([-1.0, 1.0], 8) * (random.random(8) ** 0.3)
    inertia = plant.inertia
    values = (
        plant.constant / inertia,
        plant.coulomb / inertia,
        plant.viscous / inertia,
        plant.offset / inertia,
        before[ax.POSITION],
        0.0,
        before[ax.VELOCITY],
        before[ax.DRIVE],
    )
    scale = (0.02, 0.04, 0.05, 0.02) * np.abs(values[:4])
    radii = (*scale, 0.05, 0.0, random.uniform(0.0, 40.0), random.uniform(0.0, 8.0))
    f = af.empty_forms(forms.ROWS, 40)
    f.size[0] = 8
    rows = (
        forms.RATIO, forms.FRICTION, forms.VISCOUS, forms.OFFSET, forms.Y, forms.READ, forms.V,
        forms.DRIVE,
    )  # fmt: skip
    for column, (row, value, radius) in enumerate(zip(rows, values, radii, strict=True)):
        f.center[row] = value - radius * error[column]
        f.gen[row, column] = radius
        f.extent[row] = column + 1
    f.center[forms.ACTING] = command
    af.measure(f, np.arange(forms.ROWS))
    ends = [(f.center[row] - f.gen[row, k], f.center[row] + f.gen[row, k])
            for k, row in enumerate(rows[:4])]  # fmt: skip
    ends[2] = (max(0.0, ends[2][0]), ends[2][1])
    cell = test.loop.axis.cell(CellRatios(*ends))
    m = np.zeros(forms.MOTION)
    m[forms.CONTACT] = contact
    m[forms.SPEED_LOW], m[forms.SPEED_HIGH] = -math.inf, math.inf
    sides = {forms.IN_FRONT: 1.0, forms.BEHIND: -1.0}
    m[forms.FAR] = before[ax.POSITION] - before[ax.GAP] + sides.get(contact, 0.0) * 1.5
    m[forms.REACH_HIGH] = 3.0
    forms.prepare(f, 0, cell, NODES, WEIGHTS)
    advanced(f, cell, m)
    found = []
    for row, value in ((forms.V, after[ax.VELOCITY]), (forms.Y, after[ax.POSITION])):
        gen = f.gen[row, : f.extent[row]]
        known = f.center[row] + float(gen[:8] @ error[: gen[:8].size])
        found.append(float(np.abs(gen[8:]).sum() + f.error[row] - abs(value - known)))
    assert m[forms.SPEED_LOW] <= after[ax.VELOCITY] <= m[forms.SPEED_HIGH]
    return found[0], found[1]


@pytest.mark.parametrize("contact", [forms.ANY, forms.IN_FRONT, forms.BEHIND])
def test_one_sample_of_the_axis_is_enclosed_for_the_old_errors(contact: int) -> None:
    """The enclosure of an unknown direction holds for each value of the old errors."""
    random = np.random.default_rng([SEED, contact])
    tightest = math.inf
    for plant in _plants(_speed(), "", 25):
        state = ax.rest(30.0)
        for sample in range(60):
            command = float(random.uniform(-30.0, 30.0)) if sample % 9 > 2 else 0.0
            before = state.copy()
            assert advance(state, command, plant.as_array(), 1e-3) == OK
            margins = _margins(random, plant, before, state, command, contact)
            assert min(margins) >= 0.0, (sample, margins)
            tightest = min(tightest, margins[0])
    assert tightest < 0.2  # rad/s; a friction error of 3 % would be found
