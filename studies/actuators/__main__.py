"""Draws actuators and writes their documents.

    python -m studies.actuators COUNT --seed TEXT --documents FOLDER

Actuator N gets the folder FOLDER/N with bench.yaml, model.yaml, spec.yaml and steps.yaml.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from studies.actuators import documents
from studies.actuators.drawing import draw


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m studies.actuators", description=__doc__)
    parser.add_argument("count", type=int, metavar="COUNT", help="number of actuators")
    parser.add_argument("--seed", required=True, help="text that determines the actuators")
    parser.add_argument("--documents", type=Path, required=True, help="folder for the documents")
    given = parser.parse_args(arguments)
    for number in range(given.count):
        documents.write(draw(given.seed, number), given.documents / str(number))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
