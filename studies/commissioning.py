"""Commissioning of random actuators with `plan` on a simulated bench, with a judged controller.

    python -m studies.commissioning COUNT --seed TEXT

The true plant is drawn inside the bench's ranges; frictool does not read it. The commands are those
of a user:

    frictool plan bench.yaml --spec spec.yaml [LOG...] -o test.mcap --model identified.yaml
    frictool simulate --as-bench truth.yaml test.mcap -o log.mcap      (until `plan` says enough)
    frictool synth identified.yaml --spec spec.yaml --vertices-only -o controller.yaml
    frictool export controller.yaml --lang c -o c

The controller is judged like those of studies.actuators: its exported C on 56 plants of the
ranges. A refusal is right only if the judge's search finds no controller either.
"""

from __future__ import annotations

import argparse
import json
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

MOST_TESTS = 8
TRUTH = -1  # index of the true plant among the drawn ones: inside the ranges
NOISE = 0.02  # largest noise of a measured drive divided by its limit: ten standard deviations
RIGHT = "met", "refused like the search"  # correct outcomes


@dataclass(frozen=True)
class Commissioning:
    """Outcome of one actuator.

    - outcome: one of RIGHT, or the failure
    - tests, bench_s: number of tests and their duration together [s]
    - broken: limits of the bench that a test exceeded
    """

    number: int
    actuator: str
    outcome: str
    tests: int
    bench_s: float
    broken: tuple[str, ...]

    def row(self) -> str:
        """Return the row of the table."""
        limits = f", broke {', '.join(self.broken)}" if self.broken else ""
        return (
            f"{self.number:>4}  {self.outcome}{limits}; {self.tests} tests, {self.bench_s:.0f} s; "
            f"{self.actuator}"
        )


def commission(seed: str, number: int) -> Commissioning:
    """Commission one actuator of a seed; return the outcome."""
    actuator = draw(seed, number)
    plants = draw_plants(actuator, seed)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        documents.write(actuator, folder)
        (folder / "truth.yaml").write_text(yaml.safe_dump(truth(actuator, plants[TRUTH])))
        logs: list[Path] = []
        planned = _planned(folder, logs)
        while planned.code == 0 and not _enough(planned) and len(logs) < MOST_TESTS:
            log = folder / f"log{len(logs)}.mcap"
            run_checked(
                "simulate", "--as-bench", folder / "truth.yaml", folder / "test.mcap", "-o", log
            )
            logs.append(log)
            planned = _planned(folder, logs)
        outcome = (
            _designed(actuator, seed, folder)
            if planned.code == 0 and _enough(planned)
            else _refused(actuator, plants, planned)
        )
        played = [read_log(log).streams[0] for log in logs]
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
        )


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


def _enough(planned: CommandResult) -> bool:
    return bool(json.loads(planned.out)["enough"])


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
    reason = planned.stderr.strip() or json.loads(planned.out)["why"]
    return f"refused, but the search finds a controller: {reason}"


def broken_limits(actuator: Actuator, position: Vector, drive: Vector) -> Iterator[str]:
    """Yield the limits of the bench that a log exceeds by more than a count and the noise."""
    step = actuator.encoder_step
    if np.min(position) < -step or np.max(position) > actuator.travel + step:
        yield "travel"
    if np.max(np.abs(drive)) > actuator.limit * (1.0 + NOISE):
        yield "drive limit"


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
    given = parser.parse_args(arguments)
    rows = []
    for number in range(given.first, given.first + given.count):
        rows.append(commission(given.seed, number))
        print(rows[-1].row(), flush=True)
    for name, value in summary(rows).items():
        print(f"{name:<22}{value:g}")
    return 0


def summary(rows: Sequence[Commissioning]) -> dict[str, float]:
    """Return counts, and the median duration on the bench [s]."""
    return {
        "actuators": len(rows),
        "right": sum(row.outcome in RIGHT for row in rows),
        "met": sum(row.outcome == RIGHT[0] for row in rows),
        "broken_limits": sum(len(row.broken) for row in rows),
        "median_tests": float(np.median([row.tests for row in rows])),
        "median_bench_s": float(np.median([row.bench_s for row in rows])),
    }


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
