"""Exported C on an emulated Cortex-M4: the self-tests, and the controller in a timer interrupt.

    python -m studies.target FOLDER [--controller controller.yaml]

Each number format is exported and built with arm-none-eabi-gcc for a core with and a core without a
floating-point unit. QEMU (mps2-an386) runs each self-test. Then `loop.c` runs the example's
controller in a timer interrupt; with --controller this part is left out. The exit code is 1 if a
build does not reproduce every bit, or if the loop does not reach its reference.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from msgspec.structs import replace

from frictool.documents.bench import Target
from frictool.documents.controller import Controller, ProgramNumber
from frictool.documents.registry import load
from frictool.errors import FrictoolError
from frictool.export import export
from frictool.export.target_figures import (
    COMPILER,
    EMULATOR,
    build_image,
    run_image,
)
from studies.rigs.example_controllers import CUT_LAW, clutch_controller
from studies.rigs.verified_controller import truthful

NUMBERS: tuple[ProgramNumber, ...] = ("double", "float", "q31")
Core = Literal["cortex-m4f", "cortex-m4"]
CORES: tuple[Core, ...] = ("cortex-m4f", "cortex-m4")
HERE = Path(__file__).parent
HEADER = f"{'number':<8}{'core':<12}{'code [B]':>9}{'state [B]':>11}{'instructions':>14}  self-test"


def write(files: Mapping[str, str | bytes], folder: Path) -> None:
    """Write exported files to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(str(text))


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m studies.target",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", type=Path, help="folder for the files and images")
    parser.add_argument("--controller", type=Path, help="controller in place of the example")
    options = parser.parse_args(arguments)
    missing = [tool for tool in (COMPILER, EMULATOR) if shutil.which(tool) is None]
    if missing:
        print(f"not on the PATH: {', '.join(missing)}", file=sys.stderr)
        return 3
    example = truthful(clutch_controller(CUT_LAW))
    controller = load(options.controller, Controller) if options.controller else example
    print(HEADER)
    passed = [
        self_test(options.folder, controller, number, core) for number in NUMBERS for core in CORES
    ]
    print(f"{sum(passed)} of {len(passed)} builds reproduce every bit")
    if options.controller:
        return int(not all(passed))
    return int(not (all(passed) and timer_loop(options.folder, example)))


def self_test(folder: Path, controller: Controller, number: ProgramNumber, core: Core) -> bool:
    """Print the row of one build; return True if its self-test passes."""
    target = Target(core=core)
    bench = replace(controller.bench, target=target)
    result = export(replace(controller, bench=bench), "c", number, report=True)
    assert result.target is not None
    place = folder / f"{number}-{core}"
    write(result.files, place)
    image = place / "selftest.elf"
    build_image(image, sorted(place.glob("*.c")), core)
    try:
        outcome = run_image(image).strip()
        passed = True
    except FrictoolError as error:
        outcome, passed = str(error), False
    figures = result.target
    print(
        f"{number:<8}{core:<12}{figures.code_bytes:>9}{figures.state_bytes:>11}"
        f"{figures.instructions:>14}  {outcome}",
        flush=True,
    )
    return passed


def timer_loop(folder: Path, controller: Controller) -> bool:
    """Run loop.c with the controller in float; return True if the axis reaches its reference."""
    place = folder / "loop"
    write(export(controller, "c", "float").files, place)
    image = place / "loop.elf"
    build_image(image, [HERE / "loop.c", place / "speed.c"], "cortex-m4f", "-I", str(place))
    try:
        print(run_image(image, "-icount", "shift=5").strip())
    except FrictoolError as error:
        print(error)
        return False
    return True


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
