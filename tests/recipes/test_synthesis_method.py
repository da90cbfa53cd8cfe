"""A synthesis method that is added by the recipe alone is known to documents, schema and synth."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from frictool.adapters.model_polytope import polytope
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.documents.synthesis_methods import METHODS
from frictool.synth.methods import solver
from tests.support.documentation_pages import ROOT, text_of
from tests.support.recipes import follow, frictool_each

RIG = ROOT / "configs/clutch"
DESIGN = """\
format: design/1
name: tried
axis: rotary
structure: position
method: lead
domain: continuous
weights:
  bandwidth_rad_s: 20
  disturbance: 0.1
  drive: 0.05
  command: 0
  noise: {value: 0, unit: rad}
"""


@pytest.fixture(scope="module")
def overlay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("method")
    follow("A synthesis method", folder)
    return folder


def synthesis(overlay: Path, name: str, design: str) -> list[str | Path]:
    """Return the command line of `synth` with this design."""
    path = overlay / f"{name}.design.yaml"
    path.write_text(design)
    spec = ["--spec", RIG / "spec.yaml", "--design", path, "--vertices-only", "--no-play", "--json"]
    return ["synth", RIG / "nonlinear.yaml", *spec, "-o", overlay / f"{name}.yaml"]


def test_the_controller_of_the_method_crosses_over_where_its_equation_says(overlay: Path) -> None:
    done, verified = frictool_each(
        overlay,
        synthesis(overlay, "controller", DESIGN),
        ["verify", overlay / "controller.yaml"],
    )
    assert done.returncode == 0, done.stderr
    view = json.loads(done.stdout)
    assert (view["method"], view["order"]) == ("lead", 1)
    assert "lead: zero at 5 rad/s, pole at 80 rad/s" in view["notes"]
    stored = yaml.safe_load((overlay / "controller.yaml").read_text())
    a, b, c, d = (float(stored["linear"]["discrete"][part][0][0]) for part in "abcd")
    z, s = np.exp(20.0j * stored["sample_period_s"]), 20.0j
    centre = polytope(load(RIG / "nonlinear.yaml", Model)).centre
    plant = centre.constant / (s * (centre.inertia * s + centre.viscous))
    assert abs((c * b / (z - a) + d) * plant) == pytest.approx(1.0, rel=1e-3)
    assert verified.returncode == 1  # a controller of --vertices-only has no certificate
    assert "figures recomputed at 16 vertices: all equal the stored figures" in verified.stdout


def test_schema_help_and_messages_know_the_method(overlay: Path) -> None:
    wrong = (
        (f"{DESIGN}order: 3\n", "order belongs to methods .*, not to method lead; remove the key"),
        (DESIGN.replace(": lead", ": leed"), r"found 'leed'.*allowed: lpv \|.*\| lead \| pid"),
        (
            DESIGN.replace("structure: position", "structure: speed_cascade")
            + "position_law: {action: none, formula: sqrt(F/J)}\n",
            "method lead belongs to structure position",
        ),
    )
    *schemas, shown, first, second, third = frictool_each(
        overlay,
        ["schema", "design"],
        ["schema", "controller"],
        ["synth", "--help"],
        *(synthesis(overlay, f"wrong{k}", text) for k, (text, _) in enumerate(wrong)),
    )
    design, stored = (
        json.loads(schema.stdout)["$defs"][name]
        for schema, name in zip(schemas, ("Design", "Controller"), strict=True)
    )
    assert "lead" in design["properties"]["method"]["enum"]
    assert re.search(r"`domain` \([^)]*, lead\b", design["description"])
    assert {"lead", "own"} <= set(stored["properties"]["method"]["enum"])
    assert re.search(r"\n +lead +phase lead at", shown.stdout)
    for refused, (_, message) in zip((first, second, third), wrong, strict=True):
        assert refused.returncode == 3
        assert re.search(message, refused.stderr), refused.stderr


@pytest.mark.parametrize("name", METHODS)
def test_each_method_has_its_module_and_its_row(name: str) -> None:
    assert solver(name).__module__ == f"frictool.synth.{name}"
    method = METHODS[name]
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in text_of(ROOT / "docs/theory/synth.md").splitlines()
        if line.startswith(f"| `{name}` |")
    ]
    assert [(row[1], row[3]) for row in rows] == [(method.problem, method.use)]
