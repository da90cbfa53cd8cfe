"""Scores of identification methods on measured records of other people's machines.

    python -m studies.field FOLDER [PAGE]            make field

FOLDER contains the records of the manifest; a manifest.yaml in FOLDER replaces that of this
package. The table is printed and, with PAGE, written between the markers of this page. The exit
code is 3 if FOLDER contains no record of the manifest.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.errors import FrictoolError
from frictool.identify.motion_record import MotionRecord, record_of
from frictool.logs.channels.bench_match import match_bench
from frictool.logs.log_reader import read_log
from studies.field.manifest import Machine, bench_path, files_of, read_manifest
from studies.field.methods import MUJOCO, installed_methods
from studies.field.scores import MethodScore, scored
from studies.field.servo_rotation import rotation_lines

MISSING = "not installed (`pip install mujoco[sysid]`)"
BEGIN, END = "<!-- begin: make field -->", "<!-- end: make field -->"
HEAD = (
    "| machine | method | held-out force error | intervals that overlap | published inside "
    "| records refused |\n| --- | --- | --- | --- | --- | --- |"
)


def records_of(paths: list[Path], bench: Bench) -> list[MotionRecord]:
    """Return the records of files; raise LogError if one cannot be read."""
    return [record_of(match_bench(read_log(path, bench), bench), bench) for path in paths]


def divided(records: list[MotionRecord], parts: int) -> list[list[MotionRecord]]:
    """Divide every record into `parts` parts in time; return a list of records for each part."""
    edges = [
        np.linspace(0, record.position.size, parts + 1).astype(int).tolist() for record in records
    ]
    return [
        [
            record.part(slice(edge[part], edge[part + 1]))
            for record, edge in zip(records, edges, strict=True)
        ]
        for part in range(parts)
    ]


def score_machine(machine: Machine, folder: Path, home: Path) -> list[MethodScore] | str:
    """Return the scores of all methods on a machine, or the reason why it has none."""
    bench = load(bench_path(machine, home), Bench)
    groups = [files for patterns in machine.records if (files := files_of(patterns, folder))]
    if not groups:
        return "no record in this folder"
    try:
        units = [
            unit for files in groups for unit in divided(records_of(files, bench), machine.parts)
        ]
        wrong = [records_of([file], bench) for file in files_of(list(machine.refused), folder)]
    except FrictoolError as error:
        return str(error)
    return [
        scored(name, method, units, wrong, bench, machine.published)
        for name, method in installed_methods().items()
    ]


def row(machine: str, score: MethodScore) -> str:
    """Return the table row of a method on a machine."""
    cells = (
        machine,
        score.method,
        _percent(score.held_out),
        _percent(score.across),
        _of(score.published),
        _of(score.refused)
        + (f" + {_of(score.refused_rightly)}" if score.refused_rightly[1] else ""),
    )
    return f"| {' | '.join(cells)} |"


def _first_clause(reason: str) -> str:
    """Return the reason of a refusal without limits and advice."""
    return reason.partition(";")[0].partition(" (")[0]


def _percent(value: float | None) -> str:
    return "-" if value is None else f"{100.0 * value:.3g} %"


def _of(pair: tuple[int, int]) -> str:
    return f"{pair[0]} of {pair[1]}" if pair[1] else "-"


def table(folder: Path) -> list[str]:
    """Return the lines of the table; empty if no record of the manifest is in the folder."""
    manifest, home = read_manifest(folder)
    lines: list[str] = []
    reasons: list[str] = []
    for machine in manifest.machines:
        scores = score_machine(machine, folder, home)
        print(machine.name, file=sys.stderr)
        if isinstance(scores, str):
            reasons.append(f"- {machine.name}: {scores}")
            continue
        for score in scores:
            lines.append(row(machine.name, score))
            reasons += [
                f"- {machine.name}, {score.method}: {reason}"
                for reason in dict.fromkeys(_first_clause(one) for one in score.reasons)
            ]
    servos = rotation_lines(folder)
    if not lines:
        return servos
    missing = (
        [] if MUJOCO in installed_methods() else [f"| all | {MUJOCO} | {MISSING} |{' - |' * 3}"]
    )
    servos += [""] if servos else []
    return [HEAD, *lines, *missing, "", *servos, "Refusals and their reasons:", "", *reasons]


def main() -> int:
    """Print and write the table; return the exit code."""
    if len(sys.argv) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(sys.argv[1])
    lines = table(folder)
    if not lines:
        print(f"{folder} holds no record of the manifest; see docs/field.md", file=sys.stderr)
        return 3
    text = "\n".join(lines).replace(f"{folder}/", "")
    print(text)
    if len(sys.argv) == 3:
        page = Path(sys.argv[2])
        before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
        after = rest.partition(END)[2]
        page.write_text(f"{before}{BEGIN}\n{text}\n{END}{after}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
