"""Compiled C of the judge and of exported controllers, called through ctypes.

`axis.c` and `cascade.c` are compiled once into build/actuators/; the file name contains the digest
of their text. A few additional lines give the functions of an exported controller fixed names.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from frictool.typing import Vector

FOLDER = Path(__file__).parent
SOURCES = ("axis.c", "figures.c", "cascade.c")
CACHE = Path(__file__).parents[2] / "build/actuators"
OPTIONS = ("-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off")
STATES = 8  # last fields of cascade.c's record
ADAPTER = """#include "{name}.h"
unsigned long judged_size(void) {{ return sizeof({name}_state); }}
void judged_init(void *state, double position) {{ {name}_init(state, position); }}
double judged_step(void *state, double reference, double position)
{{ return {name}_step(state, reference, position); }}
"""
SETTER = "void judged_set_{key}(void *state, double value) {{ {name}_set_{key}(state, value); }}\n"


class Controller(NamedTuple):
    """Compiled controller: addresses of its functions, and its state before `init`."""

    init: Any
    step: Any
    state: bytes
    setters: Mapping[str, Any]  # of the scheduled parameters, by name


@cache
def judge_library() -> ctypes.CDLL:
    """Return the compiled axis, figures and cascade."""
    texts = [(FOLDER / name).read_text() for name in SOURCES]
    digest = hashlib.sha256("".join([*OPTIONS, *texts]).encode()).hexdigest()[:16]
    library = CACHE / f"judge-{digest}.so"
    if not library.is_file():
        CACHE.mkdir(parents=True, exist_ok=True)
        part = library.with_suffix(f".{os.getpid()}")
        compile_library([FOLDER / name for name in SOURCES], part)
        part.replace(library)
    loaded = ctypes.CDLL(str(library))
    number, address, count = ctypes.c_double, ctypes.c_void_p, ctypes.c_int
    loaded.axis_move.argtypes = [address, address, number, number]
    loaded.axis_run.argtypes = [address, address, count, *[address] * 5]
    loaded.hold_figures.argtypes = [address, address, count, *[number] * 3, count, address]
    loaded.hold_figures.restype = None
    loaded.cascade_init.argtypes = [address, number]
    return loaded


def compile_library(sources: list[Path], target: Path) -> None:
    """Compile C sources to a shared library; raises RuntimeError with the compiler's message."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        raise RuntimeError("the judge needs a C compiler: cc or gcc on the PATH")
    command = [compiler, *OPTIONS, *map(str, sources), "-lm", "-o", str(target)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{compiler} ended with {done.returncode}: {done.stderr}")


def load_exported(folder: Path) -> Controller:
    """Compile and return the controller that `frictool export --lang c` wrote into `folder`."""
    (header,) = (path for path in folder.glob("*.h") if not path.stem.endswith("_vectors"))
    name, text = header.stem, header.read_text()
    keys = re.findall(rf"^void {name}_set_(\w+)\([^)]*, double", text, re.MULTILINE)
    with tempfile.TemporaryDirectory() as place:
        adapter, target = folder / "judged_adapter.c", Path(place) / "controller.so"
        lines = [ADAPTER.format(name=name), *(SETTER.format(name=name, key=key) for key in keys)]
        adapter.write_text("".join(lines))
        compile_library([folder / f"{name}.c", adapter], target)
        library = ctypes.CDLL(str(target))  # stays mapped when the file is removed
    library.judged_size.restype = ctypes.c_ulong
    setters = {key: getattr(library, f"judged_set_{key}") for key in keys}
    for function in setters.values():
        function.argtypes = [ctypes.c_void_p, ctypes.c_double]
    library.judged_init.argtypes = [ctypes.c_void_p, ctypes.c_double]
    return Controller(
        library.judged_init, library.judged_step, bytes(library.judged_size()), setters
    )


def cascade(parameters: Vector) -> Controller:
    """Return the controller of cascade.c; `parameters` (12,) are the first fields of its record."""
    library = judge_library()
    state = np.concatenate([parameters, np.zeros(STATES)])
    return Controller(library.cascade_init, library.cascade_step, state.tobytes(), {})
