"""`frictool doctor`: what is in order, what is not, and what is left over."""

from __future__ import annotations

import importlib
import inspect
import json
import os
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from frictool.doctor import compiled_kernels, examination, library_versions, precompilation, solver
from frictool.doctor.c_compiler import NAMES, check_c_compiler
from frictool.doctor.installation_finding import InstallationFinding
from frictool.runtime import kernels
from frictool.runtime.kernel_sources import PACKAGE, Sources
from frictool.simulate.compiled_target import COMPILERS
from studies.command_line import run


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where kernels are kept, with two former versions' of which one was used just now."""
    monkeypatch.setattr(kernels, "cache_places", lambda: [tmp_path])
    monkeypatch.setattr(
        kernels, "FOLDER", tmp_path / "kernels-now"
    )  # the real one may hold former states
    (tmp_path / "kernels-now").mkdir()
    for name, age in (("kernels-old", 7200.0), ("kernels-young", 60.0)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "in_use").write_bytes(b"")
        (tmp_path / name / "kernel.nbc").write_bytes(b"x" * 1_500_000)
        os.utime(tmp_path / name / "in_use", (time.time() - age,) * 2)
    return tmp_path


def test_this_installation_is_in_order(place: Path) -> None:
    result = run("doctor", "--json")
    assert result.code == 0, result.stdout
    view = json.loads(result.stdout)
    checks = {one["check"]: one for one in view["checks"]}
    assert view["is_in_order"]
    assert checks["libraries"]["numpy"] == metadata.version("numpy")
    assert checks["compiling"]["state"] == checks["solver"]["state"] == "ok"
    assert checks["kernels"]["folder"] == str(kernels.FOLDER)
    assert checks["left over"]["bytes"] >= 3_000_000
    assert [one["kept_by"] for one in checks["left over"]["folders"]] == [
        "used within the last hour",
        None,
    ]
    assert checks["left over"]["try"] == "frictool doctor --clean"


def test_clean_removes_what_nobody_uses(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(examination, "examine", lambda: [InstallationFinding("python", "ok", "3")])
    result = run("doctor", "--clean", "-o", place / "told.txt")
    assert result.code == 0
    assert "removed: the kernels of 1 former version" in result.stdout
    assert f"not removed: {place / 'kernels-young'} (used within the last hour)" in result.stdout
    assert not (place / "kernels-old").exists()
    assert (place / "told.txt").read_text() == result.stdout


def test_what_is_wrong_is_exit_1_with_what_to_try(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        examination,
        "examine",
        lambda: [InstallationFinding("solver", "wrong", "gave up", "pip install clarabel")],
    )
    result = run("doctor")
    assert result.code == 1
    assert result.stdout.splitlines()[1:] == [
        f"wrong {'solver':<16}gave up",
        f"{'':<22}try: pip install clarabel",
        "wrong: solver",
    ]


def test_a_library_that_is_missing_or_too_old_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    here = {"numpy": "1.26.4", "scipy": "1.17.1rc1"}
    monkeypatch.setattr(library_versions, "_installed", here.get)
    asked = list(
        library_versions._requirements(
            [
                "numpy>=2.0",
                "scipy>=1.13",
                "numba>=0.60",
                'h5py>=3.11; extra == "mat73"',
                "types-PyYAML",
            ]
        )
    )
    found = library_versions.check_libraries(asked)
    assert found.state == "wrong"
    assert found.finding == "numpy 1.26.4, needed: >=2.0; numba is missing, needed: >=0.60"
    (extra,) = library_versions.check_extras(asked)
    assert (extra.name, extra.state, extra.remedy) == (
        "extra mat73",
        "note",
        "pip install 'frictool[mat73]'",
    )


def test_versions_are_compared_as_numbers() -> None:
    assert library_versions.RequiredLibrary("a", "1.9", None, "1.10").is_met
    assert library_versions.RequiredLibrary("a", "2.0", None, "2.0.0").is_met
    assert not library_versions.RequiredLibrary("a", "1.10", None, "1.9.9").is_met


def test_what_cannot_be_imported_is_wrong_and_no_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken() -> InstallationFinding:
        raise ImportError("libLLVM.so: cannot open shared object file")

    found = examination._tried("compiling", broken)
    assert (found.state, found.finding) == (
        "wrong",
        "ImportError: libLLVM.so: cannot open shared object file",
    )


def test_a_kernel_with_a_wrong_value_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        kernels, "compiler", lambda function: lambda *given: function(*given) + 1e-12
    )
    assert compiled_kernels.check_compiling().state == "wrong"


def test_a_solution_that_does_not_hold_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    p = solver.solve_lyapunov()
    assert np.abs(solver.A.T @ p + p @ solver.A + np.eye(2)).max() < 1e-14
    solved = solver.solve
    monkeypatch.setattr(
        solver,
        "solve",
        lambda *given: type(solved(*given))(1.001 * solved(*given).x, "Solved", True),
    )
    assert solver.check_solver().state == "wrong"
    monkeypatch.setattr(
        solver, "solve", lambda *given: type(solved(*given))(np.full(3, np.nan), "Panicked", False)
    )
    assert solver.check_solver().state == "wrong"


def test_kernels_that_are_kept_nowhere_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "FOLDER", None)
    found = compiled_kernels.check_kernel_folder()
    assert (found.state, found.remedy) == ("note", "set NUMBA_CACHE_DIR")


def test_what_is_looked_for_is_what_is_used() -> None:
    assert NAMES == COMPILERS


BROKEN = """
import sys
for name in ("msgspec", "numpy", "numba"):
    sys.modules[name] = None
sys.argv = ["frictool", "doctor", *sys.argv[1:]]
from frictool.cli.main import main
main()
"""


