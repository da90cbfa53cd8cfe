"""Comparison of an exported MJCF file with the model: both are simulated with a log's effort.

    effort of the log --> MuJoCo, the exported file -----> position
    effort of the log --> frictool, the complete model --> position

Both simulations start at rest at the first measured position, and have no end stops. frictool keeps
the axis exactly at rest below breakaway. Each motion of MuJoCo during this rest is creep.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np

from frictool.adapters.axis_model import axis_of, load_of
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.engine.effort_replay import FREE, replay, replay_parameters
from frictool.engine.status_codes import MESSAGES, OK
from frictool.errors import FrictoolError, LogError, NoSolutionError
from frictool.logs.log import Log
from frictool.plant.axis import LOAD_POSITION, POSITION, STATE_SIZE
from frictool.typing import Vector

JITTER = 0.1  # deviation of a sample interval, relative to the period, that counts as a gap
HOLD_SHARE = 0.5  # constant effort of the creep test, relative to the Coulomb friction
HOLD_S = 2.0  # duration [s] of the creep test; its second half gives the creep speed


@dataclass(frozen=True)
class MjcfCheck:
    """Differences between MuJoCo and the model along a log.

    - period: sample period [s]
    - rms, largest: position of MuJoCo minus position of the model, rad | m
    - measured_rms: rms difference between simulated and measured position, rad | m, for MuJoCo and
      frictool
    - rest_s: time during which the model is at rest [s]
    - creep: distance that MuJoCo moves while the model is at rest, rad | m
    - hold_speed: speed of MuJoCo under an effort of half the Coulomb friction, rad/s | m/s; the
      model rests under this effort
    """

    axis: str
    samples: int
    period: float
    rms: float
    largest: float
    measured_rms: dict[str, float]
    rest_s: float
    creep: float
    hold_speed: float

    def as_json(self) -> dict[str, Any]:
        """Return the differences as JSON values."""
        return {
            "samples": self.samples,
            "difference_rms": self.rms,
            "difference_largest": self.largest,
            "measured_rms": self.measured_rms,
            "rest_s": self.rest_s,
            "creep": self.creep,
            "hold_speed": self.hold_speed,
        }

    def lines(self) -> list[str]:
        """Return the differences as lines of text."""
        position, speed = (si_unit(key, self.axis) for key in ("position", "velocity"))  # type: ignore[arg-type]
        return [
            f"check: {self.samples} samples, {self.samples * self.period:.4g} s",
            f"MuJoCo minus frictool: {self.rms:.3g} {position} rms, {self.largest:.3g} {position} "
            "at most",
            *(
                f"{name} minus measured: {error:.3g} {position} rms"
                for name, error in self.measured_rms.items()
            ),
            f"creep of MuJoCo: {self.creep:.3g} {position} in {self.rest_s:.4g} s at rest; "
            f"{self.hold_speed:.3g} {speed} at {100 * HOLD_SHARE:.0f} % of the Coulomb friction",
        ]


def mjcf_check(model: Model, text: str, log: Log) -> MjcfCheck:
    """Simulate an exported MJCF file and the model with the effort of a log, and compare them.

    - model: complete model
    - text: MJCF file of the model
    - log: log with position and effort, matched to the model's bench

    Raises FrictoolError if MuJoCo is not installed or does not read the file. Raises LogError if
    the log lacks a signal or has a gap in its first samples. Raises NoSolutionError if the
    simulation of the model fails.
    """
    mujoco = _mujoco()
    position, effort, period = _record(log)
    try:
        target = mujoco.MjModel.from_xml_string(text)
    except ValueError as error:
        raise FrictoolError(
            f"{model.name}: MuJoCo {mujoco.__version__} does not read the exported file: {error}; "
            "install mujoco>=3.12"
        ) from None
    target.jnt_limited[:] = 0
    ours, speed = _simulated(model, log.source, position[0], effort, period)
    theirs = _played(mujoco, target, position[0], effort, period)
    rest = (speed[:-1] == 0.0) & (np.diff(ours) == 0.0)
    gap = theirs - ours
    hold = HOLD_SHARE * model.parameters.coulomb.value + model.parameters.offset.value
    held = _played(mujoco, target, 0.0, np.full(math.ceil(HOLD_S / period) + 1, hold), period)
    half = held.size // 2
    return MjcfCheck(
        model.axis,
        position.size,
        period,
        _rms(gap),
        float(np.max(np.abs(gap))),
        {"MuJoCo": _rms(theirs - position), "frictool": _rms(ours - position)},
        float(np.count_nonzero(rest) * period),
        float(np.sum(np.abs(np.diff(theirs))[rest])),
        float((held[-1] - held[half]) / ((held.size - 1 - half) * period)),
    )


def _mujoco() -> ModuleType:
    try:
        import mujoco
    except ImportError:
        raise FrictoolError(
            "--check needs MuJoCo, which is not installed; pip install 'frictool[mujoco]'"
        ) from None
    module: ModuleType = mujoco
    return module


def _record(log: Log) -> tuple[Vector, Vector, float]:
    stream = log.main
    position, effort = log.require(stream, "position", "effort")
    steps = np.diff(stream.time)
    period = float(np.median(steps)) if steps.size else 0.0
    good = np.isfinite(position) & np.isfinite(effort)
    broken = ~good[1:] | ~good[:-1] | (np.abs(steps - period) > JITTER * period)
    end = int(np.argmax(broken)) + 1 if broken.any() else position.size
    if end < 3 or period <= 0.0:
        raise LogError(log.source, f"has {end} samples before the first gap; at least 3 are needed")
    return position[:end], effort[:end], period


def _simulated(
    model: Model, source: str, start: float, effort: Vector, period: float
) -> tuple[Vector, Vector]:
    axis = axis_of(model)
    p = replay_parameters(
        axis._replace(laws=axis.laws._replace(stops=(-math.inf, math.inf)), lag=0.0)
    )
    state = np.zeros(STATE_SIZE)
    state[POSITION] = state[LOAD_POSITION] = start
    position, speed = np.empty(effort.size), np.empty(effort.size)
    status = replay(
        p, load_of(model).as_array(), state, effort, effort, FREE, period, position, speed
    )
    if status != OK:
        raise NoSolutionError(f"{source}: {MESSAGES[status]}; check the model's parameters")
    return position, speed


def _played(mujoco: ModuleType, target: Any, start: float, effort: Vector, period: float) -> Vector:
    data = mujoco.MjData(target)
    data.qpos[0] = start
    steps = max(1, round(period / target.opt.timestep))
    target.opt.timestep = period / steps
    position = np.empty(effort.size)
    for k, value in enumerate(effort):
        position[k] = data.qpos[0]
        data.qfrc_applied[0] = value
        mujoco.mj_step(target, data, nstep=steps)
    return position


def _rms(values: Vector) -> float:
    return float(np.sqrt(np.mean(values**2)))
