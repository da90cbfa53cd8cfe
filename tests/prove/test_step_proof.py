"""Proof of a step test: it holds every run of the engine; broken loops are not proved."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import msgspec
import numpy as np
import pytest

from frictool.adapters.axis_model import axis_of
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import control_step, copy_program, start_at
from frictool.control.number_format import machine_in
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.model import Model
from frictool.documents.proof import Proof, ProvedRequirement, proof_digest
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario, Step
from frictool.documents.spec import Spec
from frictool.engine.axis_motion import advance
from frictool.engine.closed_loop import COMMAND, RECORD_SIZE, load_of_run, run
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.status_codes import OK
from frictool.errors import NoSolutionError
from frictool.metrics.response_time import response_time_95
from frictool.plant import axis as ax
from frictool.plant.position_load import PositionLoad
from frictool.prove.command_bound import command_bound
from frictool.prove.encoder_phases import LoopOfPlant, phase_runs
from frictool.prove.proof_view import lines, verdict_of
from frictool.prove.step_proof import (
    ProofRequest,
    _for_the_box,
    differences,
    loop_of,
    prove_step,
)
from frictool.simulate.axis_variants import variants_of
from frictool.verify.rest_proof import prove_rest
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.certified_controllers import certified
from tests.support.simulated_mechanisms import one_axis

SEED = 20261127
LOW, HIGH = (1.11e-5, 0.0, 0.018, 12.8e-3), (1.53e-5, 7.62e-4, 0.18, 14.0e-3)
MADE = ("speed", "fast")
HERE = Provenance("a test", "0")
RIG = ROOT / "configs/clutch"


def _step_test(controller: Controller, seconds: float = 0.6) -> ProofRequest:
    """One step of the clutch, judged without rest, which needs a hold of 15 s."""
    scenario = load(RIG / "scenarios/prove.yaml", Scenario)
    first = msgspec.structs.replace(scenario.steps[0], duration_s=seconds)
    spec = msgspec.structs.replace(load(RIG / "spec.yaml", Spec), rest=None)
    one_step = msgspec.structs.replace(scenario, steps=(first,))
    return ProofRequest(clutch_model(), controller, one_step, spec)


def _loop(test: ProofRequest) -> LoopOfPlant:
    return loop_of(test, variants_of(test.model, test.scenario)[0])


def _play(test: ProofRequest, start: float) -> tuple[np.ndarray, np.ndarray]:
    loop = _loop(test)
    p = axis_of(test.model).as_array()
    step = loop.encoder_step
    machine = copy_program(loop.running)
    start_at(machine, math.floor(start / step) * step)
    state, before = ax.rest(start), 0.0
    position, command = np.empty((2, loop.reference.size))
    for k, reference in enumerate(loop.reference):
        position[k] = math.floor(state[ax.POSITION] / step) * step
        command[k] = control_step(machine, reference, position[k], state[ax.VELOCITY])
        assert advance(state, before, p, loop.plant.period) == 0
        before = command[k]
    return position, command


@cache
def _proof() -> Proof:
    return prove_step(_step_test(certified("speed")), HERE)


@pytest.mark.parametrize(
    ("name", "count"),
    [("speed", 8), *(pytest.param(name, 80, marks=pytest.mark.accept) for name in MADE)],
)
def test_every_run_of_the_engine_is_among_the_proved_ones(name: str, count: int) -> None:
    test = _step_test(certified(name), 0.35)  # type: ignore[arg-type]
    runs = list(phase_runs(_loop(test)))
    low, high = min(one.low for one in runs), max(one.high for one in runs)
    step = _loop(test).encoder_step
    assert high - low == pytest.approx(step)
    reached = low
    for one in sorted(runs, key=lambda one: one.low):  # the parts cover the count
        assert one.low <= reached
        reached = max(reached, one.high)
    random = np.random.default_rng(SEED)
    # starts anywhere, and on both sides of the ends of parts, where a count differs
    ends = random.choice([one.low for one in runs[1:]], count // 4)
    starts = [*random.uniform(low, high, count // 2), *(ends - 2e-9), *(ends + 2e-9)]
    for start in starts:
        position, command = _play(test, float(start))
        covering = [one for one in runs if one.low <= start <= one.high]
        assert any(
            np.array_equal(one.position, position) and np.array_equal(one.command, command)
            for one in covering
        )


def test_the_speed_loop_is_proved() -> None:
    proof = _proof()
    assert verdict_of(proof) == "proved"
    assert proof.open_share == 0.0
    worst = {one.key: one.value for one in proof.requirements}
    test = _step_test(certified("speed"))
    loop = _loop(test)
    times = loop.plant.period * np.arange(loop.reference.size)
    random = np.random.default_rng(SEED)
    found = [
        response_time_95(times, _play(test, float(start))[0], proof.starts[0], 55.0, 0.1122)
        for start in random.uniform(*proof.starts, 20)
    ]
    assert 0.9 * worst["response_time_95_s"] <= max(found) <= worst["response_time_95_s"]


def _louder(controller: Controller, factor: float) -> Controller:
    space = controller.linear.discrete
    rows = {
        name: tuple(tuple(factor * value for value in row) for row in getattr(space, name))
        for name in ("c", "d")
    }
    louder = msgspec.structs.replace(space, **rows)
    linear = msgspec.structs.replace(controller.linear, discrete=louder)
    return msgspec.structs.replace(controller, linear=linear)


def _with_law(controller: Controller, **values: float) -> Controller:
    law = msgspec.structs.replace(controller.position_law, **values)
    return msgspec.structs.replace(controller, position_law=law)


def _filtered(controller: Controller, frequency: float) -> Controller:
    prefilter = msgspec.structs.replace(controller.prefilter, natural_frequency_rad_s=frequency)
    return msgspec.structs.replace(controller, prefilter=prefilter)


BROKEN = {
    "loud": lambda one: _louder(one, 6.0),
    "reversed": lambda one: _louder(one, -1.0),
    "quiet": lambda one: _louder(one, 0.02),
    "steep law": lambda one: _with_law(one, gain=600.0),
    "flat law": lambda one: _with_law(one, gain=20.0),
    "steep law, narrow band": lambda one: _with_law(one, gain=400.0, band=0.04),
    "wide band": lambda one: _with_law(one, band=12.0, settled_speed=400.0),
    "slow prefilter": lambda one: _filtered(one, 9.0),
    "weak drive": lambda one: msgspec.structs.replace(one, drive_limit=4.0),
    "late release": lambda one: _with_law(one, settled_speed=600.0, band=6.0),
}


LONG = {"flat law", "loud", "steep law", "steep law, narrow band", "slow prefilter", "late release"}


@pytest.mark.parametrize(
    "fault",
    [pytest.param(one, marks=pytest.mark.accept) if one in LONG else one for one in BROKEN],
)
def test_broken_controllers_are_not_proved(fault: str) -> None:
    test = _step_test(BROKEN[fault](certified("speed")), 0.3)
    proof = prove_step(test, HERE)
    assert verdict_of(proof) != "proved"
    for one in proof.requirements:
        if one.state == "refuted" and one.key == "response_time_95_s":
            assert one.start is not None
            loop = _loop(test)
            times = loop.plant.period * np.arange(loop.reference.size)
            position, _ = _play(test, one.start)
            step = loop.encoder_step
            assert response_time_95(times, position, position[0], 55.0, step) > one.limit


def _leaves(value: object, path: tuple[object, ...] = ()) -> list[tuple[object, ...]]:
    if isinstance(value, dict):
        return [leaf for key, one in value.items() for leaf in _leaves(one, (*path, key))]
    if isinstance(value, list):
        return [leaf for i, one in enumerate(value) for leaf in _leaves(one, (*path, i))]
    return [path]


def _edited(values: dict[str, object], path: tuple[object, ...], factor: float) -> object:
    edited = msgspec.json.decode(msgspec.json.encode(values))
    holder = edited
    for key in path[:-1]:
        holder = holder[key]
    old = holder[path[-1]]
    holder[path[-1]] = (
        not old
        if isinstance(old, bool)
        else factor * old + (factor - 1.0)
        if isinstance(old, float)
        else old + 1
        if isinstance(old, int)
        else f"{old}x"
    )
    return edited


def test_no_edit_of_a_proof_passes() -> None:
    proof = _proof()
    assert differences(proof, proof) == ()
    values = msgspec.to_builtins(proof)
    random = np.random.default_rng(SEED)
    leaves = [path for path in _leaves(values) if path[0] != "digest"]
    refused = seen = 0
    for index in random.integers(len(leaves), size=400):
        edited = _edited(values, leaves[index], float(random.uniform(1.0 + 1e-9, 2.0)))
        try:
            document = msgspec.convert(edited, Proof)
        except msgspec.ValidationError:
            refused += 1
            continue
        seen += 1
        assert proof_digest(document) != document.digest
        # with a new digest, an edited claim contradicts the proof made again from the documents
        claims = msgspec.structs.replace(document, digest=proof_digest(document))
        if leaves[index][0] in ("requirements", "runs", "open_share", "starts", "plants"):
            assert leaves[index][0] in differences(claims, proof)
        elif leaves[index][0] == "controller" and leaves[index][1] != "verified":
            changed = any(one.startswith("controller.") for one in differences(claims, proof))
            assert changed or leaves[index][1] in ("name", "provenance")
    assert refused + seen == 400
    assert seen > 200


def test_every_vertex_is_judged_alike_by_any_number_of_processes() -> None:
    test = _step_test(certified("speed"), 0.03)
    scenario = msgspec.structs.replace(test.scenario, variants="vertices")
    request = ProofRequest(test.model, test.controller, scenario, test.spec)
    proof = prove_step(request, HERE, cores=1)
    assert prove_step(request, HERE, cores=2) == proof
    assert proof.plants[:2] == ("nominal", "v01")
    assert len(proof.plants) == 17
    assert proof.runs > 17


def _random_plants(count: int) -> list[np.ndarray]:
    """Draw plants of the clutch's box (thesis, table 5.2), some of them on its edges."""
    random = np.random.default_rng(SEED)
    plants = []
    for share in np.clip(random.uniform(-0.2, 1.2, (count, 4)), 0.0, 1.0):
        values = np.array(LOW) + share * (np.array(HIGH) - np.array(LOW))
        names = ("inertia", "viscous", "coulomb", "constant")
        parameters = dict(zip(names, map(float, values), strict=True))
        plants.append(axis_of(clutch_model(), **parameters).as_array())
    return plants


