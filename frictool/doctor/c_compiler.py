"""Check of the C compiler, which `simulate --target` and the exported self-test need."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from frictool.doctor.installation_finding import InstallationFinding

NAMES = ("cc", "gcc", "clang")  # compilers that `simulate --target` looks for
PROGRAM = (
    "#include <math.h>\n#include <stdio.h>\n"
    "int main(void) { volatile double x = 2.25; return sqrt(x) == 1.5 ? 0 : 1; }\n"
)
LONGEST_S = 60.0  # s, timeout of each command


def check_c_compiler(names: tuple[str, ...] = NAMES) -> InstallationFinding:
    """Compile and run a C program with the first compiler of `names` that is on the PATH."""
    path = next((compiler for compiler in map(shutil.which, names) if compiler), None)
    if path is None:
        return InstallationFinding(
            "C compiler",
            "note",
            f"none of {', '.join(names)} is on the PATH",
            "install gcc or clang: simulate --target and self-tests need a C compiler",
        )
    facts = {"path": path, "version": _first_line([path, "--version"])}
    shown = f"{path} ({facts['version']})"
    with tempfile.TemporaryDirectory() as temporary:
        source, program = Path(temporary, "try.c"), Path(temporary, "try")
        source.write_text(PROGRAM, encoding="ascii")
        for command in (
            [path, "-std=c99", "-O2", "-o", str(program), str(source), "-lm"],
            [str(program)],
        ):
            try:
                done = subprocess.run(
                    command,
                    capture_output=True,
                    text=True,
                    errors="replace",
                    timeout=LONGEST_S,
                    check=False,
                )
                message = (
                    ""
                    if done.returncode == 0
                    else (done.stderr.strip().splitlines() or [f"exit {done.returncode}"])[0]
                )
            except (OSError, subprocess.TimeoutExpired) as error:
                message = " ".join(str(error).split())
            if message:
                return InstallationFinding(
                    "C compiler",
                    "note",
                    f"{shown} does not work: {message}",
                    "also install a C library (libc6-dev)",
                    facts,
                )
    return InstallationFinding(
        "C compiler", "ok", f"{shown}: a program was compiled and run", facts=facts
    )


def _first_line(command: list[str]) -> str:
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=LONGEST_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return "no version"
    return (done.stdout.splitlines() or ["no version"])[0].strip()
