"""Commissioning of random actuators with `plan` on a simulated bench, with a judged controller.

    python -m studies.commissioning COUNT --seed TEXT -o rows.json

The true plant is drawn inside the bench's ranges; frictool does not read it. The commands are those
of a user:

    frictool plan bench.yaml --spec spec.yaml [LOG...] -o test.mcap --model identified.yaml
    frictool simulate --as-bench truth.yaml test.mcap -o log.mcap
    frictool synth identified.yaml --spec spec.yaml --vertices-only -o controller.yaml
    frictool export controller.yaml --lang c -o c

The first two commands are repeated until `plan` proposes no further test. The test for validation,
which `plan` writes at the end, is played as well. The controller is judged like those of
studies.actuators: its exported C on 56 plants of the ranges. If `plan` or `synth` refuses, the
refusal is right only if the judge's search finds no controller either. The results are kept in
rows.json; the same command continues after an interruption.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from frictool.logs.log_reader import read_log
from frictool.typing import Vector
from studies.actuators import documents
from studies.actuators.drawing import Actuator, Plant, draw, draw_plants
from studies.actuators.search import search
from studies.actuators.trial import describe, verdict_of
from studies.command_line import CommandResult, run, run_checked
from studies.kept_results import kept_results

MOST_TESTS = 8
TRUTH = -1  # index of the true plant among the drawn ones: inside the ranges
NOISE = 0.02  # largest noise of a measured drive divided by its limit: ten standard deviations
SPEED_COUNTS = 20  # distance in counts over which the speed of a log is averaged
RIGHT = "met", "refused like the search"  # correct outcomes
REFUSALS = 1, 4  # exit codes with which `plan` answers that it proposes no test


@dataclass(frozen=True)
class Commissioning:
    """Outcome of one actuator.

    - outcome: one of RIGHT, or the failure
    - tests, bench_s: number of tests and their duration together [s]
    - broken: limits of the bench that a test exceeded
    - processor_s: processor time of all commands, of the judge and of its search [s]
    """

    number: int
    actuator: str
    outcome: str
    tests: int
    bench_s: float
    broken: Sequence[str]
    processor_s: float = math.nan

    def row(self) -> str:
        """Return the row of the table."""
        limits = f", broke {', '.join(self.broken)}" if self.broken else ""
        return (
            f"{self.number:>4}  {self.outcome}{limits}; {self.tests} tests, {self.bench_s:.0f} s; "
            f"{self.processor_s:.0f} s of processor time; {self.actuator}"
        )


def commission(seed: str, number: int) -> Commissioning:
    """Commission one actuator of a seed; return the outcome, also after an unexpected error."""
    actuator = draw(seed, number)
    before = _processor_time()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        try:
            outcome = _outcome(actuator, seed, folder)
        except Exception as error:
            outcome = f"crashed: {type(error).__name__}: {error}"
        played = [read_log(log).streams[0] for log in sorted(folder.glob("log*.mcap"))]
    return Commissioning(
        number,
        describe(actuator),
        outcome,
        len(played),
        float(sum(one.time[-1] - one.time[0] for one in played)),
        tuple(
            name
            for one in played
            for name in broken_limits(
                actuator, one.signals["position"], one.signals[actuator.drive]
            )
        ),
        _processor_time() - before,
    )


def _outcome(actuator: Actuator, seed: str, folder: Path) -> str:
    """Play the tests of `plan` until it proposes none; return the outcome as text."""
    plants = draw_plants(actuator, seed)
    documents.write(actuator, folder)
    (folder / "truth.yaml").write_text(yaml.safe_dump(truth(actuator, plants[TRUTH])))
    logs: list[Path] = []
    while True:
        planned = _planned(folder, logs)
        if planned.code in REFUSALS:
            return _refused(actuator, plants, planned)
        if planned.code != 0:
            return f"plan ends with {planned.code}: {planned.stderr.strip()}"
        step = json.loads(planned.out)
        if step["test"] is not None:
            logs.append(_played(folder, len(logs)))
        if step["enough"]:
            return _designed(actuator, seed, folder)
        if len(logs) == MOST_TESTS:
            return f"no end after {MOST_TESTS} tests: {step['why']}"


def _played(folder: Path, number: int) -> Path:
    """Play the test in the folder on the true plant, with new noise; return the log."""
    log = folder / f"log{number}.mcap"
    run_checked(
        "simulate", "--as-bench", folder / "truth.yaml", folder / "test.mcap", "-o", log,
        "--seed", number,
    )  # fmt: skip
    return log


def _processor_time() -> float:
    """Return the processor time of this process and of its ended children [s]."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def truth(actuator: Actuator, plant: Plant) -> dict[str, Any]:
    """Return the model document of a plant, with the true constant of its drive."""
    model = documents.model(actuator)
    for name in ("inertia", "viscous", "coulomb"):
        unit = model["parameters"][name]["unit"]
        value = getattr(plant, name)
        model["parameters"][name] = {"value": value, "unit": unit, "source": "identified"}
    model["parameters"]["breakaway"]["value"] = actuator.breakaway_ratio * plant.coulomb
    drive = model["bench"]["actuator"]
    drive["constant"] = {"value": plant.constant, "unit": drive["constant"]["unit"]}
    return model


