"""Exported C code of a controller, compiled and called by the simulation.

    DIR/NAME.c, NAME.h  ──cc──▶ shared library ──ctypes──▶ step(reference, position,
                                                          velocity) -> drive

A wrapper in C converts numbers as the simulation does. A simulation with the exported code is
therefore bit by bit equal to a simulation of the controller. The header of the C code contains the
SHA-256 of the exported controller document; the simulated controller must have the same SHA-256.
"""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import cast, get_args

from frictool.control.supervision import CommandName
from frictool.documents.controller import ProgramNumber
from frictool.errors import InputFileError

COMPILERS = ("cc", "gcc", "clang")
OPTIONS = ("-std=c99", "-O2", "-fPIC", "-shared")
LONGEST = 120.0  # s, longest duration of a compilation
MACROS = re.compile(
    r'^#define (\w+)_CONTROLLER_SHA256 "([0-9a-f]{64})"\s+'
    r'^#define \1_NUMBER "(double|float|q31)"',
    re.MULTILINE,
)
BETWEEN = (
    r"""
#include "{id}.h"

#include <math.h>

static {id}_state state;

#if {fixed} /* words */
static int32_t given(double value, int fraction, double low, double high)
{{
    const double scaled = ldexp(value, fraction);

    return !isfinite(value) ? {ID}_INVALID : """
    r"""(int32_t)(scaled >= high ? high : (scaled <= low ? low : rint(scaled)));
}}
#define GIVEN(value, NAME) given(value, {ID}_##NAME##_FRACTION, """
    r"""{ID}_##NAME##_LOW, {ID}_##NAME##_HIGH)
#define TAKEN(value) ldexp((double)(value), -({ID}_DRIVE_FRACTION))
#else
#define GIVEN(value, NAME) ({kind})(value)
#define TAKEN(value) (double)(value)
#endif

void target_start(double position);
double target_step(double reference, double position, double velocity);

void target_start(double position)
{{
    {id}_init(&state, GIVEN(position, POSITION));
}}

double target_step(double reference, double position, double velocity)
{{
    (void)velocity;
    return TAKEN({id}_step(&state, {arguments}));
}}

void target_command(int which, double position);

void target_command(int which, double position)
{{
    switch (which) {{
    case 0: {id}_disable(&state); break;
    case 1: {id}_enable(&state, GIVEN(position, POSITION)); break;
    case 2: {id}_hold(&state, 1); break;
    case 3: {id}_hold(&state, 0); break;
    case 4: {id}_set_fault(&state); break;
    default: {id}_init(&state, GIVEN(position, POSITION)); break;
    }}
}}

void target_tell(int which, double value);

void target_tell(int which, double value)
{{
    (void)which;
    (void)value;
{settings}}}
"""
)


class CompiledTarget:
    """Compiled C code of a controller, which controls one axis at a time.

    - number: number format of the code
    - sources: the C files
    - scheduled: present values of the parameters by which the gains are scheduled
    """

    def __init__(
        self, library: ctypes.CDLL, number: ProgramNumber, sources: tuple[Path, ...]
    ) -> None:
        self.number, self.sources = number, sources
        self._start, self._step = library.target_start, library.target_step
        self._tell = library.target_tell
        self._command = library.target_command
        self.scheduled = list[float]()
        self._tell.argtypes = [ctypes.c_int, ctypes.c_double]
        self._tell.restype = None
        self._command.argtypes = [ctypes.c_int, ctypes.c_double]
        self._command.restype = None
        self._start.argtypes = [ctypes.c_double]
        self._start.restype = None
        self._step.argtypes = [ctypes.c_double] * 3
        self._step.restype = ctypes.c_double

    def start(self, position: float) -> None:
        """Start the controller at `position` [rad | m], with the prefilter in steady state."""
        self._start(position)
        self._tell_scheduled()

    def _tell_scheduled(self) -> None:
        for which, value in enumerate(self.scheduled):
            self._tell(which, value)

    def command(self, name: CommandName, position: float) -> None:
        """Execute a command of a supervisor; `position` [rad | m] is the measured position."""
        self._command(get_args(CommandName).index(name), position)
        self._tell_scheduled()

    def step(self, reference: float, position: float, velocity: float) -> float:
        """Compute one sample of the controller and return the drive [A | V]."""
        return float(self._step(reference, position, velocity))


def compiled_target(
    folder: Path,
    sha256: str,
    controller: str,
    inputs: tuple[str, ...],
    scheduled: tuple[str, ...] = (),
) -> CompiledTarget:
    """Compile the C code in `folder` that was exported from a controller document.

    - sha256: digest of the controller document; the code's header must state the same digest
    - controller: path of the document in messages
    - inputs: names of the controller's inputs
    - scheduled: names of the parameters by which the gains are scheduled

    Raises InputFileError if the folder has no sources of this controller, if no compiler is on the
    PATH, or if the compilation fails.
    """
    header, name, number = _header(folder, sha256, controller)
    source = header.with_suffix(".c")
    if not source.is_file():
        raise InputFileError(
            source,
            f"is missing in the folder of {header.name}; export again: frictool export "
            f"{controller} --lang c -o {folder}",
        )
    compiler = next((path for path in map(shutil.which, COMPILERS) if path), None)
    if compiler is None:
        raise InputFileError(
            folder,
            f"needs a C compiler: none of {', '.join(COMPILERS)} is on the PATH; install one",
        )
    with tempfile.TemporaryDirectory() as temporary:
        library = Path(temporary) / "target.so"
        between = Path(temporary) / "between.c"
        arguments = ", ".join(f"GIVEN({one}, {one.upper()})" for one in inputs)
        fixed = int(number == "q31")
        kind = "int32_t" if fixed else number
        settings = "".join(
            f"    if (which == {index}) {{\n        {name}_set_{one}(&state, ({kind})value);\n    "
            f"}}\n"
            for index, one in enumerate(scheduled)
        )
        text = BETWEEN.format(
            id=name, ID=name.upper(), kind=kind, fixed=fixed, arguments=arguments, settings=settings
        )
        between.write_text(text, encoding="utf-8")
        _compile(
            [
                compiler,
                *OPTIONS,
                f"-I{folder}",
                "-o",
                str(library),
                str(source),
                str(between),
                "-lm",
            ],
            source,
        )
        return CompiledTarget(ctypes.CDLL(str(library)), number, (header, source))


def _header(folder: Path, sha256: str, controller: str) -> tuple[Path, str, ProgramNumber]:
    if not folder.is_dir():
        raise InputFileError(
            folder,
            f"is not a folder; allowed: the folder that `frictool export {controller} --lang c -o "
            "FOLDER` writes",
        )
    others = []
    for header in sorted(folder.glob("*.h")):
        match = MACROS.search(header.read_text(encoding="utf-8", errors="replace"))
        if match is not None and match[2] == sha256:
            return header, match[1].lower(), cast(ProgramNumber, match[3])
        if match is not None:
            others.append(f"{header.name} belongs to the controller {match[2][:12]}")
    listed = "; ".join(others) or "there is no header of frictool export"
    raise InputFileError(
        folder,
        f"has no sources of {controller} (SHA-256 {sha256[:12]}): {listed}; export the controller "
        "into this folder",
    )


def _compile(command: list[str], source: Path) -> None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise InputFileError(source, f"cannot be compiled: {error}") from None
    if done.returncode != 0:
        first = next(
            (line for line in done.stderr.splitlines() if "error" in line),
            done.stderr.strip().partition("\n")[0],
        )
        raise InputFileError(source, f"does not compile: {first}; export the controller again")
