"""Score of servo models on the pendulum records: fit four trajectories, predict the fifth, rotate.

The score is the mean of |simulated - measured position| [rad] over each record, and then over the
records. A simulation starts at the first sample, at rest, and reads only goal, gain and supply
voltage. BAM's published M6 was fitted to records of all five trajectories, with the supply `vin` of
the records (15 V). Further rows show M6 with the measured voltage (about 12 V), and with a limit of
the goal's speed. BAM's code has this limit today; the published parameters do not include it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from frictool.documents.bench import Bench
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.engine.firmware_servo import limited_profile
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
GOAL_SPEED = 3400 * 2.0 * np.pi / 4096  # rad/s, default of BAM: 3400 counts/s
UNSKIPPED = ValidationRequest(skip=0, cutoff_hz=10.0)
HEAD = (
    f"| servo, mean error [rad] | {' | '.join(TRAJECTORIES)} | mean |\n"
    f"| --- |{' --- |' * len(TRAJECTORIES)} --- |"
)


def record_files(folder: Path, trajectory: str) -> list[Path]:
    """Return the files of a trajectory."""
    return sorted((folder / FOLDER / "records").glob(f"*_{trajectory}_20*.json"))


def fitted_errors(
    logs: dict[str, list[Log]], bench: Bench, unseen: bool = True
) -> list[list[float]] | str:
    """Return the errors of frictool for each trajectory, or the reason of a refusal.

    unseen: True to fit the model of a trajectory to the other trajectories only.
    """
    every = [log for name in TRAJECTORIES for log in logs[name]]
    out = []
    model = None
    try:
        for held in TRAJECTORIES:
            seen = [log for log in every if not unseen or log not in logs[held]]
            if unseen or model is None:
                model = identify(seen, bench).model
            out.append([_error(model, log) for log in logs[held]])
    except FrictoolError as error:
        return str(error)
    return out


def _error(model: Model, log: Log) -> float:
    """Return the mean error of a model's position along the goal of a log, rad."""
    played = validate(model, log, UNSKIPPED)
    return float(np.mean(np.abs(played.measured["position"] - played.simulated["position"])))


def published_errors(
    logs: dict[str, list[Log]], folder: Path, supply: float | None, speed: float = math.inf
) -> list[list[float]]:
    """Return the errors of BAM's published M6, with a supply [V] or the measured voltage.

    `speed` limits the speed of the goal, rad/s.
    """
    p = parameters(folder / FOLDER / PUBLISHED)
    return [
        [_published_error(p, log, supply, speed) for log in logs[name]] for name in TRAJECTORIES
    ]


def _published_error(p: Vector, log: Log, supply: float | None, speed: float) -> float:
    stream = log.main
    signals = stream.signals
    mass, length = (float(signals[f"pendulum_{name}"][0]) for name in ("mass", "length"))
    volts = signals["supply"] if supply is None else np.full(stream.time.size, supply)
    inputs = np.array([volts * signals["torque_enabled"], FIRMWARE[0] * signals["gain"]])
    period = float(np.median(np.diff(stream.time)))
    pendulum = (mass * length**2, mass * WEIGHT * length)
    measured = signals["position"]
    goal = signals["reference"]
    goal = limited_profile(goal, float(goal[0]), speed * period)
    position: Vector = simulated(p, pendulum, goal, inputs, float(measured[0]), period)
    return float(np.mean(np.abs(position - measured)))


def rotation_lines(folder: Path) -> list[str]:
    """Return the lines of the table; empty if the folder has no records."""
    bench = load(BENCH, Bench)
    paths = {name: record_files(folder, name) for name in TRAJECTORIES}
    if not all(paths.values()):
        return []
    logs = {name: [read_log(path, bench) for path in files] for name, files in paths.items()}
    rows: dict[str, Sequence[Sequence[float]] | str] = {
        "frictool, without the trajectory": fitted_errors(logs, bench),
        "frictool, fitted to all five": fitted_errors(logs, bench, unseen=False),
        "BAM M6 as published, 15 V": published_errors(logs, folder, STATED_SUPPLY),
        "BAM M6 as published, measured voltage": published_errors(logs, folder, None),
        "BAM M6, 15 V, goal limited to 5.2 rad/s": published_errors(
            logs, folder, STATED_SUPPLY, GOAL_SPEED
        ),
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
