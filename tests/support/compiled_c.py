"""Exported C compiled strictly and played on rows of inputs, beside the simulation's own machine on
the same rows."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from frictool.adapters.controller_composition import controller_program
from frictool.control.coefficient_words import BITS
from frictool.control.compiled_program import FIXED, FLOAT, CompiledProgram, control_step, start_at
from frictool.control.fixed_point import FixedPointOverflow, fixed_program
from frictool.control.fixed_point_kernel import INVALID, from_real
from frictool.control.number_format import machine_in
from frictool.control.program import Program
from frictool.documents.controller import Controller, ProgramNumber
from frictool.export.c99 import c_sources
from frictool.export.c_identifier import c_identifier
from frictool.export.export_origin import ExportOrigin
from frictool.export.golden_vectors import GoldenVectors, golden_vectors
from frictool.export.rounded_loop import RoundedLoop
from frictool.runtime.kernels import kernel

Values = NDArray[Any]
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Wshadow", "-Werror"]
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
OPTIMISATIONS = ["-O0", "-O3"]
NUMBERS: tuple[ProgramNumber, ...] = ("double", "float", "q31")
KINDS: dict[str, Any] = {
    "double": np.float64,
    "float": np.float32,
    "q31": np.int32,
}
ORIGIN = ExportOrigin("0" * 64, "frictool export controller.yaml --lang c")
LOOP = RoundedLoop(0.5, "nominal", None, "")
needs_compiler = pytest.mark.skipif(
    not COMPILERS, reason="no C compiler: neither gcc nor clang is on the PATH"
)
DRIVER = """
#include "{id}.h"

void play(long samples, {kind} position, const {kind} *rows, {kind} *drives);

void play(long samples, {kind} position, const {kind} *rows, {kind} *drives)
{{
    {id}_state state;
    long k;

    {id}_init(&state, position);
    for (k = 0; k < samples; k++) {{
        const {kind} *row = rows + {width} * k;

{sets}        drives[k] = {id}_step(&state{arguments});
    }}
}}
"""


def sources(
    controller: Controller, number: ProgramNumber = "double", vectors: GoldenVectors | None = None
) -> dict[str, str]:
    """The exported files of a controller whose loop nobody has verified."""
    program = controller_program(controller)
    return c_sources(
        controller,
        program,
        number,
        vectors or golden_vectors(controller, program, number),
        LOOP,
        ORIGIN,
    )


def write(
    controller: Controller,
    folder: Path,
    number: ProgramNumber = "double",
    vectors: GoldenVectors | None = None,
) -> str:
    """The files in `folder`; the prefix of their names."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in sources(controller, number, vectors).items():
        (folder / name).write_text(text)
    return c_identifier(controller.name)


