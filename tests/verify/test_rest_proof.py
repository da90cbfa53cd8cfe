"""Proof of rest: axes that the engine releases in the proved set stop inside the band and stay."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from frictool.documents.certificate import Certificate, RestProof
from frictool.documents.controller import Controller, Limiter, Velocity
from frictool.documents.design import Design
from frictool.documents.model import Model
from frictool.documents.provenance import Provenance
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.synth.cycle_search import find_cycle
from frictool.synth.design import design_controller
from frictool.verify.recheck import verify
from frictool.verify.rest_proof import least_friction, prove_rest
from frictool.verify.rest_view import rest_lines
from studies.rigs.clutch_model import ROOT
from tests.support.certified_controllers import certified, few_interior_points
from tests.support.released_axes import furthest_release

SEED = 20261127
MASS = ROOT / "configs/mass"


def _rest(controller: Controller) -> RestProof:
    assert controller.certificate is not None
    proof = prove_rest(controller, controller.certificate)
    assert proof is not None
    return proof


def _state(controller: Controller, name: str) -> str:
    return next(check.state for check in _rest(controller).checks if check.name == name)


@pytest.mark.parametrize("name", ["speed", "fast"])
def test_released_axes_stop_within_the_band(name: str) -> None:
    """`make accept` releases 2000 axes of each."""
    controller = certified(name)  # type: ignore[arg-type]
    proof = _rest(controller)
    assert proof.verdict == "proved"
    assert 0.5 < furthest_release(controller, proof, 300) < 1.0


def test_a_band_below_a_count_is_not_proved() -> None:
    controller = certified("speed")
    law = msgspec.structs.replace(controller.position_law, band=0.1)  # a count is 0.112 rad
    broken = msgspec.structs.replace(controller, position_law=law)
    assert _rest(broken).verdict == "undecided"
    assert _state(broken, "band") == "fails"
    assert _rest(broken).disturbance == 0.0


def test_an_axis_without_friction_is_not_proved() -> None:
    controller = certified("speed")
    assert controller.certificate is not None
    box = msgspec.structs.replace(controller.certificate.box, coulomb=(0.0, 0.18))
    certificate = msgspec.structs.replace(controller.certificate, box=box)
    proof = prove_rest(controller, certificate)
    assert proof is not None
    assert proof.verdict == "undecided"


def test_a_limiter_that_a_count_excites_is_not_proved() -> None:
    controller = certified("speed")
    limiter = Limiter("energy", band=1.8, inertia=1.32e-5, coulomb=0.099)
    quiet = msgspec.structs.replace(
        controller, structure="position", position_law=None, limiter=limiter
    )
    assert _rest(quiet).verdict == "proved"
    assert _rest(quiet).speed == 0.0  # the release depends on the speed
    strong = msgspec.structs.replace(limiter, virtual_coulomb=0.3, virtual_speed=10.0)
    velocity = Velocity(order=1, bandwidth_rad_s=300.0)
    chatters = msgspec.structs.replace(quiet, limiter=strong, velocity=velocity)
    assert _rest(chatters).verdict == "undecided"
    assert _state(chatters, "count_pulse") == "fails"
    sections = msgspec.structs.replace(quiet.linear, form="sos", sos_anti_windup=(0.0,) * 4)
    assert _state(msgspec.structs.replace(quiet, linear=sections), "frozen_integrator") == "fails"


def test_an_edited_proof_of_rest_is_seen() -> None:
    controller = certified("speed")
    assert controller.certificate is not None
    proof = _rest(controller)

    def with_rest(rest: RestProof) -> Certificate:
        assert controller.certificate is not None
        return msgspec.structs.replace(controller.certificate, rest=rest)

    honest = msgspec.structs.replace(controller, certificate=with_rest(proof))
    with few_interior_points():
        assert not verify(honest).differences
    random = np.random.default_rng(SEED)
    fields = ("disturbance", "stopping_disturbance", "speed", "stop_time_s")
    values = {name: random.uniform(1.001, 2.0) * getattr(proof, name) for name in fields}
    rest = with_rest(msgspec.structs.replace(proof, **values))
    with few_interior_points():
        found = verify(msgspec.structs.replace(controller, certificate=rest))
    keys = {one.key for one in found.differences}
    assert keys == {f"certificate.rest.{name}" for name in fields}


def test_a_deleted_proof_of_rest_is_named() -> None:
    controller = certified("speed")
    assert controller.certificate is not None
    without = msgspec.structs.replace(controller.certificate, rest=None)
    (line,) = rest_lines(controller, without)
    assert "this document states no proof for its band" in line


def test_the_cycle_of_table_5_1_is_found() -> None:
    model, spec = load(MASS / "model.yaml", Model), load(MASS / "spec.yaml", Spec)
    here = Provenance("a test", "0")
    for name, cycles in (("pid", True), ("pid_limiter", False)):
        design = load(MASS / f"designs/{name}.yaml", Design)
        cycle = find_cycle(model, design_controller(model, spec, design, here))
        assert (cycle is not None) == cycles
        if cycle is not None:
            assert cycle.period_s == pytest.approx(36.0, rel=0.05)  # numbers.md, table 5.1


@pytest.mark.parametrize("name", ["speed", "fast"])
def test_the_bounds_of_the_proof_are_those_of_uniform_braking(name: str) -> None:
    """v^2 = 2 a s on the heaviest axis, with the friction that the stopping disturbance leaves."""
    controller = certified(name)  # type: ignore[arg-type]
    assert controller.certificate is not None
    assert controller.position_law is not None
    proof = _rest(controller)
    heaviest = controller.certificate.box.inertia[1]
    braking = (proof.disturbance - proof.stopping_disturbance) / heaviest
    band, step = controller.position_law.band, controller.bench.encoder.resolution
    (arrival,) = (check for check in proof.checks if check.name == "arrival_speed")
    for speed, distance in ((proof.speed, band - step), (arrival.limit, 2.0 * band - step)):
        assert speed**2 / (2.0 * braking) == pytest.approx(distance, rel=1e-6)
        assert speed**2 / (2.0 * braking) <= distance
    assert proof.stop_time_s == pytest.approx(proof.speed / braking, rel=1e-6)


@pytest.mark.parametrize("low", [0.0, 0.01, 0.05, 0.2])
def test_the_least_friction_is_that_inside_the_backlash(low: float) -> None:
    """It falls with the friction of the axis, and is never above either of the two."""
    controller = certified("speed")
    assert controller.certificate is not None
    mechanics = controller.bench.mechanics
    assert mechanics.backlash_coulomb is not None
    box = msgspec.structs.replace(controller.certificate.box, coulomb=(low, 0.3))
    inside = mechanics.backlash_coulomb.interval[0] * min(1.0, low / mechanics.coulomb.value)
    least = least_friction(controller, box)
    assert least == pytest.approx(min(low, inside), rel=1e-6)
    assert least <= min(low, inside)
