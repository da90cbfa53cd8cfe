"""Design of controllers for random actuators with frictool, and an independent judgement.

    python -m studies.actuators COUNT --seed TEXT -o table.json
    python -m studies.actuators COUNT --seed TEXT --documents FOLDER

The table has a row for each actuator, with

- the verdict of synth, and the verdict of the judge on all plants
- the number of candidates of the judge's search, and the processor time of synth
- the worst value of each requirement divided by its limit, with ! if the requirement is not met

Trials are kept in table.json.trials; the same command continues after an interruption. With
--documents, the documents of actuator N are written to FOLDER/N, and nothing is designed.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from studies.actuators import documents
from studies.actuators.drawing import draw
from studies.actuators.table import HEADER, row, run_trials, write_table
from studies.actuators.trial import summary


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m studies.actuators",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("count", type=int, metavar="COUNT", help="number of actuators")
    parser.add_argument("--seed", required=True, help="text that determines the actuators")
    parser.add_argument("--cores", type=int, default=1, help="number of processes (1)")
    output = parser.add_mutually_exclusive_group(required=True)
    output.add_argument("-o", "--output", type=Path, help="JSON file to write")
    output.add_argument("--documents", type=Path, help="folder for the documents")
    given = parser.parse_args(arguments)
    if given.documents:
        for number in range(given.count):
            documents.write(draw(given.seed, number), given.documents / str(number))
        return 0
    kept, trials = given.output.with_name(f"{given.output.name}.trials"), []
    print(HEADER)
    for trial in run_trials(given.seed, given.count, kept, given.cores):
        trials.append(trial)
        print(row(trial), flush=True)
        print(f"{len(trials)} of {given.count} actuators", file=sys.stderr)
    write_table(given.seed, trials, given.output)
    for name, value in summary(trials).items():
        print(f"{name:<22}{value:g}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