def _planned(folder: Path, logs: Sequence[Path]) -> CommandResult:
    """Run `plan`, which replaces the last test by the next one, and return its result."""
    return run(
        "plan", folder / "bench.yaml", "--spec", folder / "spec.yaml", *logs,
        "-o", folder / "test.mcap", "--model", folder / "identified.yaml", "--json",
    )  # fmt: skip


def _designed(actuator: Actuator, seed: str, folder: Path) -> str:
    """Design a controller for the identified model; return the outcome as text."""
    controller = folder / "controller.yaml"
    designed = run(
        "synth", folder / "identified.yaml", "--spec", folder / "spec.yaml", "--vertices-only",
        "-o", controller,
    )  # fmt: skip
    if designed.code != 0:
        return f"plan says enough, synth ends with {designed.code}"
    run_checked("export", controller, "--lang", "c", "-o", folder / "c")
    verdict = verdict_of(actuator, seed, folder)
    missed = [name for name, met in verdict.met.items() if not met]
    return f"missed: {', '.join(missed)}" if missed else RIGHT[0]


def _refused(actuator: Actuator, plants: Sequence[Plant], planned: CommandResult) -> str:
    if not search(actuator, tuple(plants)).solved:
        return RIGHT[1]
    reason = json.loads(planned.out)["why"] if planned.out else planned.stderr.strip()
    return f"refused, but the search finds a controller: {reason}"


def broken_limits(actuator: Actuator, position: Vector, drive: Vector) -> Iterator[str]:
    """Yield the limits of the bench that a log exceeds: travel, top speed, drive limit.

    The ends of the travel have stops. An axis whose reading is within a count of an end has touched
    the stop, or come near to it. The speed is a mean over SPEED_COUNTS or more.
    """
    step = actuator.encoder_step
    if np.min(position) < step or np.max(position) > actuator.travel - step:
        yield "travel"
    for samples in 2 ** np.arange(int(np.log2(position.size))):
        fastest = np.max(np.abs(position[samples:] - position[:-samples]))
        if fastest >= SPEED_COUNTS * step:
            if (fastest - step) / (samples * actuator.period) > documents.top_speed(actuator):
                yield "top speed"
            break
    if np.max(np.abs(drive)) > actuator.limit * (1.0 + NOISE):
        yield "drive limit"


def commissionings(
    seed: str, numbers: Sequence[int], kept: Path, cores: int = 1
) -> Iterator[Commissioning]:
    """Yield the outcomes of actuators of a seed as they end; those in the file `kept` first."""
    yield from kept_results(seed, numbers, kept, commission, Commissioning, cores)


def main(arguments: list[str]) -> int:
    """Print the table and the summary; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m studies.commissioning",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("count", type=int, metavar="COUNT", help="number of actuators")
    parser.add_argument("--seed", required=True, help="text that determines the actuators")
    parser.add_argument("--first", type=int, default=0, help="first actuator (0)")
    parser.add_argument("--cores", type=int, default=1, help="number of processes (1)")
    parser.add_argument("-o", "--output", type=Path, required=True, help="file of the results")
    given = parser.parse_args(arguments)
    rows = []
    numbers = range(given.first, given.first + given.count)
    for one in commissionings(given.seed, numbers, given.output, given.cores):
        rows.append(one)
        print(one.row(), flush=True)
    for name, value in summary(rows).items():
        print(f"{name:<22}{value:g}")
    return 0


def summary(rows: Sequence[Commissioning]) -> dict[str, float]:
    """Return counts, totals and medians; durations on the bench and processor times in s."""
    return {
        "actuators": len(rows),
        "right": sum(row.outcome in RIGHT for row in rows),
        "met": sum(row.outcome == RIGHT[0] for row in rows),
        "broken_limits": sum(len(row.broken) for row in rows),
        "median_tests": float(np.median([row.tests for row in rows])),
        "median_bench_s": float(np.median([row.bench_s for row in rows])),
        "tests": sum(row.tests for row in rows),
        "bench_s": sum(row.bench_s for row in rows),
        "median_processor_s": float(np.median([row.processor_s for row in rows])),
    }


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