@pytest.mark.parametrize("number", ["double", "float", "q31"])
def test_no_plant_of_the_box_exceeds_the_bound_of_the_command(number: ProgramNumber) -> None:
    controller = certified("fast")
    bound = command_bound(controller, number)
    assert bound == pytest.approx(controller.drive_limit, rel=1e-6)
    machine = machine_in(controller_program(controller), number)
    reference = np.full(200, 55.0)
    largest = 0.0
    for plant in _random_plants(20):
        running = copy_program(machine)
        start_at(running, 5.0)
        record = np.empty((200, RECORD_SIZE))
        load = load_of_run(plant, PositionLoad().as_array())
        status = run(plant, ax.rest(5.0), running, reference, 1e-3, 1, record, load, NO_CONDITIONS)
        assert status == OK
        largest = max(largest, float(np.abs(record[:, COMMAND]).max()))
    # the limit is met, so that no smaller bound is valid
    assert 0.999 * bound < largest <= bound


def test_the_drive_limit_proves_the_peak_for_the_box_or_for_no_plant_between() -> None:
    controller = certified("fast")
    test = _step_test(controller, 0.05)

    def peak(limit: float) -> ProvedRequirement:
        loose = msgspec.structs.replace(controller, drive_limit=limit)
        proof = prove_step(replace(test, controller=loose), HERE)
        found = next(one for one in proof.requirements if one.key == "drive_peak")
        line = next(line for line in lines(proof) if f"limit {found.limit:.4g}" in line)
        assert ("every plant of the box" in line) == (found.box is not None)
        return found

    assert (peak(50.0).state, peak(50.0).box) == ("proved", 50.0)
    assert peak(60.0).box is None


