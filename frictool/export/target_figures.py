"""Size of exported C on a Cortex-M4, and its number of instructions in the emulator QEMU.

    NAME.c    ──arm-none-eabi-gcc -O2──▶ NAME.o: bytes of code and constants, bytes of a state
    count.c   ──with target/start.c───▶ image ──qemu-system-arm -icount──▶ instructions of each step

QEMU counts instructions, not cycles: flash wait states, the pipeline and the cycles of a division
or a root are not included. Bytes of code are counted in NAME.c alone. Library functions, which
replace operations that the core lacks, are not included.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jinja2

from frictool.control.program import Program
from frictool.documents.bench import Target
from frictool.errors import FrictoolError

COMPILER, SIZE, EMULATOR = "arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"
FOLDER = Path(__file__).parent / "target"
SHIFT = 10  # QEMU runs an instruction in 2^SHIFT ns
CLOCK_MHZ = 25  # clock of the timer of the board mps2-an386
CORE_OPTIONS = ("-mcpu=cortex-m4", "-mthumb")
FLOAT_OPTIONS = {
    "cortex-m4f": ("-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"),
    "cortex-m4": ("-mfloat-abi=soft",),
}
LONGEST = 300.0  # longest time of the compiler or of QEMU [s]


@dataclass(frozen=True)
class TargetFigures:
    """Size of a controller's code on the target hardware, and number of instructions.

    - core: core of the processor, from the key `target` of bench.yaml
    - code_bytes: bytes of machine code and constants of NAME.c; None without a cross compiler
    - state_bytes: bytes of one NAME_state; None without a cross compiler
    - instructions: largest number of instructions of a step on the golden vectors; None without
      QEMU
    - instructions_mean: mean number of instructions of a step on the golden vectors
    - missing: tool that is not on the PATH; empty if no tool is missing
    """

    core: str
    code_bytes: int | None = None
    state_bytes: int | None = None
    instructions: int | None = None
    instructions_mean: float | None = None
    missing: str = ""

    def over_budget(self, target: Target) -> list[str]:
        """Return a text for each number that exceeds its limit in `target` in bench.yaml."""
        return [
            f"{value} {words}, allowed: at most {limit} (target.{key})"
            for key, words, value, limit in self._budget(target)
            if value is not None and value > limit
        ]

    def is_unchecked(self, target: Target) -> bool:
        """Return True if `target` in bench.yaml limits a number that was not measured."""
        return any(value is None for _, _, value, _ in self._budget(target))

    def _budget(self, target: Target) -> list[tuple[str, str, int | None, int]]:
        rows = [
            ("instructions", "instructions per step", self.instructions, target.instructions),
            ("code_bytes", "bytes of code", self.code_bytes, target.code_bytes),
            ("state_bytes", "bytes of state", self.state_bytes, target.state_bytes),
        ]
        return [(key, words, value, most) for key, words, value, most in rows if most is not None]

    def summary(self) -> dict[str, Any]:
        """Return the numbers as JSON values."""
        return {
            "core": self.core,
            "code_bytes": self.code_bytes,
            "state_bytes": self.state_bytes,
            "instructions": self.instructions,
            "instructions_mean": self.instructions_mean,
            "missing": self.missing or None,
        }

    def line(self) -> str:
        """Return the numbers as one line of text."""
        if self.code_bytes is None:
            return f"target {self.core}: not measured, {self.missing} is not on the PATH"
        parts = [
            f"target {self.core}, {COMPILER} -O2: {self.code_bytes} bytes of code (without "
            f"library functions), {self.state_bytes} bytes of state"
        ]
        if self.instructions is None:
            parts.append(f"instructions not counted, {self.missing} is not on the PATH")
        else:
            parts.append(
                f"{self.instructions} instructions per step at most, {self.instructions_mean:.0f} "
                "on average (QEMU, golden vectors)"
            )
        return "; ".join(parts)


def target_figures(
    name: str, files: Mapping[str, str], program: Program, kind: str, target: Target
) -> TargetFigures:
    """Return size and instruction count of exported C on the processor `target` of bench.yaml.

    - name: prefix of the files
    - files: text of each file of the export, by name
    - program: program of the controller
    - kind: C type of the values in the program
    - target: key `target` of the bench

    Raises FrictoolError if a tool fails.
    """
    if shutil.which(COMPILER) is None or shutil.which(SIZE) is None:
        return TargetFigures(target.core, missing=COMPILER)
    options = [*CORE_OPTIONS, *FLOAT_OPTIONS[target.core], "-O2"]
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for file, text in files.items():
            (folder / file).write_text(text, encoding="utf-8")
        _run([COMPILER, *options, "-std=c99", "-c", f"{name}.c"], folder)
        code = int(_run([SIZE, f"{name}.o"], folder).splitlines()[1].split()[0])
        (folder / "state.c").write_text(
            f'#include "{name}.h"\nextern char bytes[sizeof({name}_state)];\n'
            f"char bytes[sizeof({name}_state)] = {{1}};\n"
        )
        _run([COMPILER, *options, "-std=c99", "-c", "state.c"], folder)
        state = int(_run([SIZE, "state.o"], folder).splitlines()[1].split()[1])
        if shutil.which(EMULATOR) is None:
            return TargetFigures(target.core, code, state, missing=EMULATOR)
        (folder / "count.c").write_text(_count_source(name, program, kind), encoding="utf-8")
        build_image(folder / "count.elf", [folder / "count.c", folder / f"{name}.c"], target.core)
        printed = run_image(folder / "count.elf", "-icount", f"shift={SHIFT}")
    samples, total, most = map(int, printed.split())
    return TargetFigures(target.core, code, state, most, total / samples)


def build_image(image: Path, sources: list[Path], core: str, *options: str) -> None:
    """Compile and link sources with the start code of mps2-an386 to an image for QEMU.

    `core` is a key of FLOAT_OPTIONS. Raises FrictoolError with the first error of the compiler.
    """
    linking = ["-nostartfiles", "--specs=rdimon.specs", "-Wl,--gc-sections"]
    command = [
        *(COMPILER, *CORE_OPTIONS, *FLOAT_OPTIONS[core], "-O2", "-std=gnu99"),
        *("-Wall", "-Wextra", "-Werror", "-ffunction-sections", *linking, *options),
        *("-T", str(FOLDER / "mps2_an386.ld"), str(FOLDER / "start.c")),
        *(*map(str, sources), "-o", str(image), "-lm"),
    ]
    _run(command)


def run_image(image: Path, *options: str) -> str:
    """Return the output of an image in QEMU; raise FrictoolError if its exit code is not 0."""
    command = [EMULATOR, "-M", "mps2-an386", "-display", "none", "-serial", "none"]
    semihosting = ["-monitor", "none", "-semihosting-config", "enable=on,target=native"]
    return _run([*command, *semihosting, *options, "-kernel", str(image)])


def _count_source(name: str, program: Program, kind: str) -> str:
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, autoescape=False)
    template = environment.from_string((FOLDER / "count.c.jinja").read_text(encoding="utf-8"))
    return template.render(
        kind=kind,
        inputs=list(program.inputs),
        position=list(program.inputs).index("position"),
        held=[program.names[node.index] for node in program.constant_states],
        id=name,
        ID=name.upper(),
        shift=SHIFT,
        instruction_ns=2**SHIFT,
        clock_mhz=CLOCK_MHZ,
        numerator=1000 // CLOCK_MHZ,
        denominator=2**SHIFT,
    )


def _run(command: list[str], folder: Path | None = None) -> str:
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        raise FrictoolError(f"{command[0]} took longer than {LONGEST:.0f} s") from None
    if done.returncode != 0:
        lines = (done.stderr or done.stdout).splitlines() or ["no message"]
        first = next((line for line in lines if "error" in line), lines[0])
        raise FrictoolError(f"{command[0]} ended with exit code {done.returncode}: {first}")
    return done.stdout
