"""Fast verdict on a simulated plant, in numbers only; a campaign simulates thousands of plants.

    record -> position, drive, peaks -> sensor step -> holds -> metrics -> (value, met)

The values equal the values that `judge` computes from the simulation's log. Reasons and locations
are left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from frictool.documents.metric_table import REQUIREMENTS
from frictool.documents.spec import Spec
from frictool.engine.closed_loop import COMMAND
from frictool.logs.quality.time_base import encoder_step
from frictool.metrics.drive_peak import command_peak, drive_peak
from frictool.metrics.final_value import final_value, tail_samples
from frictool.metrics.reference_holds import ConstantRun, Hold, constant_runs, holds_of
from frictool.metrics.rest_motion import MOTION_TOLERANCE, late_samples, peak_to_peak
from frictool.metrics.static_error import static_error
from frictool.presentation.tie_rule import largest
from frictool.report.rig_facts import RigFacts
from frictool.report.run_kernels import OFF_LATTICE, lattice_distances, run_signals, step_metrics
from frictool.report.worst_hold import limit_of
from frictool.typing import Vector

Outcome = tuple[float, bool | None]  # value of a requirement, and True if it is met
# keys of the specification that this module judges; each of HOLD_KEYS has one value per hold
HOLD_KEYS = ("response_time_95_s", "overshoot_percent", "static_error", "oscillations")
KEYS = {*HOLD_KEYS, "modulus_margin", "drive_peak", "rest"}


class RunRecord(NamedTuple):
    """Signals of one simulated plant.

    - time, reference, noise (n,): time, reference, and noise of the measured drive
    - record (n, 7): columns as in engine/closed_loop.py
    - conditions (n, 8) or (0, 8): columns as in engine/disturbances_and_faults.py
    """

    time: Vector
    reference: Vector
    record: Vector
    conditions: Vector
    noise: Vector


class RunMetrics:
    """Function that computes (value, met) of each requirement for a simulated plant.

    The requirements are in the order of `spec`. `rig`: rig of the simulations. `covers` is True if
    this class can judge every requirement, that is, if all are in KEYS.
    """

    def __init__(self, spec: Spec, rig: RigFacts) -> None:
        keys = [key for key in REQUIREMENTS if getattr(spec, key) is not None]
        self.covers = set(keys) <= KEYS
        self._step = rig.resolution
        self._limits = {key: limit_of(spec, key) for key in keys}
        self._allowed: float | None = spec.response_time_95_s
        self._after: float | None = None if spec.rest is None else spec.rest.after_s
        self._reference: Vector | None = None
        self._runs: tuple[ConstantRun, ...] = ()

    def __call__(self, run: RunRecord, margin: Outcome) -> list[Outcome] | None:
        """Return (value, met) of each requirement; `margin` is (value, met) of the modulus margin.

        Return None if only `judge` can judge the signals, because a signal is not finite.
        """
        samples = run.time.size
        position: Vector = np.empty(samples)
        drive: Vector = np.empty(samples)
        command, finite = run_signals(run.record, run.conditions, run.noise, position, drive)
        if not finite or not self._has_runs(run.reference):
            return None
        resolution = self._resolution(position)
        holds = holds_of(self._runs, position, resolution)
        values = self._values(run.time, position, holds, resolution)
        values["drive_peak"] = [command]
        if "drive_peak" in self._limits and command_peak(drive) > command:
            values["drive_peak"].append(drive_peak(drive))
        outcomes = {key: _worst(values.get(key, ()), limit) for key, limit in self._limits.items()}
        if "modulus_margin" in outcomes:
            outcomes["modulus_margin"] = margin
        if "rest" in outcomes:
            outcomes["rest"] = self._rest(run, position, holds, resolution)
        return list(outcomes.values())

    def _has_runs(self, reference: Vector) -> bool:
        if reference is not self._reference:
            if not np.isfinite(reference).all():
                return False
            self._runs, self._reference = constant_runs(reference), reference
        return True

    def _rest(
        self, run: RunRecord, position: Vector, holds: Sequence[Hold], resolution: float
    ) -> Outcome:
        """Return (drive at rest, met); met is None if no hold is long enough.

        The drive at rest is replaced by inf if the axis moves although the drive is within its
        limit at rest.
        """
        assert self._after is not None
        motions, drives = [], []
        for hold in holds:
            rest = late_samples(hold.of(run.time), self._after)
            if rest is not None:
                motions.append(peak_to_peak(hold.of(position)[rest]))
                drives.append(command_peak(hold.of(run.record[:, COMMAND])[rest]))
        if not motions:
            return math.nan, None
        moving = largest(motion - resolution for motion in motions)[1]
        if motions[moving] > resolution * (1.0 + MOTION_TOLERANCE):
            return drives[moving] if drives[moving] > self._limits["rest"] else math.inf, False
        value = largest(drives)[0]
        return value, value <= self._limits["rest"]

    def _resolution(self, position: Vector) -> float:
        distances, steps = lattice_distances(position, self._step)
        if steps == OFF_LATTICE:
            return encoder_step(position) or self._step
        return float(distances.sum() / steps) if steps > 0.0 else self._step

    def _values(
        self, time: Vector, position: Vector, holds: Sequence[Hold], resolution: float
    ) -> dict[str, list[float]]:
        values: dict[str, list[float]] = {key: [] for key in HOLD_KEYS}
        for hold in holds:
            times, part = hold.of(time), hold.of(position)
            final = final_value(part)
            whole = self._allowed is None or not float(times[-1] - times[0]) < self._allowed
            if whole:
                values["static_error"].append(static_error(part, hold.target, resolution))
            if hold.origin is None:
                continue
            settled, overshoot, reversals = step_metrics(
                part, hold.origin, hold.target, final, tail_samples(part.size), resolution
            )
            values["overshoot_percent"].append(overshoot)
            values["oscillations"].append(float(math.ceil(reversals / 2)))
            if whole:
                response = math.inf if settled < 0 else float(times[settled] - times[0])
                values["response_time_95_s"].append(response)
        return values


def _worst(values: Sequence[float], limit: float) -> Outcome:
    if not values:
        return math.nan, None
    value = values[largest(values)[1]]
    return value, value <= limit
