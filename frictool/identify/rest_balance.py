"""Rests in which the measured effort would move an axis, according to its model.

The friction of an axis at rest is at most its breakaway F. Let f be the measured effort minus
offset and load of the model. During a rest of duration T, the momentum of an axis of inertia J
changes by the integral of f minus friction, so that

    |mean of f| <= F + J (v_in + v_out)/T

v_in and v_out bound the speeds at which the axis enters and leaves the encoder count in which it
rests. If |mean of f| exceeds this limit, another force holds the axis, for example of a contact, an
end stop or a brake. The simulated axis would leave its position.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from frictool.adapters.axis_model import load_of
from frictool.documents.model import Model
from frictool.documents.quantity import si_unit
from frictool.identify.fit_warnings import DOUBTFUL_FORCE_ERROR
from frictool.identify.force_error import friction_in_slip
from frictool.identify.motion_record import MotionRecord
from frictool.logs.quality.ramps import rests_of, without_flicker
from frictool.typing import Vector

AT_END = 2.0  # largest distance of a rest at an end of the travel, in encoder counts


@dataclass(frozen=True)
class HeldRest:
    """Rest in which the effort of the model exceeds its breakaway.

    - position: position of the rest, rad | m
    - effort: mean of the measured effort minus offset and load of the model, N m | N
    - breakaway: upper end of the interval of the breakaway at this position, N m | N
    """

    position: float
    effort: float
    breakaway: float

    def words(self, model: Model) -> str:
        """Return position, effort and breakaway in words."""
        length, unit = si_unit("position", model.axis), si_unit("effort", model.axis)
        return (
            f"the axis rests at {self.position:.3g} {length} under {abs(self.effort):.3g} {unit}, "
            f"above the model's breakaway {self.breakaway:.3g} {unit}"
        )


def held_rest(model: Model, record: MotionRecord, error: float) -> HeldRest | None:
    """Return the rest with the largest unexplained effort; None if friction explains all rests.

    A rest at an end of the bench's travel is left out if the effort presses against this end.

    Parameters
    ----------
    model
        Model of the axis.
    record
        Record with a measured position.
    error
        Allowed error of the effort, N m | N.
    """
    position = without_flicker(record.position, record.resolution)
    moves = np.append(np.abs(np.diff(position)), 0.0)
    moved = (moves > 0.5 * record.resolution) | (np.diff(record.piece, append=math.inf) > 0)
    rests = rests_of(moved)
    if not rests:
        return None
    start, stop = np.transpose(rests)
    net = record.effort - model.parameters.offset.value - load_of(model).at(record.position)
    total = np.concatenate(([0.0], np.cumsum(net)))
    mean = (total[stop] - total[start]) / (stop - start)
    speed = np.maximum(moves, record.resolution) / record.period
    momentum = model.parameters.inertia.value * (speed[start - 1] + speed[stop - 1])
    friction = _breakaway(model, record, start)
    excess = np.abs(mean) - friction - error - momentum / (record.period * (stop - start))
    excess[_at_end(model, record, position[start], mean)] = -np.inf
    worst = int(np.argmax(excess))
    if excess[worst] <= 0.0:
        return None
    return HeldRest(float(position[start[worst]]), float(mean[worst]), float(friction[worst]))


def held_rest_warnings(model: Model, records: Sequence[MotionRecord]) -> list[str]:
    """Return a warning for each record with a rest in which the model would move.

    If the model is valid on one side of a position only, rests on the other side are left out.
    """
    side, warnings = model.valid_side, []
    for record in records:
        inside = np.full(record.position.size, side is None)
        if side is not None:
            inside = side.sign * (record.position - side.bound) > 0.0
        part = None if record.velocity is not None else record.inside(inside)
        if part is None:
            continue
        error = DOUBTFUL_FORCE_ERROR * float(np.sqrt(np.mean(part.effort**2)))
        held = held_rest(model, part, error)
        if held is not None:
            warnings.append(
                f"{Path(record.name).name}: {held.words(model)}; look for a contact, end stop or "
                "brake"
            )
    return warnings


def _breakaway(model: Model, record: MotionRecord, index: Vector) -> Vector:
    """Return the upper end of the breakaway's interval at samples `index` (m,), N m | N, (m,)."""
    levels = [model.parameters.breakaway, model.parameters.coulomb]
    laws = model.laws
    if laws is not None and laws.backward is not None:
        levels += filter(None, (laws.backward.breakaway, laws.backward.coulomb))
        laws = msgspec.structs.replace(laws, backward=None)
    values = {"coulomb": max(max(one.interval) for one in levels), "viscous": 0.0}
    warm = None if record.temperature is None else record.temperature.values[index]
    if laws is not None:
        laws = msgspec.structs.replace(laws, regimes=())
    position = record.position[index]
    return friction_in_slip(values, laws, position, np.zeros(position.size), warm)


def _at_end(model: Model, record: MotionRecord, position: Vector, effort: Vector) -> Vector:
    """Return a mask (m,) of the positions at which the effort presses against an end of travel."""
    travel = model.bench.mechanics.travel
    if travel is None:
        return np.zeros(position.size, dtype=np.bool_)
    near = AT_END * record.resolution
    low = (position <= travel.low + near) & (effort < 0.0)
    high = (position >= travel.high - near) & (effort > 0.0)
    return np.asarray(low | high)
