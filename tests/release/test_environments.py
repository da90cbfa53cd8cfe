"""`make test-envs`: which versions and which processors it takes, and that a failure is told."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from tests.envs import __main__ as envs
from tests.envs import dependencies, processors
from tests.support.documentation_pages import ROOT


def test_every_requirement_of_users_has_a_lower_bound_that_is_tested() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found = dict(line.split("==") for line in dependencies.lowest())
    assert found["click"] == "8.5.0"
    assert found["numpy"] == "2.0"
    assert {"nptdms", "python-can", "cantools", "pyulog"} <= set(found)
    assert {"asammdf", "pyarrow", "h5py", "control", "dask", "mujoco"} <= set(found)
    assert len(found) == len(project["dependencies"]) + 12
    assert not {"pytest", "fmpy", "ruff"} & set(found)


def test_the_chain_uses_every_command() -> None:
    from frictool.cli.main import COMMANDS

    lines = dependencies.chain()
    assert {line.split()[1] for line in lines if line.startswith("frictool")} == set(COMMANDS)


def test_a_processor_s_kernels_are_skipped_where_it_lacks_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cpuinfo = tmp_path / "cpuinfo"
    cpuinfo.write_text("processor : 0\nflags\t\t: fpu pni avx2\n")
    assert processors.flags(cpuinfo) == {"fpu", "pni", "avx2"}
    assert processors.flags(tmp_path / "none") == set()
    monkeypatch.setattr(processors, "flags", lambda: {"fpu"})
    assert processors.suite("SkylakeX", 1)["skipped"] == "this processor has no avx512f"
    assert set(processors.THREADS.values()) == {1, 2}
    assert set(processors.NEEDS) == set(processors.THREADS)


def test_an_environment_that_fails_is_exit_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(
        dependencies.ENVIRONMENTS,
        "lowest",
        lambda: {"passed": False, "failed": ["frictool assess ended with 1, not 0"]},
    )
    monkeypatch.setitem(dependencies.ENVIRONMENTS, "newest", lambda: {"passed": True})
    target = tmp_path / "envs.json"
    assert envs.main([str(target), "newest"]) == 0
    assert envs.main([str(target), "newest", "lowest"]) == 1
    assert (
        "FAILED  lowest     failed ['frictool assess ended with 1, not 0']"
        in capsys.readouterr().out
    )
    assert json.loads(target.read_text())["newest"]["passed"]
    with pytest.raises(SystemExit):
        envs.main([str(target), "pentium"])
