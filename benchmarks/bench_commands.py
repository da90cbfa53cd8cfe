"""Processor time of commands, compared with a limit in units of an import of numpy.

command.NAME     median of the whole process, with compiled kernels
chain.demo       commands of `make demo`, run once with an empty kernel cache, without installation
chain.compile    part of chain.demo that is needed to compile kernels

The peer is the limit: a number of processes that import numpy. These processes are timed in turn
with the command.
"""

from __future__ import annotations

import functools
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
ROUNDS = 5
LOGS = ("build/sines.mcap", "build/ramp.mcap")
MODEL, CONTROLLER, RUN = "build/model.yaml", "build/controller.yaml", "build/run.mcap"
JUDGED = ("report", RUN, "--spec", "spec.yaml", "--controller", CONTROLLER)
STEPS = ("--scenario", "scenarios/steps.yaml")
# name -> (arguments, limit in imports of numpy; 0 without one), in the order of `make demo`
COMMANDS: dict[str, tuple[tuple[str, ...], float]] = {
    "ingest": (("ingest", "logs/ramp.csv", "--bench", "bench.yaml", "-o", LOGS[1]), 3.5),
    "ingest_sines": (("ingest", "logs/sines.csv", "--bench", "bench.yaml", "-o", LOGS[0]), 0.0),
    "identify": (("identify", *LOGS, "--bench", "bench.yaml", "-o", MODEL), 8.0),
    "synth": (
        ("synth", MODEL, "--spec", "spec.yaml", "--design", "designs/automatic.yaml", *STEPS,
         "-o", CONTROLLER),
        0.0,
    ),
    "simulate": (("simulate", MODEL, "--controller", CONTROLLER, *STEPS, "-o", RUN), 5.0),
    "report": ((*JUDGED, "-o", "build/report.html"), 9.0),
    "export": (("export", CONTROLLER, "--lang", "c", "-o", "build/c"), 0.0),
    "verify": (("verify", CONTROLLER), 0.0),
    "verdict": (JUDGED, 0.0),
    "info": (("info", LOGS[1]), 2.5),
    "info_csv": (("info", "logs/ramp.csv"), 4.0),
    "synth_vertices": (
        ("synth", MODEL, "--spec", "spec.yaml", "--design", "designs/speed.yaml",
         "--vertices-only", "--no-play", "-o", "build/vertices.yaml"),
        8.0,
    ),
}  # fmt: skip
DEMO = tuple(COMMANDS)[:9]
COMPILED_UNITS, DEMO_UNITS = 81.0, 220.0  # imports of numpy: 22 s and 60 s where one takes 0.27 s
IMPORT = (sys.executable, "-c", "import numpy")


class Chain:
    """Copy of the clutch's rig, and the first run of its commands, which compiles kernels.

    `first`: processor time of each command [s]. A command uses the kernels that earlier commands
        compiled.
    """

    def __init__(self) -> None:
        self._holder = tempfile.TemporaryDirectory()
        folder = Path(self._holder.name)
        self._rig = folder / "rig"
        shutil.copytree(ROOT / "configs" / "clutch", self._rig, ignore=lambda *_: {"build"})
        shutil.copytree(ROOT / "sample_logs", self._rig / "logs")
        (self._rig / "build").mkdir()
        self._environment = os.environ | {"NUMBA_CACHE_DIR": str(folder / "kernels")}
        # modules are compiled to files by the first run, as for a user
        self._environment.pop("PYTHONDONTWRITEBYTECODE", None)
        self.first = {name: self.cost(name) for name in COMMANDS}

    def cost(self, name: str) -> float:
        """Run a command; return its processor time [s]. Raises RuntimeError if it fails."""
        return self.spent((sys.executable, "-m", "frictool", *COMMANDS[name][0]))

    def spent(self, command: tuple[str, ...]) -> float:
        """Run a process; return its processor time [s]."""
        before = os.times()
        done = subprocess.run(
            command, cwd=self._rig, env=self._environment, capture_output=True, text=True
        )
        after = os.times()
        if done.returncode not in (0, 1):  # 1: the answer is no
            raise RuntimeError(f"{' '.join(command)}: {done.stderr}")
        return (
            after.children_user + after.children_system
            - before.children_user - before.children_system
        )  # fmt: skip

    @functools.cached_property
    def unit(self) -> float:
        """Return the median processor time of an import of numpy [s]."""
        return statistics.median(self.spent(IMPORT) for _ in range(2 * ROUNDS))

    @functools.cache  # noqa: B019  # one chain for all rows
    def warm(self, name: str) -> tuple[float, float]:
        """Return the median processor times [s] of a command and of imports in turn with it."""
        pairs = [(self.cost(name), self.spent(IMPORT)) for _ in range(ROUNDS)]
        ours, imports = zip(*pairs, strict=True)
        return statistics.median(ours), statistics.median(imports)


@functools.cache
def chain() -> Chain:
    """Return the chain, which is run once for all rows."""
    return Chain()


def _against(identity: str, ours: float, unit: float, limit: float) -> dict[str, Any]:
    return {
        "id": identity,
        "peer": f"limit: {limit:g} x import numpy",
        "ours": ours,
        "theirs": limit * unit,
        "unit": "s of processor time",
        "ratio": limit * unit / ours,
        "accuracy": f"{ours / unit:.3g} imports of {unit:.2f} s",
    }


def _command(name: str, limit: float) -> Callable[[], dict[str, Any]]:
    def row() -> dict[str, Any]:
        ours, unit = chain().warm(name)
        return _against(f"command.{name}", ours, unit, limit)

    row.id = f"command.{name}"  # type: ignore[attr-defined]  # read by benchmarks/__main__.py
    return row


def chain_compile() -> dict[str, Any]:
    """Return the row of the time in which the commands of `make demo` compile kernels."""
    made = chain()
    compiled = sum(made.first[name] - made.warm(name)[0] for name in DEMO)
    return _against("chain.compile", compiled, made.unit, COMPILED_UNITS)


def chain_demo() -> dict[str, Any]:
    """Return the row of the commands of `make demo` with an empty kernel cache."""
    made = chain()
    return _against("chain.demo", sum(made.first[name] for name in DEMO), made.unit, DEMO_UNITS)


ROWS = [
    *(_command(name, limit) for name, (_, limit) in COMMANDS.items() if limit),
    chain_compile,
    chain_demo,
]
