"""Score of servo models on the pendulum records: fit four trajectories, predict the fifth, rotate.

The score is the mean over the records of the mean |simulated - measured position|, rad, from goal,
gain and supply voltage, from the first sample at rest, without a restart. BAM's published M6 was
fitted to records of all five trajectories; its supply is the record's `vin` (15 V) and, in a second
row, the measured voltage (about 12 V).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.registry import load
from frictool.errors import FrictoolError
from frictool.identify.from_logs import identify
from frictool.identify.validate.validation import ValidationRequest, validate
from frictool.logs.log import Log
from frictool.logs.log_reader import read_log
from frictool.typing import Vector
from studies.field.bam_m6 import FIRMWARE, WEIGHT, parameters, simulated
from studies.field.manifest import HERE

FOLDER = "kscale_sts3215"
BENCH = HERE / "benches" / "kscale_sts3215.yaml"
PUBLISHED = "STS_3215_12V_20250317_friction_params_m6.json"
TRAJECTORIES = ("brutal", "lift_and_drop", "sin_sin", "sin_time_square", "up_and_down")
STATED_SUPPLY = 15.0  # V, key `vin` of the records
UNSKIPPED = ValidationRequest(skip=0, cutoff_hz=10.0)
HEAD = (
    f"| servo, mean error on unseen trajectories [rad] | {' | '.join(TRAJECTORIES)} | score |\n"
    f"| --- |{' --- |' * len(TRAJECTORIES)} --- |"
)


def record_files(folder: Path, trajectory: str) -> list[Path]:
    """Return the files of a trajectory."""
    return sorted((folder / FOLDER / "records").glob(f"*_{trajectory}_20*.json"))


def fitted_errors(logs: dict[str, list[Log]], bench: Bench) -> list[list[float]] | str:
    """Return the errors of frictool, a list for each trajectory; or the reason of a refusal."""
    out = []
    for held in TRAJECTORIES:
        seen = [log for name in TRAJECTORIES if name != held for log in logs[name]]
        try:
            model = identify(seen, bench).model
        except FrictoolError as error:
            return str(error)
        played = [validate(model, log, UNSKIPPED) for log in logs[held]]
        out.append(
            [
                float(np.mean(np.abs(one.measured["position"] - one.simulated["position"])))
                for one in played
            ]
        )
    return out


def published_errors(
    logs: dict[str, list[Log]], folder: Path, supply: float | None
) -> list[list[float]]:
    """Return the errors of BAM's published M6, with a supply [V] or the measured voltage."""
    p = parameters(folder / FOLDER / PUBLISHED)
    return [[_published_error(p, log, supply) for log in logs[name]] for name in TRAJECTORIES]


def _published_error(p: Vector, log: Log, supply: float | None) -> float:
    stream = log.main
    signals = stream.signals
    mass, length = (float(signals[f"pendulum_{name}"][0]) for name in ("mass", "length"))
    volts = signals["supply"] if supply is None else np.full(stream.time.size, supply)
    inputs = np.array([volts * signals["torque_enabled"], FIRMWARE[0] * signals["gain"]])
    period = float(np.median(np.diff(stream.time)))
    pendulum = (mass * length**2, mass * WEIGHT * length)
    measured = signals["position"]
    position: Vector = simulated(
        p, pendulum, signals["reference"], inputs, float(measured[0]), period
    )
    return float(np.mean(np.abs(position - measured)))


def rotation_lines(folder: Path) -> list[str]:
    """Return the lines of the table; empty if the folder has no records."""
    bench = load(BENCH, Bench)
    paths = {name: record_files(folder, name) for name in TRAJECTORIES}
    if not all(paths.values()):
        return []
    logs = {name: [read_log(path, bench) for path in files] for name, files in paths.items()}
    fitted = fitted_errors(logs, bench)
    rows: dict[str, Sequence[Sequence[float]] | str] = {
        "frictool auto, without the trajectory": fitted,
        "BAM M6 as published, 15 V": published_errors(logs, folder, STATED_SUPPLY),
        "BAM M6 as published, measured voltage": published_errors(logs, folder, None),
    }
    return [HEAD, *(_row(name, errors) for name, errors in rows.items())]


def score(errors: Sequence[Sequence[float]]) -> float:
    """Return the mean error over all records, rad."""
    return float(np.mean(np.concatenate([np.asarray(one) for one in errors])))


def _row(name: str, errors: Sequence[Sequence[float]] | str) -> str:
    if isinstance(errors, str):
        return f"| {name} | {errors} |{' - |' * len(TRAJECTORIES)}"
    cells = [f"{float(np.mean(one)):.3g}" for one in errors]
    return f"| {name} | {' | '.join(cells)} | {score(errors):.3g} |"
