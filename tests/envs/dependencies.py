"""The whole chain with the lowest and with the newest versions of the dependencies that
pyproject.toml allows."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import tempfile
import time
import tomllib
import venv
from pathlib import Path
from typing import Any

from tests.support.documentation_pages import ROOT, blocks
from tests.support.documentation_player import COMMENT, EXIT, scratch

# extras that no user installs; and mat-io, which needs more than frictool's lowest numpy and h5py
DEVELOPMENT = {"dev", "docs", "bench", "matlab"}
REQUIREMENT = re.compile(r"([\w.-]+)(?:\[[\w,]+\])?>=([\w.]+)")
CLUTCH = "configs/clutch"
FORMATS = ("csv", "mat", "mf4", "npz", "parquet")
FURTHER = (  # after the commands of the README
    f"frictool assess --bench {CLUTCH}/bench.yaml",
    f"frictool excite --bench {CLUTCH}/bench.yaml --kind sines -o build/excite.mcap --plot "
    "build/excite.svg",
    "frictool info build/sines.mcap",
    "frictool validate build/model.yaml build/sines.mcap --plot build/validate.svg",
    "frictool verify build/controller.yaml",
    f"frictool prove build/controller.yaml build/model.yaml --spec {CLUTCH}/spec.yaml "
    f"--scenario {CLUTCH}/scenarios/prove.yaml -o build/proof.yaml",
    *(f"frictool convert build/sines.mcap -o build/sines.{ending}" for ending in FORMATS),
    *(
        f"frictool ingest build/sines.{ending} --guess --axis rotary -o build/{ending}.yaml"
        for ending in FORMATS
    ),
    f"frictool plan {CLUTCH}/bench.yaml --spec {CLUTCH}/spec.yaml -o build/plan.mcap",
    "frictool export build/model.yaml --lang mjcf --without backlash -o build/mjcf --check "
    "build/sines.mcap",
    "frictool campaign build/model.yaml build/controller.yaml --scenario "
    f"{CLUTCH}/scenarios/steps.yaml --spec {CLUTCH}/spec.yaml "
    "-n 8 --cores 2 -o build/campaign.html",
    "frictool reduce configs/belt/mechanism.yaml --bandwidth 1000 -o build/belt.yaml",
    "frictool compare configs/mass/friction.yaml -o build/compare",
    f"frictool equations {CLUTCH}/mechanism.yaml",
    "frictool schema bench",
    "frictool completion bash",
    "frictool init build/rig --from sample_logs/sines.csv --axis rotary",
    "frictool doctor",
)
VERDICT = (
    f"frictool report build/run.mcap --spec {CLUTCH}/spec.yaml --controller "
    "build/controller.yaml --json"
)


def requirements() -> tuple[list[str], list[str]]:
    """Return the names of the extras that users install, and what the package and these extras
    require."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = {
        name: needs
        for name, needs in project["optional-dependencies"].items()
        if name not in DEVELOPMENT
    }
    return list(extras), [
        *project["dependencies"],
        *(one for needs in extras.values() for one in needs),
    ]


def lowest() -> list[str]:
    """Return the lowest version of each requirement, as pip's constraints. Raises ValueError where
    one has no lower bound."""
    found = []
    for one in requirements()[1]:
        match = REQUIREMENT.fullmatch(one)
        if match is None:
            raise ValueError(
                f"pyproject.toml: {one!r} has no lower bound alone; expected: NAME>=VERSION"
            )
        found.append(f"{match[1]}=={match[2]}")
    return found


def install(folder: Path, constraints: list[str]) -> Path:
    """Make a virtual environment with frictool from this clone and what it needs; return the folder
    of its programs."""
    venv.create(folder, with_pip=True, clear=True)
    limits = folder / "constraints.txt"
    limits.write_text("\n".join(constraints) + "\n")
    programs = folder / ("Scripts" if os.name == "nt" else "bin")
    named = f"{ROOT}[{','.join(requirements()[0])}]"
    words = [
        programs / "python",
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "-c",
        limits,
        "-e",
        named,
    ]
    subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True)
    return programs


def chain() -> list[str]:
    """Return the commands of the README and of FURTHER, with the exit code that each has to end
    with."""
    return [
        *(
            line
            for block in blocks(ROOT / "README.md", "sh")
            for text in block.lines
            for line in text.split(" && ")
        ),
        *FURTHER,
    ]


def run_chain(constraints: list[str]) -> dict[str, Any]:
    """Run the whole chain in an environment of these versions; passed where each command ends as it
    has to, without a traceback."""
    with tempfile.TemporaryDirectory() as name:
        folder, start = Path(name), time.perf_counter()
        try:
            programs = install(folder / "venv", constraints)
        except subprocess.CalledProcessError as error:
            return {"passed": False, "failed": ["pip install"], "end": error.stderr[-300:]}
        environment = {
            **os.environ,
            "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}",
            "NUMBA_CACHE_DIR": str(folder / "kernels"),
        }
        copy = folder / "clone"
        copy.mkdir()
        scratch(copy)
        failed, end = [], ""
        lines = chain()
        for line in lines:
            done = _run(line, copy, environment)
            expected = int(match[1]) if (match := EXIT.search(line)) else 0
            if done.returncode != expected or "Traceback" in done.stderr:
                failed.append(
                    f"{COMMENT.sub('', line)} ended with {done.returncode}, not {expected}"
                )
                end = done.stderr[-300:]
        judged = _run(VERDICT, copy, environment)
        verdict = json.loads(judged.stdout or "{}").get("verdict")
        seconds = round(time.perf_counter() - start, 1)
    return {
        "passed": not failed and verdict == "pass",
        "verdict": verdict,
        "commands": len(lines),
        "failed": failed,
        "end": end,
        "s": seconds,
    }


def _run(line: str, folder: Path, environment: dict[str, str]) -> subprocess.CompletedProcess[str]:
    words = shlex.split(COMMENT.sub("", line))
    return subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def lowest_versions() -> dict[str, Any]:
    return run_chain(lowest())


def newest_versions() -> dict[str, Any]:
    return run_chain([])


ENVIRONMENTS = {"lowest": lowest_versions, "newest": newest_versions}