def test_where_libraries_are_broken_it_still_tells() -> None:
    done = subprocess.run(
        [sys.executable, "-c", BROKEN, "--clean"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr == ""
    assert "removed: no kernels (" in done.stdout
    assert done.stdout.splitlines()[-1] == "wrong: compiling, kernels, left over, solver"


def test_a_c_compiler_is_tried(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert check_c_compiler(("cc",)).finding == "none of cc is on the PATH"
    for body, told in (("echo 'no stdio.h' >&2; exit 1", "no stdio.h"), ("exit 0", "No such file")):
        (tmp_path / "cc").write_text(f"#!/bin/sh\n{body}\n")
        (tmp_path / "cc").chmod(0o755)
        found = check_c_compiler(("cc",))
        assert found.state == "note"
        assert told in found.finding


def test_clean_removes_former_states_of_a_module_and_leaves_the_present_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(examination, "examine", lambda: [InstallationFinding("python", "ok", "3")])
    monkeypatch.setattr(kernels, "cache_places", list)
    monkeypatch.setattr(kernels, "FOLDER", tmp_path)
    present = (
        tmp_path
        / f"friction.lugre-{Sources(PACKAGE.parent).state(['frictool.friction.lugre']).digest}"
    )
    former, young, removed_module = (
        tmp_path / name for name in ("friction.lugre-0a", "friction.lugre-0b", "friction.gone-0a")
    )
    for folder, age in (
        (present, 7200.0),
        (former, 7200.0),
        (young, 60.0),
        (removed_module, 7200.0),
    ):
        folder.mkdir()
        os.utime(folder, (time.time() - age,) * 2)
    result = run("doctor", "--clean", "--json")
    assert result.code == 0
    facts = json.loads(result.stdout)["clean"]
    assert sorted(path for path in facts["removed"] if str(tmp_path) in path) == sorted(
        map(str, (former, removed_module))
    )
    assert facts["left"] == [str(young)]
    assert present.exists()


def test_the_list_of_kernels_is_that_of_the_package() -> None:
    """Each listed kernel is there, takes as many arguments, and its types are those that its numba
    classes have now."""
    rows = json.loads(precompilation.LIST.read_bytes())
    assert len(rows) > 200
    for module, name, kind, encoded in rows:
        kernel = getattr(importlib.import_module(module), name, None)
        assert kernel is not None, f"{module}.{name} is gone: make kernels"
        arguments = encoded[1] if kind == "pointer" else encoded
        optional = [one for one in arguments if one[0] == "omitted"]
        count = len(inspect.signature(kernel.py_func).parameters)
        assert len(arguments) - len(optional) <= count == len(arguments), (
            f"{module}.{name}: make kernels"
        )
        for one in arguments:
            assert precompilation.encode(precompilation.decode(one)) == one, (
                f"{module}.{name}: make kernels"
            )
            _has_its_fields(one)


def _has_its_fields(encoded: Any) -> None:
    if encoded[0] == "tuple" and encoded[1] != "builtins:tuple":
        module, _, name = encoded[1].partition(":")
        assert len(getattr(importlib.import_module(module), name)._fields) == len(encoded[2]), (
            f"{encoded[1]}: make kernels"
        )
        for part in encoded[2]:
            _has_its_fields(part)


def test_the_kernels_of_a_law_need_no_rows_in_the_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rows that the list has of a law's kernel follow from the kind of the law."""
    listed = json.loads(precompilation.LIST.read_bytes())
    own = [row for row in listed if row[:2] == ["frictool.friction.stribeck", "slip_force"]]
    assert len(own) == 2
    monkeypatch.setattr(precompilation, "LIST", tmp_path / "rows.json")
    precompilation.LIST.write_text(json.dumps([row for row in listed if row not in own]))
    found = precompilation.all_rows()
    assert sorted(map(str, found)) == sorted(map(str, listed))
    assert sorted(map(str, found[:2])) == sorted(map(str, own))
    assert not precompilation.compile_all(lambda done: None, found[:2]).failures


COMPILE = """
import json, sys
from frictool.doctor import precompilation
rows = json.loads(precompilation.LIST.read_bytes())
laws = [f"frictool.friction.{name}" for name in ("coulomb_viscous",)]
short = [row for row in rows if row[0] in laws]
precompilation.LIST = __import__("pathlib").Path(sys.argv[1])
gone = [[laws[0], "gone", "kernel", []]] * (len(sys.argv) > 2)
precompilation.LIST.write_text(json.dumps(short + gone))
precompilation.ROWS = ()  # of the laws
sys.argv = ["frictool", "doctor", "--compile", "--json"]
from frictool.cli.main import main
main()
"""


def test_compile_keeps_the_kernels_of_the_list(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kept")}

    def facts(*words: str, code: int = 0) -> dict[str, Any]:
        command = [sys.executable, "-c", COMPILE, str(tmp_path / "rows.json"), *words]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == code, done.stderr
        return dict(json.loads(done.stdout)["compile"])

    first = facts()
    assert first["kernels"] >= 2
    assert first["compiled"] > 0
    assert first["failures"] == []
    again = facts("gone", code=1)
    (failure,) = again.pop("failures")
    assert again == {"kernels": first["kernels"], "compiled": 0}
    assert "frictool.friction.coulomb_viscous.gone" in failure
    (folder,) = (tmp_path / "kept").iterdir()
    rows = [row for row in json.loads((tmp_path / "rows.json").read_bytes()) if row[1] != "gone"]
    listed = list(precompilation.kept(folder))
    assert [row for row in rows if row not in listed] == []
