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
from tests.support.recipes import COMMAND, follow, frictool, frictool_each, recipes


@pytest.fixture(scope="module")
def overlay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("law")
    follow("A friction law", folder)
    return folder


@pytest.mark.accept
def test_the_commands_show_the_law_and_move_as_its_equation_says(overlay: Path) -> None:
    """v' = 3 - 1 - 2 v^2 from rest has the solution v = tanh(2 t)."""
    equations, simulate, compare = COMMAND.findall(recipes()["A friction law"])
    shown = frictool(overlay, *equations.split(), "--explain")
    assert "F_fluid = coulomb_drag(v_cart; Fc_fluid, Fs_fluid, drag_fluid)" in shown.stdout
    assert "none" not in shown.stdout
    done = frictool(overlay, *simulate.split())
    assert done.returncode == 0, done.stderr
    (stream,) = read_log(overlay / "pull.mcap").streams
    np.testing.assert_allclose(
        stream.signals["cart_velocity"], np.tanh(2.0 * stream.time), atol=1e-6
    )
    done = frictool(overlay, *compare.split(), "--json")
    assert done.returncode == 0, done.stderr
    assert "default" not in done.stderr
    svc, drag = json.loads(done.stdout)["laws"].values()
    assert drag["drift"] == pytest.approx(svc["drift"], abs=1e-9)
    assert drag["properties"]["viscous"] == "+"


def test_a_body_under_the_law_alone_moves_alike(overlay: Path) -> None:
    """In the engine of one body, which is exact where it knows the slip force as a line."""
    file = overlay / "frictool/friction/coulomb_drag.py"
    spec = spec_from_file_location("coulomb_drag", file)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    law, times = module.LAW, np.linspace(0.0, 1.0, 21)
    p = law.pack({"coulomb": 1.0, "breakaway": 1.5, "drag": 2.0})
    run = run_law(law, p, 1.0, [(1.0, held(3.0))], times)
    np.testing.assert_allclose(run.samples[:, 1], np.tanh(2.0 * times), atol=1e-6)


def test_schema_help_messages_and_equations_know_the_law(overlay: Path) -> None:
    wrong = overlay / "wrong.yaml"
    wrong.write_text(
        (overlay / "drag.yaml").read_text().replace("drag: {value: 2", "drag: {value: -2")
    )
    schema, shown, unknown, equations, refused = frictool_each(
        overlay,
        ["schema", "mechanism"],
        ["compare", "--help"],
        ["compare", "--law", "drag"],
        ["equations", overlay / "drag.yaml"],
        ["equations", wrong],
    )
    described = json.loads(schema.stdout)["$defs"]
    assert "coulomb_drag" in described["FrictionOf"]["properties"]["law"]["enum"]
    assert "coulomb_drag" in shown.stdout
    assert "coulomb_drag" in unknown.stderr
    assert "coulomb_drag(" in equations.stdout
    assert refused.returncode == 3
    assert "drag is -2 N s^2/m^2; allowed: a finite number >= 0" in refused.stderr


def test_compare_names_a_parameter_that_takes_its_default(overlay: Path) -> None:
    file = overlay / "frictool/friction/coulomb_drag.py"
    text = file.read_text()
    value = 'comparison_value=lambda values: values["viscous"]'
    assert value in text
    file.write_text(text.replace(value, "default=0.0"))
    done = frictool(overlay, "compare", "--law", "coulomb_drag", "--json")
    file.write_text(text)
    assert done.returncode == 0, done.stderr
    assert "comparison of coulomb_drag uses drag = 0 N s^2/m^2, its default" in done.stderr
    assert json.loads(done.stdout)["laws"]["coulomb_drag"]["properties"]["viscous"] == "-"


def test_latex_has_braces_around_exponents_and_spaces_in_names(overlay: Path) -> None:
    rooted = overlay / "frictool/friction/coulomb_drag.py"
    text = rooted.read_text()
    rooted.write_text(text.replace("s^2/m^2", "s^0.5/m^0.5"))
    (overlay / "root.yaml").write_text(
        (overlay / "drag.yaml").read_text().replace("s^2/m^2", "s^0.5/m^0.5")
    )
    latex = frictool(overlay, "equations", "root.yaml", "--latex").stdout
    rooted.write_text(text)
    assert r"\mathrm{N\,s^{0.5}/m^{0.5}}" in latex
    assert r"\mathrm{coulomb~drag}\left(v_{\mathrm{cart}}; F_{c,\mathrm{fluid}}, " in latex
