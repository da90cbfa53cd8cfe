"""`frictool export`: the folder it writes, what it leaves alone, what it refuses."""

from __future__ import annotations

import io
import json
import re
import tarfile
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from frictool.documents.controller import LinearController
from frictool.documents.provenance import digest
from frictool.documents.writing import to_yaml
from frictool.export.golden_vectors import DISABLED
from studies.command_line import run
from studies.rigs.example_controllers import CUT_LAW, clutch_controller
from studies.rigs.verified_controller import truthful
from tests.support.command_line import refused
from tests.support.compiled_c import COMPILERS, NUMBERS, built, ran
from tests.support.export_controllers import scheduled

NAMES = ["speed.c", "speed.h", "speed_selftest.c", "speed_vectors.h"]


@pytest.fixture
def controller(tmp_path: Path) -> Path:
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(truthful(clutch_controller(CUT_LAW))))
    return path


@pytest.mark.parametrize("number", NUMBERS)
def test_writes_four_files_and_says_what_they_cover(
    controller: Path, number: str, tmp_path: Path
) -> None:
    (tmp_path / "deep").mkdir()
    result = run(
        "export", controller, "--lang", "c", "--number", number, "-o", tmp_path / "deep/c", "--json"
    )
    assert result.code == 0
    assert sorted(path.name for path in (tmp_path / "deep/c").iterdir()) == NAMES
    assert sorted(path.name for path in (tmp_path / "deep").iterdir()) == ["c"]
    said = json.loads(result.stdout)
    assert sorted(said["files"]) == NAMES
    assert (said["order"], said["sample_period_s"], said["number"], said["sha256"]) == (
        2,
        0.001,
        number,
        digest(controller),
    )
    vectors = said["vectors"]
    assert vectors["run"] + vectors["rest"] == vectors["samples"] - DISABLED
    assert said["rounded"]["at"] == "nominal"
    assert said["rounded"]["modulus_margin"] > 0.5
    assert (said["away_from_double"]["drive"] > 0.0) == (number != "double")
    header = (tmp_path / "deep/c/speed.h").read_text()
    assert digest(controller) in header
    assert f"frictool export controller.yaml --lang c --number {number}" in header
    assert f"modulus margin {said['rounded']['modulus_margin']:.4f} at vertex nominal" in header
    assert str(tmp_path) not in header


@pytest.mark.parametrize(
    ("lang", "files"),
    [("json", ["speed.json"]), ("matlab", ["speed.mat"]), ("cmsis", ["speed_cmsis.h"])],
)
def test_other_languages_write_one_file(
    lang: str, files: list[str], controller: Path, tmp_path: Path
) -> None:
    result = run("export", controller, "--lang", lang, "-o", tmp_path / "out")
    assert result.code == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == files
    number = "float" if lang == "cmsis" else "double"
    assert result.stdout.startswith(
        f"{files[0]}: {lang}, {number}\nverified with coefficients rounded to {number}: modulus "
        "margin 0."
    )
    first = (tmp_path / "out" / files[0]).read_bytes()
    assert digest(controller).encode() in (first.replace(b"\0", b"") if lang == "matlab" else first)
    assert run("export", controller, "--lang", lang, "-o", tmp_path / "out").code == 0
    assert (tmp_path / "out" / files[0]).read_bytes() == first


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


def test_another_controller_s_self_test_in_the_folder_is_told(
    controller: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "c"
    assert run("export", controller, "-o", folder).stderr == ""
    other = tmp_path / "other.yaml"
    other.write_text(
        re.sub(r"^name: .*$", "name: other", controller.read_text(), count=1, flags=re.MULTILINE)
    )
    told = run("export", other, "-o", folder)
    assert told.code == 0
    assert told.stderr.count("\n") == 1
    assert "speed_selftest.c" in told.stderr
    assert "other_selftest.c" not in told.stderr


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
def test_an_edited_controller_is_refused(
    old: str, new: str, words: str, controller: Path, tmp_path: Path
) -> None:
    text = controller.read_text()
    edited = re.sub(old, new, text, count=1)
    assert edited != text
    controller.write_text(edited)
    refused(run("export", controller, "-o", tmp_path / "c"), 3, "controller.yaml", words)
    assert not (tmp_path / "c").exists()


def test_a_controller_that_runs_away_is_no_solution(tmp_path: Path) -> None:
    """Anti-windup gains that make a - l c unstable: the state overflows while the drive is
    limited."""
    good = truthful(clutch_controller(CUT_LAW))
    speed: LinearController = msgspec.structs.replace(good.linear, anti_windup=(50.0, 0.0))
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(msgspec.structs.replace(good, linear=speed)))
    refused(run("export", path, "-o", tmp_path / "c"), 4, "linear.anti_windup")
    assert not (tmp_path / "c").exists()


