"""Proof of a step test: all possible runs of each plant, and their metrics.

The runs of a plant start anywhere within the encoder count of the initial position. Readings and
commands of a run are numbers, not sets (encoder_phases.py). The metrics are computed from these
numbers as `report` computes them from a log. A requirement is proved if every start belongs to a
run that meets the requirement. A requirement is refuted only if the event-exact simulation from one
of the starts also violates the requirement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Literal

import msgspec
import numpy as np

from frictool.adapters.axis_model import axis_of, load_of
from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import copy_program, start_at
from frictool.control.fixed_point import FixedPointOverflow
from frictool.control.number_format import machine_in
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.digests import changed_blocks
from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.model import Model
from frictool.documents.proof import Proof, ProvedRequirement, proof_digest
from frictool.documents.provenance import Provenance
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.engine.closed_loop import COMMAND, MEASURED, RECORD_SIZE, load_of_run, measure, run
from frictool.engine.disturbances_and_faults import NO_CONDITIONS
from frictool.engine.status_codes import OK
from frictool.errors import NoSolutionError
from frictool.metrics.drive_peak import command_peak
from frictool.metrics.oscillations import oscillations
from frictool.metrics.overshoot import overshoot_percent
from frictool.metrics.reference_holds import Hold, find_holds
from frictool.metrics.response_time import response_time_95
from frictool.metrics.rest_motion import late_samples, peak_to_peak
from frictool.metrics.static_error import static_error
from frictool.plant.axis import rest
from frictool.plant.position_load import PositionLoad
from frictool.prove.axis_enclosure import plant_box
from frictool.prove.box_proof import (
    BOX_KEYS,
    BoxTest,
    box_test,
    prove_cells,
    search,
    total_share,
)
from frictool.prove.command_bound import command_bound
from frictool.prove.encoder_phases import LoopOfPlant, PhaseRun, phase_runs
from frictool.simulate.axis_variants import AxisVariant, variants_of
from frictool.simulate.document_agreement import DOCUMENTS, DocumentNames, check_agreement
from frictool.simulate.reference import parts_of
from frictool.simulate.rig import rig_of
from frictool.typing import Vector
from frictool.workers.job_sharing import share

NOMINAL = "nominal"
NOT_COVERED = "prove does not compute this requirement"
FLICKER = 1.0 + 1e-6  # largest motion that counts as rest, in encoder steps, as in `report`


@dataclass(frozen=True)
class ProofRequest:
    """Documents of a step test and the number format of the controller."""

    model: Model
    controller: Controller
    scenario: Scenario
    spec: Spec
    number: ProgramNumber = "double"


def prove_step(
    test: ProofRequest,
    provenance: Provenance,
    names: DocumentNames = DOCUMENTS,
    progress: Callable[[float], None] = lambda _: None,
    cores: int | None = None,
) -> Proof:
    """Prove the requirements of a step test for every start within an encoder count.

    The plants are the nominal plant and the plants of the scenario's `variants`. `cores` processes
    share the plants, by default one process for each core; the number of processes does not change
    the proof.

    Raises
    ------
    DocumentError
        If the documents disagree.
    NoSolutionError
        If the test, the model or the controller contains something that the proof does not support.
    """
    check_agreement(rig_of(test.model.bench, test.model), test.controller, test.scenario, names)
    plants = variants_of(test.model, test.scenario, names.model)
    outcomes: dict[int, PlantOutcome] = {}
    for index, outcome in share(partial(_prove_plant, test), plants, cores=cores):
        outcomes[index] = outcome
        progress(len(outcomes) / len(plants))
    ordered = [outcomes[index] for index in range(len(plants))]
    loop = loop_of(test, plants[0])
    step = loop.encoder_step
    count = math.floor(loop.start / step)
    proof = Proof(
        format="proof/1",
        name=f"{test.controller.name}, {test.scenario.name}",
        axis=test.model.axis,
        number=test.number,
        plants=tuple(plant.name or NOMINAL for plant in plants),
        starts=(count * step, (count + 1) * step),
        runs=sum(one.runs for one in ordered),
        open_share=max(one.open_share for one in ordered),
        requirements=tuple(map(_merged, zip(*(one.requirements for one in ordered), strict=True))),
        model=test.model,
        controller=test.controller,
        scenario=test.scenario,
        spec=test.spec,
        provenance=provenance,
    )
    return msgspec.structs.replace(proof, digest=proof_digest(proof))


@dataclass(frozen=True)
class PlantOutcome:
    """Result of the proof for one plant.

    - requirements: verdict of each requirement
    - runs: number of runs
    - open_share: share of the initial positions without a result, 0 to 1
    """

    requirements: tuple[ProvedRequirement, ...]
    runs: int
    open_share: float


def _prove_plant(test: ProofRequest, plant: AxisVariant) -> PlantOutcome:
    loop = loop_of(test, plant)
    runs = list(phase_runs(loop))
    share_left = sum(one.high - one.low for one in runs if one.reason) / loop.encoder_step
    requirements = tuple(_requirements(test, loop, plant, runs))
    return PlantOutcome(requirements, len(runs), min(1.0, share_left))


def _merged(outcomes: tuple[ProvedRequirement, ...]) -> ProvedRequirement:
    worst = min(outcomes, key=lambda one: ("refuted", "undecided", "proved").index(one.state))
    values = [one.value for one in outcomes]
    known = [value for value in values if value is not None]
    value = max(known) if len(known) == len(values) else None
    return msgspec.structs.replace(worst, value=value)


def differences(proof: Proof, again: Proof) -> tuple[str, ...]:
    """Return the keys in which a stored proof differs from a repeated proof.

    The keys include blocks of the controller that were changed after its verification.
    """
    stored, computed = (msgspec.to_builtins(one) for one in (proof, again))
    keys = [
        key
        for key in {**computed, **stored}
        if stored.get(key) != computed.get(key) and key != "digest"
    ]
    if proof.digest != proof_digest(proof):
        keys.append("digest")
    return (*keys, *(f"controller.{name}" for name in changed_blocks(proof.controller)))


def prove_again(proof: Proof, progress: Callable[[float], None] = lambda _: None) -> Proof:
    """Repeat a proof from the documents and the cells that the proof contains."""
    test = ProofRequest(proof.model, proof.controller, proof.scenario, proof.spec, proof.number)
    again = prove_step(test, proof.provenance, progress=progress)
    if not proof.cells:
        return again
    box = _box_test(test)
    return _with_cells(again, box, prove_cells(box, proof.cells, progress))


def prove_box(
    proof: Proof,
    seconds: float,
    progress: Callable[[float], None] = lambda _: None,
    cores: int | None = None,
) -> Proof:
    """Return the proof, extended by the cells of the box that a search of `seconds` proves.

    Raises
    ------
    NoSolutionError
        If the enclosure does not support the controller, the model or the scenario.
    """
    test = ProofRequest(proof.model, proof.controller, proof.scenario, proof.spec, proof.number)
    box = _box_test(test)
    return _with_cells(proof, box, search(box, seconds, progress, cores))


def _box_test(test: ProofRequest) -> BoxTest:
    _refuse_uncovered(test)
    reason = f"the controller runs in {test.number}; the box needs the number format double"
    box = (
        box_test(test.model, test.controller, test.scenario, test.spec)
        if test.number == "double"
        else reason
    )
    if isinstance(box, str):
        raise NoSolutionError(f"no cell of the box is proved: {box}")
    return box


def _with_cells(proof: Proof, box: BoxTest, cells: tuple[str, ...]) -> Proof:
    share = total_share(box, cells)
    requirements = tuple(
        msgspec.structs.replace(one, share=share) if one.key in BOX_KEYS else one
        for one in proof.requirements
    )
    proof = msgspec.structs.replace(proof, requirements=requirements, cells=cells)
    return msgspec.structs.replace(proof, digest=proof_digest(proof))


def loop_of(test: ProofRequest, plant: AxisVariant) -> LoopOfPlant:
    """Return the sampled loop of a plant.

    Raises NoSolutionError if the proof does not support the loop.
    """
    _refuse_uncovered(test)
    axis = plant.axis.checked()
    controller, scenario = test.controller, test.scenario
    assert scenario.start is not None
    try:
        running = machine_in(controller_program(controller), test.number)
    except FixedPointOverflow as error:
        raise NoSolutionError(f"{controller.name}: {error}") from None
    travel = test.model.bench.mechanics.travel
    return LoopOfPlant(
        plant_box(axis, controller.sample_period_s),
        running,
        np.concatenate(parts_of(scenario, controller.sample_period_s)),
        controller.delay_samples,
        axis.encoder_step,
        scenario.start.value,
        (-math.inf, math.inf) if travel is None else (travel.low, travel.high),
    )


def _refuse_uncovered(test: ProofRequest) -> None:
    model, controller, scenario = test.model, test.controller, test.scenario
    axis = axis_of(model)
    found = [
        name
        for name, present in (
            (
                "laws or a load of the model",
                model.laws is not None or load_of(model) != PositionLoad(),
            ),
            ("a Stribeck velocity of the model", axis.laws.stribeck_velocity > 0.0),
            ("resonances of the model", model.resonances is not None),
            ("presliding of the model", model.presliding is not None),
            ("a winding of the bench", model.bench.actuator.winding is not None),
            ("an encoder without a step", axis.encoder_step <= 0.0),
            ("a measured or observed speed", controller.velocity.source != "position"),
            ("a schedule of the controller", controller.schedule is not None),
            ("a reference from a log", not scenario.steps),
            ("disturbances of the scenario", bool(scenario.disturbances)),
            (
                "drifts or sensor faults",
                scenario.drifts is not None or bool(scenario.sensor_faults),
            ),
        )
        if present
    ]
    if found:
        raise NoSolutionError(
            f"not proved: found {', '.join(found)}; prove covers Coulomb and viscous friction, "
            "breakaway, backlash, the drive's lag and limit, and a controller that reads counts"
        )


def _requirements(
    test: ProofRequest, loop: LoopOfPlant, plant: AxisVariant, runs: list[PhaseRun]
) -> Iterator[ProvedRequirement]:
    for key in REQUIREMENTS:
        if getattr(test.spec, key) is None:
            continue
        bound = _bound(test.spec, key)
        if key == "modulus_margin":
            yield _margin(test.controller, bound)
            continue
        if key not in METRICS:
            yield ProvedRequirement(key, "undecided", bound, reason=NOT_COVERED)
            continue
        judged = _judged(test, loop, plant, runs, ProvedRequirement(key, "proved", bound))
        name = "" if judged.state == "proved" else plant.name or NOMINAL
        judged = msgspec.structs.replace(judged, plant=name)
        yield _for_the_box(test, judged) if key == "drive_peak" else judged


def _judged(
    test: ProofRequest,
    loop: LoopOfPlant,
    plant: AxisVariant,
    runs: list[PhaseRun],
    claim: ProvedRequirement,
) -> ProvedRequirement:
    key, bound = claim.key, claim.limit
    metric = METRICS[key]
    values = [
        (one, metric(test, loop, one.position, one.command)) for one in runs if not one.reason
    ]
    numbers = [(value, one) for one, value in values if isinstance(value, float)]
    worst = max((value for value, _ in numbers), default=math.inf)
    shown = worst if math.isfinite(worst) else None
    broken = [one for value, one in numbers if value > bound]
    if broken:
        widest = max(broken, key=lambda one: one.high - one.low)
        start = 0.5 * (widest.low + widest.high)
        played = _played(test, loop, plant, start, metric)
        if isinstance(played, float) and played > bound:
            return ProvedRequirement(key, "refuted", bound, shown, start=start)
        reason = "a proved bound violates the limit, but the simulated run does not"
        return ProvedRequirement(key, "undecided", bound, shown, reason=reason)
    missing = next((value for _, value in values if isinstance(value, str)), "")
    reason = missing or next((one.reason for one in runs if one.reason), "")
    state: Literal["proved", "undecided"] = "undecided" if reason else "proved"
    return ProvedRequirement(key, state, bound, shown, reason=reason)


def _for_the_box(test: ProofRequest, peak: ProvedRequirement) -> ProvedRequirement:
    """Return the verdict on the drive peak, extended to every plant of the parameter box.

    If the bound of the command is within the limit, the requirement is proved, even if the runs of
    a plant do not decide the requirement. A bound above the limit proves nothing. A refuted
    requirement stays refuted, because the run that violates it is a counterexample.
    """
    bound = command_bound(test.controller, test.number)
    if bound > peak.limit or peak.state == "refuted":
        return peak
    if peak.state == "proved":
        return msgspec.structs.replace(peak, box=bound)
    return ProvedRequirement(peak.key, "proved", peak.limit, bound, box=bound)


def _bound(spec: Spec, key: str) -> float:
    limit = getattr(spec, key)
    if key == "rest":
        return float(spec.rest.drive)
    value = getattr(limit, "value", limit)
    return float(value) if isinstance(value, (int, float)) else math.nan


def _margin(controller: Controller, bound: float) -> ProvedRequirement:
    certificate = controller.certificate
    margins = [
        one.modulus_margin
        for one in (certificate.bounds if certificate is not None else ())
        if one.modulus_margin is not None
    ]
    if margins and max(margins) >= bound:
        reason = "by the certificate of the controller; frictool verify repeats this proof"
        best = max(margins)
        return ProvedRequirement("modulus_margin", "proved", bound, best, reason=reason, box=best)
    reason = "the certificate of the controller proves no margin that reaches the limit"
    return ProvedRequirement("modulus_margin", "undecided", bound, reason=reason)


Metric = Callable[[ProofRequest, LoopOfPlant, Vector, Vector], float | str]


def _played(
    test: ProofRequest, loop: LoopOfPlant, plant: AxisVariant, start: float, metric: Metric
) -> float | str:
    machine = copy_program(loop.running)
    start_at(machine, measure(start, loop.encoder_step))
    record = np.empty((loop.reference.size, RECORD_SIZE))
    status = run(
        plant.array,
        rest(start),
        machine,
        loop.reference,
        loop.plant.period,
        loop.delay,
        record,
        load_of_run(plant.array, load_of(test.model).as_array()),
        NO_CONDITIONS,
    )
    if status != OK:
        return "the engine cannot simulate the run from this start"
    position, command = (np.ascontiguousarray(record[:, column]) for column in (MEASURED, COMMAND))
    return metric(test, loop, position, command)


def _holds(loop: LoopOfPlant, position: Vector) -> tuple[Hold, ...]:
    return find_holds(loop.reference, position, loop.encoder_step)


def _times(loop: LoopOfPlant) -> Vector:
    return loop.plant.period * np.arange(loop.reference.size, dtype=np.float64)


def _of_steps(value: Callable[[LoopOfPlant, Hold, Vector], float]) -> Metric:
    def metric(
        test: ProofRequest, loop: LoopOfPlant, position: Vector, command: Vector
    ) -> float | str:
        holds = [hold for hold in _holds(loop, position) if hold.origin is not None]
        if not holds:
            return "the scenario has no step"
        return max(value(loop, hold, position) for hold in holds)

    return metric


def _response(loop: LoopOfPlant, hold: Hold, position: Vector) -> float:
    assert hold.origin is not None
    times = _times(loop)
    return response_time_95(
        hold.of(times), hold.of(position), hold.origin, hold.target, loop.encoder_step
    )


def _overshoot(loop: LoopOfPlant, hold: Hold, position: Vector) -> float:
    assert hold.origin is not None
    return overshoot_percent(hold.of(position), hold.origin, hold.target, loop.encoder_step)


def _oscillations(loop: LoopOfPlant, hold: Hold, position: Vector) -> float:
    assert hold.origin is not None
    return float(oscillations(hold.of(position), hold.origin, hold.target, loop.encoder_step))


def _static(
    test: ProofRequest, loop: LoopOfPlant, position: Vector, command: Vector
) -> float | str:
    holds = _holds(loop, position)
    if not holds:
        return "the reference of the scenario is never constant"
    step = loop.encoder_step
    return max(static_error(hold.of(position), hold.target, step) for hold in holds)


def _peak(test: ProofRequest, loop: LoopOfPlant, position: Vector, command: Vector) -> float | str:
    return float(command_peak(command))


def _rest(test: ProofRequest, loop: LoopOfPlant, position: Vector, command: Vector) -> float | str:
    """Return the largest |command| [A | V] at rest, or infinity if the axis moves.

    If the reference is never constant for long enough, the result is a text with this reason.
    """
    after = float(test.spec.rest.after_s)
    worst = -math.inf
    times = _times(loop)
    for hold in _holds(loop, position):
        late = late_samples(hold.of(times), after)
        if late is None:
            continue
        if peak_to_peak(hold.of(position)[late]) > FLICKER * loop.encoder_step:
            return math.inf
        worst = max(worst, command_peak(hold.of(command)[late]))
    return worst if math.isfinite(worst) else f"the reference is never constant for {after:g} s"


METRICS: dict[str, Metric] = {
    "response_time_95_s": _of_steps(_response),
    "overshoot_percent": _of_steps(_overshoot),
    "oscillations": _of_steps(_oscillations),
    "static_error": _static,
    "drive_peak": _peak,
    "rest": _rest,
}
