"""The runners behind `make accept`, `make bench`, `make test` and `make clean`."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from benchmarks import __main__ as bench
from tests.accept import __main__ as accept


def test_a_check_that_fails_or_raises_is_exit_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def broken() -> dict[str, Any]:
        raise RuntimeError("no data")

    checks = {
        "good": lambda: {"passed": True, "cover": 0.95},
        "bad": lambda: {"passed": False},
        "broken": broken,
    }
    monkeypatch.setattr(accept, "collect", lambda folder: checks)
    target = tmp_path / "build" / "accept.json"
    assert accept.main([str(target)]) == 1
    found = json.loads(target.read_text())
    assert {name: result["passed"] for name, result in found.items()} == {
        "good": True,
        "bad": False,
        "broken": False,
    }
    assert found["good"]["cover"] == 0.95
    assert found["broken"]["error"] == "RuntimeError: no data"
    assert "1 of 3 checks passed" in capsys.readouterr().out
    assert accept.main([str(target), "good"]) == 0
    for wrong in ([str(target), "goood"], []):
        with pytest.raises(SystemExit, match="2"):
            accept.main(wrong)
    assert "there is no check 'goood'; did you mean 'good'?" in capsys.readouterr().err


def test_every_check_file_is_collected():
    folder = Path(accept.__file__).parent
    assert len(accept.collect(folder)) >= len(list(folder.glob("check_*.py"))) > 0


def test_a_row_without_its_peer_is_skipped_and_one_that_fails_is_exit_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def good() -> dict[str, Any]:
        return {
            "id": "good",
            "peer": "p",
            "ours": 1.0,
            "theirs": 2.0,
            "unit": "s",
            "ratio": 2.0,
            "accuracy": "same",
        }

    def without_peer() -> dict[str, Any]:
        import no_such_peer  # noqa: F401  # that it is missing is what is tried

        return good()

    def broken() -> dict[str, Any]:
        raise RuntimeError("no data")

    target = tmp_path / "build" / "bench.json"
    monkeypatch.setattr(bench, "collect", lambda folder: [good, without_peer])
    assert bench.main([str(target)]) == 0
    assert "without.peer" in (printed := capsys.readouterr().out)
    assert "skipped: no_such_peer is not installed" in printed
    assert json.loads(target.read_text()) == [good()]
    monkeypatch.setattr(bench, "collect", lambda folder: [good, broken])
    assert bench.main([str(target)]) == 1
    assert bench.main([str(target), "good"]) == 0


def test_a_row_without_an_id_has_that_of_its_function(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def log_read() -> dict[str, Any]:
        return {
            "peer": "p",
            "ours": 1.0,
            "theirs": 2.0,
            "unit": "s",
            "ratio": 2.0,
            "accuracy": "same",
        }

    monkeypatch.setattr(bench, "collect", lambda folder: [log_read])
    assert bench.main([str(tmp_path / "bench.json"), "log.read"]) == 0
    assert json.loads((tmp_path / "bench.json").read_text())[0]["id"] == "log.read"


def test_a_row_that_is_not_there_and_a_missing_target_are_refused_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    def log_read() -> dict[str, Any]:
        raise AssertionError("it runs")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(bench, "collect", lambda folder: [log_read])
    for arguments, code, told in (
        (["bench.json", "log.raed"], 2, "there is no row 'log.raed'; did you mean log.read?"),
        ([], 2, "usage: python -m benchmarks"),
        (["--help"], 0, "usage: python -m benchmarks"),
    ):
        with pytest.raises(SystemExit) as ended:
            bench.main(arguments)
        assert ended.value.code == code
        printed = capsys.readouterr()
        assert told in printed.out + printed.err
    assert not list(tmp_path.iterdir())


def test_every_bench_file_is_collected():
    names = [bench.name_of(row) for row in bench.collect(Path(bench.__file__).parent)]
    assert {"startup.help", "ingest.csv", "log.read", "log.write"} <= set(names)
    assert len(names) == len(set(names))


def test_the_reason_of_a_skipped_test_is_shown(pytestconfig: pytest.Config):
    assert "-rs" in pytestconfig.getini("addopts")


@pytest.mark.skipif(shutil.which("make") is None, reason="there is no make on the PATH")
def test_clean_takes_what_was_built_and_the_compiled_kernels(tmp_path: Path):
    gone = (
        "build/bench.json",
        "configs/rig/build/model.yaml",
        "frictool/__pycache__/kernels-0a/engine/slip.nbi",
    )
    kept = ("configs/rig/bench.yaml", "frictool/__pycache__/kernels.pyc", "sample_logs/sines.csv")
    for name in (*gone, *kept):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    makefile = Path(__file__).parents[1] / "Makefile"
    subprocess.run(["make", "-f", makefile, "clean"], cwd=tmp_path, check=True, capture_output=True)
    assert sorted(
        str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()
    ) == sorted(kept)
