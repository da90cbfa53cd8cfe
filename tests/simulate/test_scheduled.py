"""A scheduled controller from synthesis to the target: its corners run with gains of their own, and
it is told the plant's parameters."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import msgspec
import numpy as np
import pytest

from frictool.adapters.controller_composition import controller_program
from frictool.control.compiled_program import compile_program, control_step, hold, start_at
from frictool.documents.controller import Controller
from frictool.documents.design import Design
from frictool.documents.provenance import Provenance, digest
from frictool.documents.registry import load
from frictool.documents.scenario import Scenario
from frictool.documents.spec import Spec
from frictool.documents.writing import to_yaml
from frictool.export.rounded_loop import rounded_loop
from frictool.simulate.closed_loop import SimulationRequest, scheduled, simulate_closed_loop
from frictool.simulate.compiled_target import compiled_target
from frictool.synth.design import ProofScope, synthesise_verified
from studies.command_line import run
from studies.rigs.clutch_model import ROOT, clutch_model

RIG, HERE = ROOT / "configs/clutch", Provenance("a test", "0")


@pytest.fixture(scope="module")
def controller() -> Controller:
    design = msgspec.structs.replace(
        load(RIG / "designs/speed.yaml", Design), scheduled=True, schedule=("constant",)
    )
    return synthesise_verified(
        clutch_model(),
        load(RIG / "spec.yaml", Spec),
        design,
        HERE,
        scope=ProofScope(vertices_only=True),
    ).controller


def scenario() -> Scenario:
    whole = load(RIG / "scenarios/steps.yaml", Scenario)
    return msgspec.structs.replace(
        whole, steps=(msgspec.structs.replace(whole.steps[0], duration_s=0.3),), variants="vertices"
    )


def test_each_corner_has_stable_gains_in_its_own_coordinates(controller: Controller) -> None:
    for corner in controller.schedule.corners:
        a, c, gains = (
            np.array(corner.discrete.a),
            np.array(corner.discrete.c),
            np.array(corner.anti_windup),
        )
        assert np.max(np.abs(np.linalg.eigvals(a - np.outer(gains, c[0])))) < 1.0
    assert rounded_loop(controller, "float").modulus_margin > 0.5


def test_each_vertex_is_played_with_its_own_constant(controller: Controller) -> None:
    program = controller_program(controller)
    places = scheduled(controller, program)
    assert list(places) == ["constant"]
    log = simulate_closed_loop(clutch_model(), controller, scenario(), HERE)
    commands = []
    for vertex in controller.verified.vertices:
        stream = next(one for one in log.streams if one.topic == f"/axis/{vertex.name}")
        made = compile_program(program)
        hold(made, places["constant"], vertex.constant)
        start_at(made, float(stream.signals["position"][0]))
        pairs = zip(stream.signals["reference"], stream.signals["position"], strict=True)
        drives = [
            control_step(made, float(reference), float(position), 0.0)
            for reference, position in pairs
        ]
        np.testing.assert_array_equal(drives, stream.signals["command"])
        commands.append(drives)
    assert not np.array_equal(commands[0], commands[1])


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler on the PATH")
def test_the_compiled_code_is_told_the_same(controller: Controller, tmp_path: Path) -> None:
    document = tmp_path / "controller.yaml"
    document.write_text(to_yaml(controller))
    assert run("export", str(document), "-o", str(tmp_path / "c")).code == 0
    subprocess.run(
        "cc *.c -lm && ./a.out", cwd=tmp_path / "c", shell=True, check=True, capture_output=True
    )

    program = controller_program(controller)
    code = compiled_target(
        tmp_path / "c",
        digest(document),
        "controller.yaml",
        tuple(program.inputs),
        tuple(scheduled(controller, program)),
    )
    ours, theirs = (
        simulate_closed_loop(
            clutch_model(), controller, scenario(), HERE, request=SimulationRequest(target=target)
        )
        for target in (None, code)
    )
    for one, other in zip(ours.streams, theirs.streams, strict=True):
        np.testing.assert_array_equal(one.signals["command"], other.signals["command"])
