"""A command that is terminated leaves nothing; what a killed one leaves is removed by the next, and
never what a process is writing."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from frictool.doctor import examination
from frictool.errors import LogError
from frictool.runtime import part_files
from frictool.runtime.part_files import PART, part_file, part_folder, remove_stale_parts
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH, ROOT

SINES = ROOT / "sample_logs/sines.csv"
ENDLESS_WRITER = """
import signal, sys, time
import frictool.logs.log_assembly as assembly
from frictool.cli.main import main

def write(made, stream, *rest):
    stream.write(b"begun")
    stream.flush()
    print("writing", flush=True)
    time.sleep(600.0)

# a shell's background jobs inherit it ignored
signal.signal(signal.SIGINT, signal.default_int_handler)
assembly.write = write
sys.argv = ["frictool", *sys.argv[1:]]
main()
"""
Writer = Callable[[Path], subprocess.Popen[str]]
pytestmark = pytest.mark.skipif(part_files.fcntl is None, reason="needs signals and locks of POSIX")


@pytest.fixture
def writer() -> Iterator[Writer]:
    """Start an `ingest` that has begun to write its output and does not end."""
    started: list[subprocess.Popen[str]] = []

    def start(target: Path) -> subprocess.Popen[str]:
        words = [
            sys.executable,
            "-c",
            ENDLESS_WRITER,
            "ingest",
            str(SINES),
            "--bench",
            str(CLUTCH),
            "-o",
            str(target),
        ]
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        process = subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
        )
        started.append(process)
        assert process.stdout is not None
        assert process.stdout.readline() == "writing\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT])
def test_a_terminated_command_ends_as_interrupted_and_leaves_nothing(
    sent: signal.Signals, writer: Writer, tmp_path: Path
) -> None:
    process = writer(tmp_path / "run.mcap")
    assert len(names(tmp_path)) == 1
    process.send_signal(sent)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 130
    assert told.strip() == "interrupted"
    assert names(tmp_path) == []


def test_the_next_writer_removes_what_a_killed_one_left_and_nothing_else(
    writer: Writer, tmp_path: Path
) -> None:
    killed, alive = writer(tmp_path / "killed.mcap"), writer(tmp_path / "alive.mcap")
    for name in (".notes.part", "run.abcdefgh.part", ".own.ABCDEFGH.part"):
        (tmp_path / name).write_text("not of frictool")
    kept = [name for name in names(tmp_path) if "killed" not in name]
    killed.kill()
    killed.wait()
    assert len(names(tmp_path)) == len(kept) + 1
    result = run("ingest", SINES, "--bench", CLUTCH, "-o", tmp_path / "run.mcap")
    assert result.code == 0, result.stderr
    assert names(tmp_path) == sorted([*kept, "run.mcap"])
    alive.terminate()
    alive.communicate(timeout=60)
    assert alive.returncode == 130


def test_doctor_removes_what_killed_processes_left_here(
    writer: Writer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(examination, "examine", list)
    process = writer(tmp_path / "run.mcap")
    assert "removed: 0 unfinished outputs" in run("doctor", "--clean").stdout
    assert len(names(tmp_path)) == 1
    process.kill()
    process.wait()
    assert "removed: 1 unfinished output in this folder" in run("doctor", "--clean").stdout
    assert names(tmp_path) == []


def test_folders_are_removed_too_but_not_while_they_are_written(tmp_path: Path) -> None:
    left = tmp_path / ".c.a1b2c3d4.part"
    left.mkdir()
    (left / "controller.c").write_text("int x;")
    with part_folder(tmp_path / "c") as staged:
        (staged / "controller.c").write_text("int x;")
        assert PART.fullmatch(staged.name)
        assert not left.exists()
        assert remove_stale_parts(tmp_path) == []
    assert names(tmp_path) == []


def test_a_part_is_never_taken_from_its_writer(tmp_path: Path) -> None:
    with part_file(tmp_path / "a.yaml") as stream:
        stream.write(b"a: 1\n")
        assert remove_stale_parts(tmp_path) == []
    assert names(tmp_path) == ["a.yaml"]
    with pytest.raises(LogError), part_file(tmp_path / "b.yaml"):
        raise LogError("b", "is damaged")
    assert names(tmp_path) == ["a.yaml"]
