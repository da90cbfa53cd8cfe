"""A law that is added by the recipe alone is known to documents, schema and commands."""

from __future__ import annotations

import json
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest

from frictool.engine.drive import held
from frictool.engine.law_simulation import run_law
from frictool.logs import read_log
from tests.support.recipes import follow, frictool

MECHANISM = """\
format: mechanism/1
name: drag
blocks:
  cart: {mass: {value: 1, unit: kg}}
links:
  fluid:
    kind: friction
    on: cart
    law: coulomb_drag
    parameters: {coulomb: {value: 1, unit: N}, drag: {value: 2, unit: N s^2/m^2}}
sources:
  pull: {on: cart, drive: effort, effort: {value: 3, unit: N}}
"""
SCENARIO = """\
format: scenario/1
name: pull
axis: linear
duration_s: 1
sources:
  pull: [{kind: step, level: {value: 0, unit: N}, at_s: 0}]
"""


@pytest.fixture(scope="module")
def overlay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("law")
    follow("A friction law", folder)
    (folder / "mechanism.yaml").write_text(MECHANISM)
    (folder / "scenario.yaml").write_text(SCENARIO)
    return folder


def test_a_mechanism_with_the_law_moves_as_its_equation_says(overlay: Path) -> None:
    """v' = 3 - 1 - 2 v^2 from rest has the solution v = tanh(2 t)."""
    run = overlay / "run.mcap"
    done = frictool(
        overlay,
        "simulate",
        overlay / "mechanism.yaml",
        "--scenario",
        overlay / "scenario.yaml",
        "-o",
        run,
    )
    assert done.returncode == 0, done.stderr
    (stream,) = read_log(run).streams
    np.testing.assert_allclose(
        stream.signals["cart_velocity"], np.tanh(2.0 * stream.time), atol=1e-6
    )


def test_a_body_under_the_law_alone_moves_alike(overlay: Path) -> None:
    """In the engine of one body, which is exact where it knows the slip force as a line."""
    file = overlay / "frictool/friction/coulomb_drag.py"
    spec = spec_from_file_location("coulomb_drag", file)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    law, times = module.LAW, np.linspace(0.0, 1.0, 21)
    p = law.pack({"coulomb": 1.0, "drag": 2.0})
    run = run_law(law, p, 1.0, [(1.0, held(3.0))], times)
    np.testing.assert_allclose(run.samples[:, 1], np.tanh(2.0 * times), atol=1e-6)


def test_schema_help_messages_and_equations_know_the_law(overlay: Path) -> None:
    described = json.loads(frictool(overlay, "schema", "mechanism").stdout)["$defs"]
    assert "coulomb_drag" in described["FrictionOf"]["properties"]["law"]["enum"]
    assert "coulomb_drag" in frictool(overlay, "compare", "--help").stdout
    assert "coulomb_drag" in frictool(overlay, "compare", "--law", "drag").stderr
    assert "coulomb_drag(" in frictool(overlay, "equations", overlay / "mechanism.yaml").stdout
    wrong = overlay / "wrong.yaml"
    wrong.write_text(MECHANISM.replace("drag: {value: 2", "drag: {value: -2"))
    refused = frictool(overlay, "equations", wrong)
    assert refused.returncode == 3
    assert "drag is -2 N s^2/m^2; allowed: a finite number >= 0" in refused.stderr


def test_the_law_is_compared(overlay: Path) -> None:
    """Without a value for the drag the law is Coulomb's."""
    done = frictool(overlay, "compare", "--law", "coulomb", "--law", "coulomb_drag", "--json")
    assert done.returncode == 0, done.stderr
    laws = json.loads(done.stdout)["laws"]
    assert laws["coulomb_drag"]["drift"] == pytest.approx(laws["coulomb"]["drift"], abs=1e-9)