def test_a_counterexample_is_never_replaced_by_the_bound_of_the_command() -> None:
    test = _step_test(certified("fast"), 0.05)
    found = ProvedRequirement("drive_peak", "refuted", 60.0, 61.0, start=5.0)
    assert _for_the_box(test, found) == found
    still_open = msgspec.structs.replace(found, state="undecided")
    assert _for_the_box(test, still_open).state == "proved"


def test_rest_in_the_band_is_stated_from_the_box_and_not_from_the_document() -> None:
    proof = _proof()
    stated = "rest: proved for every plant of the box"
    assert any(line.startswith(stated) for line in lines(proof))
    certificate = proof.controller.certificate
    assert certificate is not None
    # without friction nothing stops the axis, whatever the document claims
    box = msgspec.structs.replace(certificate.box, coulomb=(0.0, 0.18))
    claim = prove_rest(proof.controller, certificate)
    assert claim is not None
    assert claim.verdict == "proved"
    slippery = msgspec.structs.replace(certificate, box=box, rest=claim)
    controller = msgspec.structs.replace(proof.controller, certificate=slippery)
    edited = msgspec.structs.replace(proof, controller=controller)
    assert not any(line.startswith(stated) for line in lines(edited))


def test_a_controller_without_bounds_of_its_states_has_no_bound_of_its_command() -> None:
    controller = certified("fast")
    mechanics = msgspec.structs.replace(controller.bench.mechanics, travel=None)
    bench = msgspec.structs.replace(controller.bench, mechanics=mechanics)
    endless = msgspec.structs.replace(controller, bench=bench)
    assert math.isinf(command_bound(endless, "double"))


def test_what_is_not_covered_is_refused() -> None:
    controller = certified("speed")
    nonlinear = load(RIG / "nonlinear.yaml")
    test = _step_test(controller)
    with pytest.raises(NoSolutionError, match="laws or a load"):
        _loop(ProofRequest(nonlinear, controller, test.scenario, test.spec))
    contact = load(RIG.parent / "mass/contact.yaml", Model).presliding
    bent = msgspec.structs.replace(one_axis(), presliding=contact)
    with pytest.raises(NoSolutionError, match="presliding of the model"):
        _loop(ProofRequest(bent, controller, test.scenario, test.spec))
    ramp = Step(ramp_to=Quantity(55.0, 55.0, 55.0), duration_s=0.2)
    scenario = msgspec.structs.replace(test.scenario, steps=(ramp,))
    proof = prove_step(ProofRequest(test.model, controller, scenario, test.spec), HERE)
    states = {one.key: one.state for one in proof.requirements}
    assert states["response_time_95_s"] == "undecided"
