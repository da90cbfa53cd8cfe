"""The recipe "A synthesis method" of CONTRIBUTING.md, followed with a dummy."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from frictool.documents.synthesis_methods import METHODS
from frictool.synth.methods import solver
from tests.docs.recipe import CopiedPackage
from tests.support.documentation_pages import ROOT, text_of

RIG = ROOT / "configs/mass"
SOLVER = '''"""Method `dummy`: proportional and derivative controller of fixed gains."""

from frictool.documents.pid_gains import Pid
from frictool.documents.quantity import Quantity
from frictool.synth.pid import sampled_pid
from frictool.synth.synthesis_problem import ControllerCandidate, SynthesisProblem


def dummy(problem: SynthesisProblem) -> ControllerCandidate:
    """Return the controller."""
    gains = Pid(gain=Quantity(value=2.0, unit="N/m"), derivative_time_s=1.0, filter_ratio=10.0)
    k = sampled_pid(gains, 2.0, problem.period)
    return ControllerCandidate(k, k, notes=(f"dummy of order {problem.design.order}",))
'''
RECORD = """    "dummy": SynthesisMethod(
        "the problem of the dummy",
        "the use of the dummy",
        ("order",),
        structures=("position",),
        provided_gains=True,
    ),
"""
DESIGN = """format: design/1
name: tried
axis: linear
structure: position
method: dummy
weights: {}
order: 2
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> CopiedPackage:
    copy = CopiedPackage.into(tmp_path_factory.mktemp("method"))
    (copy.folder / "frictool/synth/dummy.py").write_text(SOLVER)
    copy.insert("frictool/documents/synthesis_methods.py", '    "pid": SynthesisMethod(', RECORD)
    return copy


def test_help_schema_and_messages_know_the_method(package: CopiedPackage, tmp_path: Path) -> None:
    help_text = package.run("synth", "--help").stdout
    assert re.search(r"  dummy +the problem of the dummy\n +the use of the dummy\n", help_text)
    schema = json.loads(package.run("schema", "design").stdout)["$defs"]["Design"]
    assert "dummy" in schema["properties"]["method"]["enum"]
    assert re.search(r"`order`[^;]* \([^;]*\bdummy\b[^;]*\)", schema["description"])
    stored = json.loads(package.run("schema", "controller").stdout)["$defs"]["Controller"]
    assert {"dummy", "own"} <= set(stored["properties"]["method"]["enum"])
    for change, message in (
        ("poles: {decay_rad_s: 3}", "poles is for methods .*, and method is dummy; leave it out"),
        ("method: other", r"found 'other'; allowed: lpv \|.*\| dummy \| pid"),
    ):
        design = tmp_path / "design.yaml"
        key = change.partition(":")[0]
        kept = [line for line in DESIGN.splitlines() if not line.startswith(f"{key}:")]
        design.write_text("\n".join([*kept, change, ""]))
        wrong = package.run(
            "synth", RIG / "model.yaml", "--spec", RIG / "spec.yaml", "--design", design, code=3
        )
        assert re.search(message, wrong.stderr), wrong.stderr


def test_a_design_with_the_method_is_synthesised_and_verified(
    package: CopiedPackage, tmp_path: Path
) -> None:
    design, controller = tmp_path / "design.yaml", tmp_path / "controller.yaml"
    design.write_text(DESIGN)
    documents = [RIG / "model.yaml", "--spec", RIG / "spec.yaml", "--design", design]
    result = package.run("synth", *documents, "-o", controller, "--json")
    view = json.loads(result.stdout)
    assert view["method"] == "dummy"
    assert "dummy of order 2" in view["notes"]
    assert package.run("verify", controller).returncode == 0


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
