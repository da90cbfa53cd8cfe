"""The exported C: compiles without a warning, equals the simulation to the last bit, calls sqrt alone, and is the same every time."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.documents.controller import Controller, PositionLaw
from frictool.export.c99 import c_sources, literal
from frictool.export.identifier import c_identifier, comment_text
from frictool.export.vectors import golden_vectors
from tests.control.example import BRAKE_LAW, CUT_LAW, clutch_controller, speed_controller
from tests.control.test_cascade import random_controller

CC = shutil.which("cc")
needs_cc = pytest.mark.skipif(CC is None, reason="no C compiler: there is no cc on the PATH")
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror"]
CASES = {
    "cut": clutch_controller(CUT_LAW),
    "brake": clutch_controller(BRAKE_LAW),
    "no prefilter": clutch_controller(CUT_LAW, prefilter=False),
    "brake, no prefilter": clutch_controller(BRAKE_LAW, prefilter=False),
}


def sources(controller: Controller) -> dict[str, str]:
    return c_sources(controller, golden_vectors(controller), "0" * 64, "frictool export controller.yaml --lang c")


def write(controller: Controller, folder: Path) -> str:
    for name, text in sources(controller).items():
        (folder / name).write_text(text)
    return c_identifier(controller.name)


def compiled(folder: Path, *options: str) -> subprocess.CompletedProcess[str]:
    assert CC is not None
    files = sorted(str(path) for path in folder.glob("*.c"))
    subprocess.run([CC, *options, *files, "-o", str(folder / "selftest"), "-lm"], check=True, capture_output=True, text=True)
    return subprocess.run([folder / "selftest"], capture_output=True, text=True, timeout=30)


@needs_cc
@pytest.mark.parametrize("optimisation", ["-O0", "-O3"])
@pytest.mark.parametrize("case", CASES)
def test_self_test_passes_bit_by_bit(case: str, optimisation: str, tmp_path: Path) -> None:
    write(CASES[case], tmp_path)
    result = compiled(tmp_path, *STRICT, optimisation)
    assert (result.returncode, result.stdout) == (
        0,
        f"speed: {golden_vectors(CASES[case]).samples} samples, every bit as in the simulation\n",
    )


@needs_cc
@settings(max_examples=8)
@given(order=st.integers(0, 7), seed=st.integers(0, 2**16), law=st.sampled_from([CUT_LAW, BRAKE_LAW]), prefilter=st.booleans())
def test_random_controllers_are_equal_too(
    tmp_path_factory: pytest.TempPathFactory, order: int, seed: int, law: PositionLaw, prefilter: bool
) -> None:
    folder = tmp_path_factory.mktemp("c")
    controller = msgspec.structs.replace(
        clutch_controller(CUT_LAW, prefilter=prefilter), position_law=law, linear=random_controller(order, seed)
    )
    write(controller, folder)
    result = compiled(folder, *STRICT)
    assert result.returncode == 0, result.stdout


@needs_cc
def test_the_readme_command_compiles_and_no_undefined_behaviour(tmp_path: Path) -> None:
    write(CASES["brake"], tmp_path)
    assert compiled(tmp_path).returncode == 0
    sanitised = compiled(tmp_path, "-fsanitize=undefined,address", "-fno-sanitize-recover=all")
    assert (sanitised.returncode, sanitised.stderr) == (0, "")


@needs_cc
def test_products_are_never_fused_into_sums(tmp_path: Path) -> None:
    """A target with fused multiply-add gives other last bits unless the compiler is told not to."""
    name = write(CASES["brake"], tmp_path)
    assert CC is not None
    machine = subprocess.run([CC, "-dumpmachine"], check=True, capture_output=True, text=True).stdout
    if not machine.startswith("x86_64"):
        pytest.skip(f"the flags of this test are those of x86_64, the compiler's target is {machine.strip()}")
    command = [CC, "-O3", "-mfma", "-S", "-o", "-", str(tmp_path / f"{name}.c")]
    assembly = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert "mulsd" in assembly
    assert not re.search(r"vfn?m(add|sub)", assembly)


@needs_cc
@pytest.mark.parametrize("part", ["coefficient", "vector"])
def test_self_test_notices_one_bit(part: str, tmp_path: Path) -> None:
    name = write(CASES["brake"], tmp_path)
    file, pattern = {
        "coefficient": (tmp_path / f"{name}.c", r"(prefilter_q = )([^;]+)"),
        "vector": (tmp_path / f"{name}_vectors.h", r"(.*0x[^,]+, 0x[^,]+, )(0x1[^}]+)"),
    }[part]
    found = re.search(pattern, file.read_text())
    assert found is not None
    old = float.fromhex(found[2]) if "0x" in found[2] else float(found[2])
    text = file.read_text().replace(found[0], f"{found[1]}{math.nextafter(old, math.inf).hex()}", 1)
    file.write_text(text)
    result = compiled(tmp_path, *STRICT)
    assert result.returncode == 1
    assert re.fullmatch(r"speed: sample \d+: reference 0x\S+, position 0x\S+: expected -?0x\S+, got -?0x\S+\n", result.stdout)


def test_calls_nothing_but_sqrt_and_allocates_nothing() -> None:
    source = sources(CASES["brake"])["speed.c"]
    code = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
    defined = set(re.findall(r"^(?:static )?(?:double|void|int) (\w+)\(", code, flags=re.MULTILINE))
    called = set(re.findall(r"\b(\w+)\(", code)) - {"if", "for", "defined", "optimize", "return"}
    assert called - defined == {"sqrt"}
    assert re.findall(r"#include (.*)", code) == ['"speed.h"', "<math.h>"]


@pytest.mark.parametrize("case", CASES)
def test_vectors_visit_everything_the_controller_can_do(case: str) -> None:
    vectors = golden_vectors(CASES[case])
    assert vectors.run > 100
    assert vectors.rest > 10
    assert vectors.limited > 40
    assert (vectors.brake > 5) == ("brake" in case)
    assert vectors.run + vectors.brake + vectors.rest == vectors.samples < 5000
    drives = [drive for _, _, drive in vectors.rows]
    assert max(drives) == 50.0
    assert min(drives) == -50.0


def test_vectors_wait_for_a_slow_prefilter() -> None:
    """Sampled at 10 kHz, a prefilter of 30 rad/s settles in thousands of samples."""
    fast = msgspec.structs.replace(CASES["brake"], sample_period_s=1e-4, linear=speed_controller(1e-4))
    vectors = golden_vectors(fast)
    assert min(vectors.run, vectors.limited) > 100
    assert min(vectors.brake, vectors.rest) > 10
    assert vectors.samples < 40_000


def test_same_controller_same_bytes_and_every_coefficient_exact() -> None:
    controller = CASES["brake"]
    assert sources(controller) == sources(msgspec.structs.replace(controller))
    code = sources(controller)["speed.c"]
    a = controller.linear.discrete.a
    for row in a:
        assert "{" + ", ".join(literal(value) for value in row) + "}" in code
        assert all(float(literal(value)) == value for value in row)


@pytest.mark.parametrize("name", ["*/ int x; /*", "a\\", "??/", "math", "2 rad", "Übung", "日本", "x" * 80])
def test_any_name_is_a_name_in_c(name: str, tmp_path: Path) -> None:
    identifier = c_identifier(name)
    assert re.fullmatch(r"[a-z][a-z0-9_]*", identifier)
    assert identifier not in {"math", "string"}
    assert not re.search(r"[/*\\?]|[^ -~]", comment_text(name))
    if CC is not None:
        write(msgspec.structs.replace(CASES["cut"], name=name), tmp_path)
        assert compiled(tmp_path, *STRICT, f"-I{tmp_path}").returncode == 0