def test_a_format_that_cannot_be_scaled_is_no_solution(tmp_path: Path) -> None:
    base = truthful(clutch_controller(CUT_LAW))
    endless = msgspec.structs.replace(
        base.bench, mechanics=msgspec.structs.replace(base.bench.mechanics, travel=None)
    )
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(msgspec.structs.replace(base, bench=endless)))
    refused(
        run("export", path, "--number", "q31", "-o", tmp_path / "c"),
        4,
        "reference has no bounds",
        "travel",
        "--number float",
    )
    assert run("export", path, "--number", "float", "-o", tmp_path / "c").code == 0


def test_a_format_that_the_language_does_not_have_is_a_wrong_command_line(tmp_path: Path) -> None:
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(truthful(clutch_controller(CUT_LAW))))
    result = run("export", path, "--lang", "cmsis", "--number", "double", "-o", tmp_path / "c")
    assert result.code == 2
    assert "--lang cmsis has no --number double; allowed: float, q31, q15" in result.stderr


def test_a_margin_that_the_format_breaks_is_no_solution(tmp_path: Path) -> None:
    """The margin that is specified is the one in double: q15 has less."""
    base = truthful(clutch_controller(CUT_LAW))
    asked = msgspec.structs.replace(
        base.verified, modulus_margin_specified=base.verified.vertices[0].modulus_margin
    )
    path = tmp_path / "controller.yaml"
    path.write_text(to_yaml(msgspec.structs.replace(base, verified=asked)))
    refused(
        run("export", path, "--lang", "json", "--number", "q15", "-o", tmp_path / "c"),
        4,
        "rounded to q15",
        "vertex nominal",
        "modulus margin is 0.",
    )
    assert not (tmp_path / "c").exists()
    assert run("export", path, "--number", "double", "-o", tmp_path / "c").code == 0


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


def test_fixed_point_of_a_scheduled_controller_is_refused_with_what_would_do(
    tmp_path: Path,
) -> None:
    between = scheduled(clutch_controller(CUT_LAW))
    assert between.schedule is not None
    alike = tuple(
        replace(corner, discrete=between.linear.discrete) for corner in between.schedule.corners
    )  # stable when rounded
    path = tmp_path / "controller.yaml"
    path.write_text(
        to_yaml(truthful(replace(between, schedule=replace(between.schedule, corners=alike))))
    )
    result = run("export", path, "--lang", "c", "--number", "q31", "-o", tmp_path / "c")
    refused(
        result, 4, "cannot be scaled to q31", "states of a scheduled controller", "--number float"
    )
    assert not (tmp_path / "c").exists()


@pytest.mark.skipif(not COMPILERS, reason="no C compiler: neither gcc nor clang is on the PATH")
@pytest.mark.parametrize("number", NUMBERS)
def test_the_self_test_loses_inputs_and_recovers(number: str, tmp_path: Path) -> None:
    """The vectors contain invalid inputs, the fault that these set, and the start that ends it. A
    wrong row of the fault is noticed."""
    path = tmp_path / "controller.yaml"
    path.write_text(
        to_yaml(truthful(replace(clutch_controller(CUT_LAW), measurement_hold_samples=2)))
    )
    result = run("export", path, "--number", number, "-o", tmp_path / "c")
    assert (result.code, "in the fault" in result.stdout) == (0, True)
    header, vectors = (
        (tmp_path / "c" / name).read_text() for name in ("speed.h", "speed_vectors.h")
    )
    assert "#define SPEED_HOLD_SAMPLES 2" in header
    assert "kept for 2 sample(s)" in header
    rows = [
        line.strip(" {},").split(", ") for line in vectors.splitlines() if line.startswith("    {")
    ]
    lost = [
        index
        for index, row in enumerate(rows)
        if {"NAN", "INFINITY", "-INFINITY", "INT32_MIN"} & set(row)
    ]
    held = 2 + 2  # while the supervisor holds the axis, with no effect
    assert len(lost) == 3 * 2 + 3 + held
    fault, restart = (
        int(re.findall(rf"{name} (\d+)", vectors)[0]) for name in ("FAULT_FROM", "RESTART")
    )
    assert fault == lost[-1 - held]
    assert {
        float.fromhex(row[-1].rstrip("f")) if "x" in row[-1] else float(row[-1])
        for row in rows[fault:restart]
    } == {0.0}
    assert ran(built(tmp_path / "c", COMPILERS[0]))[0] == 0
    (tmp_path / "c/speed_vectors.h").write_text(
        vectors.replace(f"FAULT_FROM {fault}", f"FAULT_FROM {fault + 1}")
    )
    assert ran(built(tmp_path / "c", COMPILERS[0]))[:2] == (
        1,
        f"speed: sample {fault}: the fault is 1\n",
    )


@pytest.mark.parametrize(
    ("language", "number"), [("json", "double"), ("matlab", "double"), ("cmsis", "float")]
)
def test_other_formats_say_what_they_do_not_contain(
    controller: Path, language: str, number: str, tmp_path: Path
) -> None:
    result = run("export", controller, "--lang", language, "--number", number, "-o", tmp_path / "c")
    assert result.code == 0
    assert "guard of the inputs" in result.stdout
    (file,) = (tmp_path / "c").iterdir()
    assert re.search(rb"guard (that holds|against)", file.read_bytes().replace(b"\0", b""))
