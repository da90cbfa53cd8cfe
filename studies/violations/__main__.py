"""Identification of machines that violate the model, with a table of the coverage of intervals.

    python -m studies.violations N --seed TEXT
    python -m studies.violations N --seed TEXT --family belt --method least-squares
    python -m studies.violations N --seed TEXT --documents FOLDER

Each of the 18 families has N records, from mild to gross violations, and a row of the table. For
inertia, viscous friction, Coulomb friction and offset, the columns are

- the number of intervals that contain the true value
- the number of judged intervals
- the median half width divided by the rms error

The other columns are

- the share of records with a warning, of all records and of the mild ones
- the share of records with a false load, knee or resonance
- the number of refused parameters
- the median processor time of an identification [s]

With --documents, the log, the bench and the truth of record K of a family are written to
FOLDER/FAMILY/K, and nothing is identified.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from pathlib import Path

from studies.violations.families import FAMILIES, draw_violation
from studies.violations.judgement import PARAMETERS, FamilySummary, judge, pooled, summary
from studies.violations.recording import record

HEADER = (
    f"{'family':<16}"
    + "".join(f"{name:>9} {'ratio':>5}" for name in PARAMETERS)
    + f"{'warned':>8}{'mild':>6}{'false':>7}{'refused':>9}{'s':>6}"
)


def row(one: FamilySummary) -> str:
    """Return the row of a family."""
    cells = "".join(
        f"{'{}/{}'.format(*one.held[name]):>9} {one.ratio[name]:5.2f}" for name in PARAMETERS
    )
    return (
        f"{one.family:<16}{cells}{one.warned:>8.0%}{one.mild_warned:>6.0%}{one.false:>7.0%}"
        f"{one.refused:>9}{one.seconds:>6.2f}"
    )


def main(arguments: list[str]) -> int:
    """Print the table, or write the documents; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m studies.violations",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("count", type=int, metavar="N", help="records of each family")
    parser.add_argument("--seed", required=True, help="text that determines the machines")
    parser.add_argument("--family", action="append", choices=FAMILIES, help="only this family")
    parser.add_argument("--method", default="auto", help="method of identify (auto)")
    output = parser.add_mutually_exclusive_group()
    output.add_argument("-o", "--output", type=Path, help="JSON file with a line for each record")
    output.add_argument("--documents", type=Path, help="folder for logs, benches and truths")
    given = parser.parse_args(arguments)
    families = given.family or list(FAMILIES)
    if given.documents:
        for family in families:
            for number in range(given.count):
                name = f"{given.seed}/{family}/{number}"
                machine = draw_violation(given.seed, family, number)
                record(machine, name).write(given.documents / family / str(number))
        return 0
    print(HEADER)
    summaries, verdicts = [], []
    for family in families:
        of_family = [
            judge(given.seed, family, number, given.method) for number in range(given.count)
        ]
        verdicts += of_family
        summaries.append(summary(family, of_family))
        print(row(summaries[-1]), flush=True)
    print(f"intervals that hold the truth, all together: {pooled(summaries):.1%}")
    if given.output:
        lines = [json.dumps(dataclasses.asdict(one)) for one in verdicts]
        given.output.write_text("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
