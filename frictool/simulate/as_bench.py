"""Reader of test signals for a simulated bench: files of `frictool excite`, and CSV files."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.quantity import si_unit
from frictool.errors import LogError
from frictool.logs.log import EXCITATION, MAIN_TOPIC, Log, Stream
from frictool.simulate.bench_experiment import read_excitation
from frictool.simulate.default_servo import FEEDFORWARD

# columns of a CSV file with a reference, and their dimensions
COLUMNS = {"reference": "position", "reference_velocity": "velocity", FEEDFORWARD: "effort"}
TIME = "time [s]"
CSV = ".csv"


def read_test(path: Path, bench: Bench) -> Log:
    """Return the test signals in the file `path`, written by `frictool excite` or as CSV.

    A CSV file must have columns for the time and the position reference. Columns for the velocity
    of the reference and for a feedforward effort are optional.

    Raises
    ------
    LogError
        If the file contains no test signals, or if the file is a CSV file with drive ramps. (A CSV
        file does not state at which position a ramp ends.)
    """
    if path.suffix.lower() != CSV:
        return read_excitation(path)
    with path.open(encoding="utf-8", newline="") as stream:
        head = next(csv.reader(stream), [])
        try:
            rows = np.loadtxt(stream, delimiter=",", ndmin=2)
        except ValueError as error:
            raise LogError(str(path), f"is not a table of numbers: {error}") from None
    if rows.shape[0] < 2 or rows.shape[1] != len(head) or not np.all(np.isfinite(rows)):
        raise LogError(
            str(path), "needs at least 2 rows, a name for each column, and finite numbers only"
        )
    table = dict(zip(head, rows.T, strict=True))
    wanted = {
        name: f"{name} [{si_unit(dimension, bench.axis)}]" for name, dimension in COLUMNS.items()
    }
    if TIME not in table or wanted["reference"] not in table:
        raise LogError(
            str(path),
            f"has the columns {', '.join(head)}; a CSV test needs {TIME} and "
            f"{wanted['reference']}; write a test with ramps as MCAP: frictool excite -o NAME.mcap",
        )
    columns = {name: table[label] for name, label in wanted.items() if label in table}
    units = {name: si_unit(COLUMNS[name], bench.axis) for name in columns}
    test = Stream(MAIN_TOPIC, table[TIME], columns, units)
    return Log((test,), {EXCITATION: {"kind": path.stem}}, str(path))
