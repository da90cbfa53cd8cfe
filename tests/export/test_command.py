"""`frictool export`: the folder it writes, what it leaves alone, what it refuses."""

from __future__ import annotations

import io
import json
import re
import tarfile
from pathlib import Path

import msgspec
import pytest

from frictool.documents.controller import LinearController
from frictool.documents.provenance import digest
from frictool.documents.writing import to_yaml
from tests.cli.run import refused, run
from tests.control.example import CUT_LAW, clutch_controller
from tests.verify.truthful import truthful

NAMES = ["speed.c", "speed.h", "speed_selftest.c", "speed_vectors.h"]


@pytest.fixture
def controller(tmp_path: Path) -> Path:
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(truthful(clutch_controller(CUT_LAW))))
    return path


def test_writes_four_files_and_says_what_they_cover(controller: Path, tmp_path: Path) -> None:
    result = run("export", controller, "--lang", "c", "-o", tmp_path / "deep/c", "--json")
    assert result.code == 0
    assert sorted(path.name for path in (tmp_path / "deep/c").iterdir()) == NAMES
    assert sorted(path.name for path in (tmp_path / "deep").iterdir()) == ["c"]
    said = json.loads(result.stdout)
    assert sorted(said["files"]) == NAMES
    assert (said["order"], said["sample_period_s"], said["number"], said["sha256"]) == (2, 0.001, "double", digest(controller))
    vectors = said["vectors"]
    assert vectors["run"] + vectors["brake"] + vectors["rest"] == vectors["samples"]
    header = (tmp_path / "deep/c/speed.h").read_text()
    assert digest(controller) in header
    assert "frictool export controller.yaml --lang c" in header
    assert str(tmp_path) not in header


def test_replaces_its_own_files_and_leaves_others_alone(controller: Path, tmp_path: Path) -> None:
    folder = tmp_path / "c"
    folder.mkdir()
    (folder / "main.c").write_text("mine")
    (folder / "speed.c").write_text("old")
    assert run("export", controller, "-o", folder).code == 0
    assert (folder / "main.c").read_text() == "mine"
    assert "speed_step" in (folder / "speed.c").read_text()
    first = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert run("export", controller, "-o", folder).code == 0
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == first


def test_stdout_is_a_tar_archive_of_the_same_files(controller: Path, tmp_path: Path) -> None:
    assert run("export", controller, "-o", tmp_path / "c").code == 0
    result = run("export", controller, "-o", "-")
    assert result.code == 0
    with tarfile.open(fileobj=io.BytesIO(result.out)) as tar:
        for name in NAMES:
            member = tar.extractfile(name)
            assert member is not None
            assert member.read() == (tmp_path / "c" / name).read_bytes()
    assert run("export", controller, "-o", "-").out == result.out
    assert "golden vectors" in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (r"d:\n    - \[.*?\]", "d:\n    - [.nan]", "finite"),
        (r"b:\n    - \[.*?\]\n", "b:\n", "matrices"),
        ("drive_limit: 50.0", "drive_limit: -50.0", "drive_limit"),
        ("position_law:", "position_lav:", "position_law"),
        (r"anti_windup: \[.*?, ", "anti_windup: [", "anti_windup"),
    ],
)
def test_an_edited_controller_is_refused(old: str, new: str, words: str, controller: Path, tmp_path: Path) -> None:
    text = controller.read_text()
    edited = re.sub(old, new, text, count=1)
    assert edited != text
    controller.write_text(edited)
    refused(run("export", controller, "-o", tmp_path / "c"), 3, "controller.yaml", words)
    assert not (tmp_path / "c").exists()


def test_a_controller_that_runs_away_is_no_solution(tmp_path: Path) -> None:
    """Anti-windup gains that make a - l c unstable: the state overflows while the drive is limited."""
    good = truthful(clutch_controller(CUT_LAW))
    speed: LinearController = msgspec.structs.replace(good.linear, anti_windup=(50.0, 0.0))
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(msgspec.structs.replace(good, linear=speed)))
    refused(run("export", path, "-o", tmp_path / "c"), 4, "anti-windup")
    assert not (tmp_path / "c").exists()


def test_a_file_in_the_way_is_named(controller: Path, tmp_path: Path) -> None:
    (tmp_path / "c").write_text("a file")
    refused(run("export", controller, "-o", tmp_path / "c"), 3, "is a file")
    (tmp_path / "d/speed.h").mkdir(parents=True)
    refused(run("export", controller, "-o", tmp_path / "d"), 3, "speed.h", "is a folder")
    assert sorted(path.name for path in (tmp_path / "d").iterdir()) == ["speed.h"]


def test_no_input_is_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "speed.c"
    path.write_text(to_yaml(truthful(clutch_controller(CUT_LAW))))
    refused(run("export", path, "-o", tmp_path), 3, "is an input")
    assert path.read_text().startswith("format: controller/1")
