"""Rigs of `frictool init --example`: documents of configs/, and logs in the format of a bench.

    python -m studies.rigs.example_rigs           writes frictool/documents/examples

    clutch   documents of configs/clutch, logs of sample_logs (all simulated)
    emps     documents of configs/emps; sines and ramps simulated with the published parameters
    joint    a joint with 2000 counts a turn, whose recorder writes German headers, semicolons and
             decimal commas; simulated with TRUTH

Each log is compressed with xz; `init` decompresses it.
"""

from __future__ import annotations

import lzma
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from frictool.logs import read_log
from frictool.logs.log import Log
from studies.command_line import run_checked

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "frictool/documents/examples"
DOCUMENTS = {"bench.yaml", "spec.yaml", "designs/speed.yaml", "scenarios/steps.yaml"}
TRUTH = """\
parameters:
  inertia: {value: 2.61e-3, unit: kg m^2, source: identified}
  viscous: {value: 0.0123, unit: N m s/rad, source: identified}
  coulomb: {value: 0.134, unit: N m, source: identified}
  breakaway: {value: 0.157, unit: N m, source: identified}
  offset: {value: 0.011, unit: N m, source: identified}
"""
HEAD = """\
format: model/1
name: joint
axis: rotary
law: coulomb
method: published
confidence: 0.95
provenance: {command: studies/rigs/example_rigs.py, frictool: 0.1.0}
"""


def write_examples() -> None:
    """Write the documents and logs of all examples."""
    for name in ("clutch", "emps"):
        for document in DOCUMENTS:
            shutil.copyfile(ROOT / "configs" / name / document, EXAMPLES / name / document)
    for log in ("sines", "ramp"):
        _write("clutch", log, (ROOT / f"sample_logs/{log}.csv").read_text())
    with tempfile.TemporaryDirectory() as folder:
        _play("emps", ROOT / "configs/emps/published.yaml", Path(folder), emps_text)
        truth = Path(folder) / "truth.yaml"
        bench = (EXAMPLES / "joint/bench.yaml").read_text()
        indented = "".join(f"  {line}\n" for line in bench.splitlines())
        truth.write_text(f"{HEAD}bench:\n{indented}{TRUTH}")
        _play("joint", truth, Path(folder), joint_text)


def _play(name: str, truth: Path, folder: Path, text_of: Callable[[Log], str]) -> None:
    """Write the logs of sines and of ramps, each played as the bench would."""
    bench = EXAMPLES / name / "bench.yaml"
    for log, kind in (("sines", "sines"), ("ramp", "breakaway")):
        test, played = folder / f"{log}.mcap", folder / f"{log}_log.mcap"
        run_checked("excite", "--bench", bench, "--kind", kind, "-o", test)
        run_checked("simulate", "--as-bench", truth, test, "-o", played)
        _write(name, log, text_of(read_log(played)))


def emps_text(log: Log) -> str:
    """Return a log with the columns of configs/emps/bench.yaml: s, m, V."""
    signals = log.main.signals
    reference = signals.get("reference", signals["position"])
    rows = zip(log.main.time, signals["position"], reference, signals["voltage"], strict=True)
    return "t,qm,qg,vir\n" + "".join(
        f"{time:.3f},{position:.8f},{wanted:.8f},{voltage:.4f}\n"
        for time, position, wanted, voltage in rows
    )


def joint_text(log: Log) -> str:
    """Return a log in the format of a German recorder: ms, counts, mA."""
    counts = np.rint(log.main.signals["position"] / (2.0 * np.pi / 2000.0)).astype(int)
    rows = zip(log.main.time, counts, log.main.signals["current"], strict=True)
    return "Zeit [ms];Geber;Motorstrom [mA]\n" + "".join(
        f"{1e3 * time:.1f};{count};{1e3 * current:.1f}\n".replace(".", ",")
        for time, count, current in rows
    )


def _write(name: str, log: str, text: str) -> None:
    path = EXAMPLES / name / f"logs/{log}.csv.xz"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(lzma.compress(text.encode(), preset=9 | lzma.PRESET_EXTREME))


if __name__ == "__main__":
    write_examples()
