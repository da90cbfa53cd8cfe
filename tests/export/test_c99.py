"""The exported C: compiles without a warning, equals the simulation to the last bit, calls sqrt
alone, and is the same every time."""

from __future__ import annotations

import functools
import math
import re
import shutil
import subprocess
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictool.adapters.controller_composition import controller_program
from frictool.documents.controller import Controller, ProgramNumber
from frictool.errors import NoSolutionError
from frictool.export.c_identifier import c_identifier, comment_text
from frictool.export.c_names import TAKEN, CNames
from frictool.export.c_real_numbers import RealNumbers
from frictool.export.golden_vectors import DISABLED, GoldenVectors, golden_vectors
from studies.rigs.example_controllers import clutch_controller, speed_controller
from tests.support.compiled_c import (
    COMPILERS,
    NUMBERS,
    OPTIMISATIONS,
    STRICT,
    built,
    fits,
    in_format,
    library,
    needs_compiler,
    ran,
    simulated,
    sources,
    write,
)
from tests.support.export_cases import CASES, VISITS
from tests.support.export_controllers import controllers
from tests.support.export_inputs import rows_for

SAMPLES = 600
FITTING: list[tuple[str, ProgramNumber]] = [
    (case, number)
    for case in CASES
    for number in NUMBERS
    if number in NUMBERS[:2] or case != "scheduled"
]
ways = st.tuples(st.sampled_from(COMPILERS or [""]), st.sampled_from(OPTIMISATIONS))


@functools.cache
def vectors_of(case: str, number: ProgramNumber) -> GoldenVectors:
    return golden_vectors(CASES[case], controller_program(CASES[case]), number)


class Exports(dict[tuple[str, ProgramNumber], Path]):
    """A folder of each case in each number format, written when it is first used."""

    def __init__(self, root: Path) -> None:
        self.root = root

    def __missing__(self, pair: tuple[str, ProgramNumber]) -> Path:
        self[pair] = self.root / "_".join(pair)
        write(CASES[pair[0]], self[pair], pair[1], vectors_of(*pair))
        return self[pair]


@pytest.fixture(scope="module")
def exports(tmp_path_factory: pytest.TempPathFactory) -> Exports:
    return Exports(tmp_path_factory.mktemp("exports"))


# here each format by the first compiler, optimised, and one format by every compiler in each way;
# the others in `make accept`
BUILDS = [
    pytest.param(
        *("cascade", number, one, way),
        marks=() if number == NUMBERS[k] or (k == 0 and way == "-O3") else pytest.mark.accept,
    )
    for k, one in enumerate(COMPILERS)
    for way in OPTIMISATIONS
    for number in NUMBERS
]


@needs_compiler
@pytest.mark.parametrize(("case", "number", "compiler", "optimisation"), BUILDS)
def test_every_compiler_gives_every_bit(
    case: str,
    number: ProgramNumber,
    compiler: str,
    optimisation: str,
    exports: Exports,
) -> None:
    code, told, _ = ran(built(exports[case, number], compiler, optimisation))
    samples = int(
        re.findall(r"_SAMPLES (\d+)", (exports[case, number] / "speed_vectors.h").read_text())[0]
    )
    assert (code, told) == (0, f"speed: {samples} samples, every bit as in the simulation\n")


# here each case in one format; the others in `make accept`
SELF_TESTED = [
    pytest.param(
        *(case, number),
        marks=()
        if list(CASES).index(case) % len(NUMBERS) == NUMBERS.index(number)
        else pytest.mark.accept,
    )
    for case, number in FITTING
    if case != "cascade"
]


@needs_compiler
@pytest.mark.parametrize(("case", "number"), SELF_TESTED)
def test_self_test_passes_bit_by_bit(case: str, number: ProgramNumber, exports: Exports) -> None:
    compiler = COMPILERS[len(case) % len(COMPILERS)]
    assert ran(built(exports[case, number], compiler, "-O3"))[0] == 0


