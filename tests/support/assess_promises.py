"""Precision that `assess` promises, and the errors of `identify` on the test that `excite`
proposes."""

from __future__ import annotations

import io
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from studies.command_line import run_checked
from studies.rigs.identification_rigs import CLUTCH, clutch
from studies.rigs.sample_logs import NOISE, csv, play_reference
from tests.support.identification_statistics import experiment

DURATION = 30.0  # s, what assess and excite take where nobody says
PARAMETERS = ("inertia", "viscous", "coulomb")


def promised() -> dict[str, dict[str, Any]]:
    """Return the row of each parameter in the report of `assess`."""
    found = json.loads(run_checked("assess", "--bench", CLUTCH, "--noise", str(NOISE), "--json"))
    return {row["parameter"]: row for row in found["parameters"]}


def identified(seed: int, folder: Path) -> tuple[dict[str, Any], dict[str, float]]:
    """Return the output of `identify` on the proposed test of a seed's axis, and the true values of
    that axis."""
    truth, nominal = experiment(seed)[0], clutch().mechanics
    test = run_checked(
        "excite", "--bench", CLUTCH, "--kind", "sines", "--seed", str(seed), "-o", "-"
    )
    _, reference, velocity, acceleration = np.loadtxt(
        io.StringIO(test), delimiter=",", skiprows=1, unpack=True
    )
    forward = (
        nominal.inertia.value * acceleration + nominal.viscous.value * velocity
    ) / truth.constant
    raw, log = folder / "sines.csv", folder / "sines.mcap"
    raw.write_text(
        csv(play_reference(reference, velocity, forward, np.random.default_rng([seed, 17]), truth)),
        newline="\n",
    )
    run_checked("ingest", raw, "--bench", CLUTCH, "-o", log)
    return json.loads(run_checked("identify", log, "--bench", CLUTCH, "--json")), {
        name: getattr(truth, name) for name in PARAMETERS
    }


def outcomes(
    records: int,
) -> tuple[
    np.ndarray[tuple[int, ...], np.dtype[np.float64]],
    np.ndarray[tuple[int, ...], np.dtype[np.bool_]],
]:
    """Relative errors (records, 3), nan where a parameter is refused, and whether the interval
    holds the truth."""
    errors, held = (
        np.full((records, len(PARAMETERS)), np.nan),
        np.zeros((records, len(PARAMETERS)), dtype=np.bool_),
    )
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(records):
            found, truth = identified(seed, Path(folder))
            for k, name in enumerate(PARAMETERS):
                interval = found["parameters"].get(name)
                if interval is not None:
                    errors[seed, k] = interval["value"] / truth[name] - 1.0
                    held[seed, k] = interval["low"] <= truth[name] <= interval["high"]
    return errors, held