def built(folder: Path, compiler: str, *options: str) -> Path:
    """The self-test, compiled strictly."""
    program = folder / f"selftest-{compiler}{''.join(options)}"
    files = sorted(map(str, folder.glob("*.c")))
    done = subprocess.run(
        [compiler, *STRICT, *options, *files, "-o", str(program), "-lm"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return program


def ran(program: Path) -> tuple[int, str, str]:
    """Exit code, stdout, stderr of a self-test."""
    done = subprocess.run([program], capture_output=True, text=True, timeout=60, check=False)
    return done.returncode, done.stdout, done.stderr


def held(program: Program) -> list[str]:
    """The scheduled parameters, as the rows have them behind the inputs."""
    return [
        program.names[node.index]
        for node in program.states.values()
        if node.index not in program.updates
    ]


def library(
    controller: Controller, number: ProgramNumber, folder: Path, compiler: str, *options: str
) -> Any:
    """`play` of the compiled code: rows (n, m) of inputs and scheduled parameters to drives (n,),
    in the number format's own type."""
    name, program = c_identifier(controller.name), controller_program(controller)
    kind = {"double": "double", "float": "float"}.get(number, "int32_t")
    count = len(program.inputs)
    sets = "".join(
        f"        {name}_set_{one}(&state, row[{count + k}]);\n"
        for k, one in enumerate(held(program))
    )
    arguments = "".join(f", row[{k}]" for k in range(count))
    width = count + len(held(program))
    (folder / "driver.c").write_text(
        DRIVER.format(id=name, kind=kind, width=width, sets=sets, arguments=arguments)
    )
    path = folder / f"lib-{compiler}{''.join(options)}.so"
    command = [
        compiler,
        *STRICT,
        *options,
        "-shared",
        "-fPIC",
        str(folder / f"{name}.c"),
        str(folder / "driver.c"),
        "-o",
        str(path),
        "-lm",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    loaded, scalar = (
        ctypes.CDLL(str(path)),
        {"double": ctypes.c_double, "float": ctypes.c_float}.get(number, ctypes.c_int32),
    )
    loaded.play.argtypes, loaded.play.restype = (
        [ctypes.c_long, scalar, ctypes.c_void_p, ctypes.c_void_p],
        None,
    )

    def play(rows: Values) -> Values:
        given = np.ascontiguousarray(rows, dtype=KINDS[number])
        drives = np.empty(len(given), dtype=KINDS[number])
        position = given[0, list(program.inputs).index("position")]
        loaded.play(len(given), position.item(), given.ctypes.data, drives.ctypes.data)
        return drives

    return play


def in_format(program: Program, number: ProgramNumber, rows: Values) -> Values:
    """Return rows (n, m) in SI as the format's own values; fixed point rounds and saturates, and
    has a word for a lost input."""
    if number not in BITS:
        return rows.astype(KINDS[number])
    scaled = fixed_program(program, BITS[number])
    columns = [*program.inputs.values(), *(program.states[name] for name in held(program))]
    words = np.empty(rows.shape, dtype=np.int32)
    for k, node in enumerate(columns):
        low, high = scaled.words[node.index]
        valid = np.isfinite(rows[:, k])
        values = np.where(valid, rows[:, k], 0.0)
        words[:, k] = np.where(
            valid,
            np.clip(np.rint(np.ldexp(values, scaled.fractions[node.index])), low, high),
            INVALID,
        )
    return words


def simulated(program: Program, number: ProgramNumber, rows: Values) -> Values:
    """The machine's drives on rows in the format's own values."""
    running = machine_in(program, number)
    places = np.array(
        [node.index for node in program.inputs.values()]
        + [program.states[name].index for name in held(program)]
    )
    fractions = (
        np.array([running.formats[place, 0] for place in places])
        if running.number == FIXED
        else np.zeros(len(places), dtype=np.int64)
    )
    si = np.ldexp(rows.astype(np.float64), -fractions)
    if running.number == FIXED:
        si[rows == INVALID] = np.nan
    start_at(running, si[0, list(program.inputs).index("position")])
    drives = np.empty(len(rows))
    _played(running, places, len(program.inputs), si, drives)
    assert program.output is not None
    fraction = int(running.formats[program.output.index, 0]) if running.number == FIXED else 0
    return np.ldexp(drives, fraction).astype(KINDS[number])


@kernel
def _played(
    running: CompiledProgram, places: Values, inputs: int, rows: Values, drives: Values
) -> None:
    for k in range(rows.shape[0]):
        for j in range(inputs, places.shape[0]):  # scheduled parameters
            if running.number == FIXED:
                running.word[places[j]] = from_real(running.formats[places[j]], rows[k, j])
            elif running.number == FLOAT:
                running.single[places[j]] = rows[k, j]
            else:
                running.real[places[j]] = rows[k, j]
        drives[k] = control_step(running, rows[k, 0], rows[k, 1], rows[k, 2] if inputs > 2 else 0.0)


def fits(program: Program, number: ProgramNumber) -> bool:
    """Return True if the program can be scaled for fixed point."""
    try:
        machine_in(program, number)
    except FixedPointOverflow:
        return False
    return True
