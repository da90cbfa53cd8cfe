"""Does `identify` give what `assess` promises? Its proposed test is played on simulated clutches,
through the commands that a user gives.

    assess --json -> excite --kind sines -> simulated bench -> ingest -> identify --json

Each seed has its own noise, turns, encoder phase and its own axis, as in check_identify. Promised
is half of a 95 % interval: the errors of the records have to be within it at about that rate, and
their rms times 1.96 near it.
"""

from __future__ import annotations

import io
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.identify.assess.identifiability import CONFIDENCE, QUANTILE
from studies.command_line import run
from studies.rigs.identification_rigs import CLUTCH, clutch
from studies.rigs.sample_logs import NOISE, csv, play_reference
from tests.accept.check_identify import experiment

RECORDS = 200
DURATION = 30.0  # s, what assess and excite take where nobody says
CHANCE = 1e-3
PARAMETERS = ("inertia", "viscous", "coulomb")


def commanded(*arguments: str | Path) -> str:
    """What a command prints, which has to end well."""
    result = run(*arguments)
    if result.code != 0:
        raise RuntimeError(f"{' '.join(map(str, arguments))}: exit {result.code}: {result.stderr}")
    return result.stdout


def promised() -> dict[str, dict[str, Any]]:
    """What assess says of each parameter."""
    found = json.loads(commanded("assess", "--bench", CLUTCH, "--noise", str(NOISE), "--json"))
    return {row["parameter"]: row for row in found["parameters"]}


def identified(seed: int, folder: Path) -> tuple[dict[str, Any], dict[str, float]]:
    """What identify prints of the proposed test on the axis of a seed, and what that axis is."""
    truth, nominal = experiment(seed)[0], clutch().mechanics
    test = commanded("excite", "--bench", CLUTCH, "--kind", "sines", "--seed", str(seed), "-o", "-")
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
    commanded("ingest", raw, "--bench", CLUTCH, "-o", log)
    return json.loads(commanded("identify", log, "--bench", CLUTCH, "--json")), {
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


def kept() -> dict[str, Any]:
    """The inertia that differentiation is refused for, by the weak form, and friction by sines: all
    within what is promised."""
    rows, (errors, held) = promised(), outcomes(RECORDS)
    limits = np.array([rows[name]["precision"] for name in PARAMETERS])
    inside, reached = (
        np.sum(np.abs(errors) <= limits, axis=0),
        QUANTILE * np.sqrt(np.mean(errors**2, axis=0)),
    )
    least = int(binom.ppf(CHANCE, RECORDS, CONFIDENCE))
    methods = [rows[name]["method"] for name in PARAMETERS]
    out: dict[str, Any] = {
        "passed": methods == ["weak", "sines", "sines"]
        and bool(
            np.all(inside >= least)
            and np.all(held.sum(axis=0) >= least)
            and np.all(reached <= 1.2 * limits)
        ),
        "records": RECORDS,
        "inertia_by_differentiation": rows["inertia"]["bound"],
        "least_accepted": least,
    }
    for k, name in enumerate(PARAMETERS):
        out |= {
            f"{name}_promised": float(limits[k]),
            f"{name}_reached": float(reached[k]),
            f"{name}_inside": int(inside[k]),
        }
        out |= {
            f"{name}_mean_error": float(errors[:, k].mean()),
            f"{name}_interval_holds": int(held[:, k].sum()),
        }
    return out


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"assess: what it promises, identify gives": kept}