@needs_compiler
@settings(max_examples=settings.default.max_examples // 6)
@given(
    controller=controllers(), number=st.sampled_from(NUMBERS), way=ways, seed=st.integers(0, 2**16)
)
def test_random_controllers_on_random_inputs(
    tmp_path_factory: pytest.TempPathFactory,
    controller: Controller,
    number: ProgramNumber,
    way: tuple[str, str],
    seed: int,
) -> None:
    program = controller_program(controller)
    if not fits(program, number):
        return
    folder = tmp_path_factory.mktemp("random")
    rows = in_format(program, number, rows_for(controller, program, SAMPLES, seed))
    expected = simulated(program, number, rows)
    write(controller, folder, number)
    drives = library(controller, number, folder, *way)(rows)
    assert np.all(np.abs(drives.astype(np.float64)) < math.inf)
    assert drives.tobytes() == expected.tobytes()


@needs_compiler
@pytest.mark.parametrize("number", NUMBERS)
def test_no_undefined_behaviour(number: ProgramNumber, exports: Exports) -> None:
    folder = exports["cascade" if number in ("double", "q31") else "position", number]
    program = built(
        folder, COMPILERS[0], "-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"
    )
    code, _, complaints = ran(program)
    assert (code, complaints) == (0, "")


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="there is no cppcheck on the PATH")
@pytest.mark.parametrize(
    "looked",
    [
        [("cascade", "double"), ("cascade", "q31"), ("position", "float")],
        pytest.param(
            [
                *(("cascade", "float"), ("position", "double"), ("position", "q31")),
                ("scheduled", "double"),
            ],
            marks=pytest.mark.accept,
        ),
    ],
    ids=["some", "others"],
)
def test_cppcheck_finds_nothing(looked: list[tuple[str, ProgramNumber]], exports: Exports) -> None:
    files = [
        str(exports[pair] / name) for pair in looked for name in ("speed.c", "speed_selftest.c")
    ]
    checks = [
        "--enable=all",
        "--inconclusive",
        "--suppress=missingIncludeSystem",
        "--std=c99",
        "--quiet",
        "--error-exitcode=1",
    ]
    done = subprocess.run(
        ["cppcheck", *checks, *files], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@needs_compiler
@pytest.mark.parametrize("number", ["double", "float"])
def test_products_are_never_fused_into_sums(number: ProgramNumber, exports: Exports) -> None:
    """A target with fused multiply-add gives other last bits unless the compiler is told not to."""
    for compiler in COMPILERS:
        machine = subprocess.run(
            [compiler, "-dumpmachine"], check=True, capture_output=True, text=True
        ).stdout
        if not machine.startswith("x86_64"):
            pytest.skip(
                "the flags of this test are those of x86_64, the compiler's target is "
                f"{machine.strip()}"
            )
        command = [
            compiler,
            "-O3",
            "-mfma",
            "-S",
            "-o",
            "-",
            str(exports["cascade", number] / "speed.c"),
        ]
        assembly = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        assert ("mulsd" if number == "double" else "mulss") in assembly
        assert not re.search(r"vfn?m(add|sub)", assembly)
        assert number == "double" or not re.search(r"cvtss2sd|mulsd|addsd", assembly)


@needs_compiler
@pytest.mark.parametrize("number", ["double", "q31"])
@pytest.mark.parametrize("part", ["coefficient", "vector"])
def test_self_test_notices_one_bit(
    part: str, number: ProgramNumber, exports: Exports, tmp_path: Path
) -> None:
    folder = Path(shutil.copytree(exports["cut", number], tmp_path / "c"))
    file, pattern = {
        "coefficient": (folder / "speed.c", r"(prefilter_q = )([^;]+)"),
        "vector": (folder / "speed_vectors.h", r"(.*\{[^,]+, [^,]+, )(0x1[^}]+|[1-9][^}]+)"),
    }[part]
    found = re.search(pattern, file.read_text())
    assert found is not None
    if number == "q31":
        other = str(int(found[2]) + 1)
    else:
        other = math.nextafter(
            float.fromhex(found[2]) if "0x" in found[2] else float(found[2]), math.inf
        ).hex()
    file.write_text(file.read_text().replace(found[0], f"{found[1]}{other}", 1))
    code, told, _ = ran(built(folder, COMPILERS[0]))
    assert code == 1
    value = r"-?0x\S+" if number == "double" else r"-?\d+"
    assert re.fullmatch(
        rf"speed: sample \d+: reference {value}, position {value}: expected {value}, got {value}\n",
        told,
    )


@pytest.mark.parametrize(("case", "number"), FITTING)
def test_calls_nothing_but_sqrt_and_allocates_nothing(
    case: str, number: ProgramNumber, exports: Exports
) -> None:
    source = (exports[case, number] / "speed.c").read_text()
    code = re.sub(r"/\*.*?\*/", "", source, flags=re.DOTALL)
    defined = set(
        re.findall(
            r"^(?:static )?(?:double|float|int|int32_t|int64_t|void) (\w+)\(",
            code,
            flags=re.MULTILINE,
        )
    )
    called = set(re.findall(r"\b(\w+)\(", code)) - {"if", "while", "defined", "optimize", "return"}
    assert called - defined <= {"double": {"sqrt"}, "float": {"sqrtf"}}.get(number, {"INT64_C"})
    root = number in ("double", "float") and case not in ("position", "sections", "streamed")
    assert re.findall(r"#include (.*)", code) == ['"speed.h"', *(["<math.h>"] if root else [])]
    assert number != "float" or not re.search(r"\d\.\d+(e[-+]?\d+)?(?![\df.e])|\bdouble\b", code)


@pytest.mark.parametrize(("case", "number"), FITTING)
def test_vectors_visit_everything_the_controller_can_do(case: str, number: ProgramNumber) -> None:
    vectors = vectors_of(case, number)
    assert set(vectors.visits) == VISITS[case]
    assert min(vectors.visits.values()) > 10
    modes = [vectors.visits[name] for name in ("run", "brake", "rest") if name in vectors.visits]
    assert not modes or sum(modes) == vectors.samples - DISABLED
    assert vectors.samples < 5000
    drives = [row[-1] for row in vectors.rows]
    assert (min(drives), max(drives)) == (-50.0, 50.0)
    assert (number == "double") == (vectors.away == 0.0)
    assert vectors.away < {"double": 1e-9, "float": 0.01, "q31": 1e-3}[number]


def test_vectors_wait_for_a_slow_prefilter() -> None:
    """Sampled at 10 kHz, a prefilter of 30 rad/s settles in thousands of samples."""
    fast = msgspec.structs.replace(
        CASES["cascade"], sample_period_s=1e-4, linear=speed_controller(1e-4)
    )
    vectors = golden_vectors(fast, controller_program(fast), "double")
    assert min(vectors.visits.values()) > 10
    assert vectors.samples < 40_000


def test_same_controller_same_bytes_and_every_coefficient_exact() -> None:
    controller = CASES["cut"]
    assert sources(controller) == sources(
        msgspec.structs.replace(controller), "double", vectors_of("cut", "double")
    )
    code, single = (
        sources(controller, number, vectors_of("cut", number))["speed.c"] for number in NUMBERS[:2]
    )
    double, float_ = RealNumbers("double").literal, RealNumbers("float").literal
    for row in controller.linear.discrete.a:
        assert "{" + ", ".join(map(double, row)) + "}" in code
        assert "{" + ", ".join(map(float_, row)) + "}" in single
        assert all(float(double(value)) == value for value in row)
        assert all(np.float32(float_(value)[:-1]) == np.float32(value) for value in row)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_literals_give_back_every_bit(value: float) -> None:
    assert float(RealNumbers("double").literal(value)).hex() == value.hex()
    if 1e-37 < abs(value) < 1e38:
        assert (
            np.float32(RealNumbers("float").literal(value)[:-1]).tobytes()
            == np.float32(value).tobytes()
        )


@pytest.mark.parametrize("value", [1e39, -1e300, 1e-60])
def test_what_float_cannot_hold_is_refused(value: float) -> None:
    with pytest.raises(NoSolutionError, match=r"beyond the range of float; use --number double"):
        RealNumbers("float").literal(value)


@settings(max_examples=25)
@given(controllers())
def test_names_are_unique_words_that_c_leaves_free(controller: Controller) -> None:
    names = CNames(controller_program(controller))
    words = [
        *names.results.values(),
        *(table.name for table in names.constants),
        *names.program.inputs,
    ]
    assert len(set(words)) == len(words)
    assert not set(words) & TAKEN
    assert all(re.fullmatch(r"[a-z]\w*", word) for word in words)


@pytest.mark.parametrize(
    "name", ["*/ int x; /*", "a\\", "??/", "math", "2 rad", "Übung", "日本", "x" * 80]
)
def test_any_name_is_a_name_in_c(name: str, tmp_path: Path) -> None:
    identifier = c_identifier(name)
    assert re.fullmatch(r"[a-z][a-z0-9_]*", identifier)
    assert identifier not in {"math", "string"}
    assert not re.search(r"[/*\\?]|[^ -~]", comment_text(name))
    write(
        msgspec.structs.replace(clutch_controller(), name=name),
        tmp_path,
        "double",
        vectors_of("cut", "double"),
    )
    if COMPILERS:
        command = [
            COMPILERS[0],
            *STRICT,
            f"-I{tmp_path}",
            "-fsyntax-only",
            *map(str, tmp_path.glob("*.c")),
        ]
        assert subprocess.run(command, capture_output=True, text=True, check=False).stderr == ""
