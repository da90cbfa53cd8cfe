"""`frictool verify`: the clutch's speed loop is proved from its file; a changed file is not."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from frictool.documents.controller import Controller, StateSpace
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from studies.command_line import run
from studies.rigs.verified_controller import truthful
from tests.support.certified_controllers import INTERIOR, certified, few_interior_points
from tests.support.clutch_speed_controller import clutch_speed_controller
from tests.support.command_line import refused


@pytest.fixture(autouse=True, scope="module")
def _few_points() -> Iterator[None]:
    with few_interior_points():
        yield


def _written(folder: Path, controller: Controller) -> Path:
    path = folder / "controller.yaml"
    path.write_text(to_yaml(controller))
    return path


def _with_gain(controller: Controller, factor: float, *, forms: bool = False) -> Controller:
    """forms: in the sections and the continuous form too."""
    linear = controller.linear
    changed = {"discrete": _louder(linear.discrete, factor)}
    if forms:
        first, *others = linear.sos
        changed["continuous"] = _louder(linear.continuous, factor)
        changed["sos"] = (tuple(factor * value for value in first[:3]) + first[3:], *others)
    return msgspec.structs.replace(controller, linear=msgspec.structs.replace(linear, **changed))


def _louder(k: StateSpace, factor: float) -> StateSpace:
    rows = {
        name: tuple(tuple(factor * value for value in row) for row in getattr(k, name))
        for name in ("c", "d")
    }
    return msgspec.structs.replace(k, **rows)


def test_what_was_written_is_read_and_proved(tmp_path: Path) -> None:
    path = _written(tmp_path, certified("speed"))
    assert path.stat().st_size < 200_000
    assert load(path, Controller).certificate == certified("speed").certificate
    text = run("verify", path)
    assert text.code == 0, text.stderr
    for words in (
        "proved for every constant",
        "0.0128 to 0.014 N m/A",
        "norm from the weighted",
        "modulus margin > 0.6",
    ):
        assert words in text.stdout
    found = json.loads(run("verify", path, "--json").stdout)
    assert [one["of"] for one in found["certificate"]] == ["norm", "sensitivity"]
    assert found["not_proved"] == {}
    assert found["box"]["viscous"] == [0.0, 7.62e-4]
    assert found["differences"] == found["changed"] == []
    controller = certified("speed")
    worst = min(vertex.modulus_margin for vertex in controller.verified.vertices)
    assert 0.95 * worst < found["certificate"][1]["modulus_margin_above"] < worst


def test_an_edit_within_what_is_proved_is_exit_1_and_the_bounds_hold(tmp_path: Path) -> None:
    """In the twelfth digit no figure changes; by one in ten thousand figures do. The bounds are
    proved of both."""
    path = _written(tmp_path, _with_gain(certified("speed"), 1.0 + 1e-12, forms=True))
    result = run("verify", path)
    assert (result.code, result.stderr) == (1, "")
    for words in (
        "proved for every",
        "all equal the stored figures",
        "changed after verification: linear;",
    ):
        assert words in result.stdout
    path = _written(tmp_path, _with_gain(certified("speed"), 1.0001, forms=True))
    result = run("verify", path, "--json")
    assert (result.code, result.stderr) == (1, "")
    found = json.loads(result.stdout)
    assert [one["of"] for one in found["certificate"]] == ["norm", "sensitivity"]
    assert found["changed"] == ["linear"]
    assert found["differences"]


def test_a_gain_changed_by_a_fifth_is_exit_4(tmp_path: Path) -> None:
    changed = _with_gain(certified("speed"), 1.2)
    for told in (changed, truthful(changed)):  # whatever it says of its margins
        refused(
            run("verify", _written(tmp_path, told)),
            4,
            "speed: not proved: norm <",
            "inertia",
            "rad/s",
        )


def test_a_margin_that_is_not_what_the_document_says_is_exit_1(tmp_path: Path) -> None:
    controller = certified("speed")
    first, *others = controller.verified.vertices
    vertices = (msgspec.structs.replace(first, modulus_margin=first.modulus_margin * 1.01), *others)
    told = msgspec.structs.replace(
        controller, verified=msgspec.structs.replace(controller.verified, vertices=vertices)
    )
    result = run("verify", _written(tmp_path, told))
    assert (result.code, result.stderr) == (1, "")
    shown = (
        f"found {vertices[0].modulus_margin:.6g}, the coefficients give {first.modulus_margin:.6g}"
    )
    assert f"verified.vertices[0].modulus_margin: {shown}" in result.stdout
    assert "changed after" not in result.stdout


def test_a_vertex_outside_of_the_box_is_exit_4(tmp_path: Path) -> None:
    certificate = certified("speed").certificate
    assert certificate is not None
    box = msgspec.structs.replace(certificate.box, coulomb=(0.018, 0.17))
    smaller = msgspec.structs.replace(
        certified("speed"), certificate=msgspec.structs.replace(certificate, box=box)
    )
    refused(
        run("verify", _written(tmp_path, smaller)),
        4,
        "coulomb is 0.18 in vertex v0",
        "but 0.018 to 0.17 in the certificate",
    )


def test_without_a_certificate_the_answer_is_no(tmp_path: Path) -> None:
    path = _written(tmp_path, clutch_speed_controller())
    assert clutch_speed_controller().certificate is None
    result = run("verify", path, "--json")
    assert (result.code, result.stderr) == (1, "")
    assert json.loads(result.stdout)["certificate"] is None


@pytest.mark.parametrize(
    ("found", "told"),
    [
        ("version: 2", "version: 3"),
        ("of: norm", "of: norms"),
        ("below: ", "below: -"),
        ("below: ", "beneath: "),
    ],
)
def test_a_bad_document_is_exit_3(tmp_path: Path, found: str, told: str) -> None:
    path = _written(tmp_path, certified("speed"))
    path.write_text(path.read_text().replace(found, told, 1))
    refused(run("verify", path), 3, "controller.yaml:", "certificate")


def test_no_solver_is_loaded(tmp_path: Path) -> None:
    path = _written(tmp_path, certified("speed"))
    script = (
        "import sys; from frictool.cli.main import main; from frictool.verify import "
        f"interior_search; interior_search.POINTS = {INTERIOR}\n"
        "sys.argv = ['frictool', 'verify', sys.argv[1]]\n"
        "try: main()\nexcept SystemExit as stop: assert not stop.code, stop.code\n"
        "assert not {'clarabel', 'cvxpy', 'scs'} & set(sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
