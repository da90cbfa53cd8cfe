"""The axis (5.48) as a linear fractional form, with its physical parameters as real uncertainties.

    J v' = K i - s v - F w      J = J0 + rJ dJ,  K = K0 + rK dK,  s = s0 + rs ds
                                dJ, dK, ds real, constant, in [-1, 1]
    continuous (exact)          v' = (q - w_J)/J0,  q = K0 i + w_K - s0 v - w_s - F w
                                z_J = rJ v', z_K = rK i, z_s = rs v;  w = d z

The sampled form encloses the axis, since its zero-order hold is an exponential of s/J. It uses the
moments Y_j = int_0^T (T - t)^(j-1)/(j-1)! v dt of one period, with Y_0 = v(T). Momentum is
conserved exactly at each level:

    Y_j = T^j/j! v + V_j,   J V_j = K (a_j i + b_j u) - s Y_(j+1) - F w T^(j+1)/(j+1)!
    v+ = Y_0,  eta+ = eta + T v_c - Y_1

Each level contains the three parameters once. The last moment Y_N is replaced by the middle of its
range over the box, plus a block |Delta| <= 1 that covers the rest of that range. A property that
holds for every Delta therefore holds for every plant of the box, but not the reverse; each further
level reduces the excess by the factor s T/(J N). The Coulomb friction only scales the input w; the
largest friction is the worst case and is used.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from frictool.plant.block_diagram import DiagramBlock
from frictool.plant.generalised_plant import (
    Controlled,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
)
from frictool.plant.linear_axis import INPUTS, OUTPUTS
from frictool.plant.lti import Lti
from frictool.plant.parameter_box import DYNAMIC, Box, largest_coulomb
from frictool.typing import Matrix

# number of moments of one period; for the clutch at 1 ms the replaced part is below 1e-4 of every
# coefficient
LEVELS = 2


@dataclass(frozen=True)
class RealBlock:
    """Uncertainty delta I of `size`, delta real in [-1, 1]."""

    name: str
    size: int

    @property
    def entering(self) -> int:
        """Number of inputs, equal to `size`."""
        return self.size


@dataclass(frozen=True)
class FullBlock:
    """Uncertainty that may be any real or complex matrix (size, entering) of norm at most 1."""

    name: str
    size: int
    entering: int


Uncertain = RealBlock | FullBlock


@dataclass(frozen=True)
class UncertainAxis:
    """The axis and its uncertainty blocks.

    The ports of `block` beyond INPUTS and OUTPUTS belong to `blocks`, in order.
    """

    block: DiagramBlock
    blocks: tuple[Uncertain, ...]


def uncertain_axis(
    box: Box, lag: float, period: float = 0.0, levels: int = LEVELS
) -> UncertainAxis:
    """Return the axis over a box (low, high) of inertia, constant, viscous and coulomb.

    lag, period [s]; a period of 0 is continuous time. Raises ValueError if the inertia is not
    positive, a parameter may be negative, or `levels` is below 1.
    """
    if box["inertia"][0] <= 0.0 or min(box[name][0] for name in DYNAMIC) < 0.0 or levels < 1:
        raise ValueError(
            "a box needs a positive inertia, a constant and a viscous coefficient that are "
            "not negative, and a level or more"
        )
    rows = _sampled(box, lag, period, levels) if period else _continuous(box, lag)
    kept = [b for b in rows.blocks if isinstance(b, FullBlock) or box[b.name][1] > box[b.name][0]]
    entering = [f"{b.name}.w{k}" for b in kept for k in range(b.size)]
    leaving = [f"{b.name}.z{k}" for b in kept for k in range(b.entering)]
    names = [*rows.states, *INPUTS, *entering]
    wide = {
        name: np.array([row.get(column, 0.0) for column in names])
        for name, row in rows.table.items()
    }
    n = len(rows.states)
    moved = np.array([wide[f"{state}+"] for state in rows.states])
    out = np.array([wide[name] for name in (*OUTPUTS, *leaving)])
    system = Lti(moved[:, :n], moved[:, n:], out[:, :n], out[:, n:], period)
    return UncertainAxis(
        DiagramBlock(system, (*INPUTS, *entering), (*OUTPUTS, *leaving)), tuple(kept)
    )


def uncertain_plant(
    controlled: Controlled,
    box: Box,
    lag: float,
    weights: PlantWeights,
    period: float = 0.0,
    delay_samples: int = 0,
) -> tuple[GeneralisedPlant, tuple[Uncertain, ...]]:
    """Return the generalised plant of `uncertain_axis` and its uncertainty blocks.

    The inputs and outputs of the uncertainty come first. Raises ValueError as `uncertain_axis`
    does.
    """
    axis = uncertain_axis(box, lag, period)
    plant = generalised_plant(controlled, axis.block, lag, weights, period, delay_samples)
    return plant, axis.blocks


Row = dict[str, float]  # signal -> factor


@dataclass(frozen=True)
class _AxisRows:
    """Each next state ("v+") and output as a sum over states, inputs and uncertain signals."""

    states: tuple[str, ...]
    table: dict[str, Row]
    blocks: tuple[Uncertain, ...]


def _sum(*terms: tuple[float, Row]) -> Row:
    names = dict.fromkeys(name for _, row in terms for name in row)
    return {name: sum(factor * row.get(name, 0.0) for factor, row in terms) for name in names}


def _momentum(
    box: Box, drive: Row, speed: Row, effort: Row, level: int, table: dict[str, Row]
) -> Row:
    """Return V with J V = K drive - s speed + effort.

    The uncertain outputs of this level are added to the table.
    """
    (j0, rj), (k0, rk), (s0, rs) = (
        (0.5 * (box[name][0] + box[name][1]), 0.5 * (box[name][1] - box[name][0]))
        for name in DYNAMIC
    )
    w_j, w_k, w_s = ({f"{name}.w{level}": 1.0} for name in DYNAMIC)
    combined = _sum(
        (k0 / j0, drive),
        (1.0 / j0, w_k),
        (-s0 / j0, speed),
        (-1.0 / j0, w_s),
        (1.0 / j0, effort),
        (-1.0 / j0, w_j),
    )
    for name, factor, row in zip(DYNAMIC, (rj, rk, rs), (combined, drive, speed), strict=True):
        table[f"{name}.z{level}"] = _sum((factor, row))
    return combined


def _continuous(box: Box, lag: float) -> _AxisRows:
    drive: Row = {"i": 1.0} if lag > 0.0 else {"command": 1.0}
    table: dict[str, Row] = {
        "drive": drive,
        "speed": {"v": 1.0},
        "eta": {"e": 1.0},
        "e+": {"v": -1.0, "speed_reference": 1.0},
    }
    if lag > 0.0:
        table["i+"] = {"i": -1.0 / lag, "command": 1.0 / lag}
    table["v+"] = _momentum(
        box,
        drive,
        {"v": 1.0},
        {"friction": -largest_coulomb(box), "uncertain_effort": 1.0},
        0,
        table,
    )
    return _AxisRows(
        ("i", "v", "e") if lag > 0.0 else ("v", "e"),
        table,
        tuple(RealBlock(name, 1) for name in DYNAMIC),
    )


def _sampled(box: Box, lag: float, period: float, levels: int) -> _AxisRows:
    drive: Row = {"i": 1.0} if lag > 0.0 else {"command": 1.0}
    table: dict[str, Row] = {"drive": drive, "speed": {"v": 1.0}, "eta": {"e": 1.0}}
    if lag > 0.0:
        keep = math.exp(-period / lag)
        table["i+"] = {"i": keep, "command": 1.0 - keep}
    low, high = _last_moment(box, lag, period, levels)
    signals = [name for name in low if high[name] != low[name] or low[name] != 0.0]
    moments: dict[int, Row] = {
        levels: {**{name: 0.5 * (low[name] + high[name]) for name in signals}, "rest.w0": 1.0}
    }
    for k, name in enumerate(signals):  # factors below 1 form a row of norm at most sqrt(count)
        table[f"rest.z{k}"] = {name: math.sqrt(len(signals)) * 0.5 * (high[name] - low[name])}
    from_drive, from_command = _drive_moments(lag, period, levels)
    for j in reversed(range(levels)):
        share = period ** (j + 1) / math.factorial(j + 1)
        entering: Row = {"i": from_drive[j], "command": from_command[j]}
        effort = {"friction": -share * largest_coulomb(box), "uncertain_effort": share}
        change = _momentum(box, entering, moments[j + 1], effort, j, table)
        moments[j] = _sum((1.0, change), (period**j / math.factorial(j), {"v": 1.0}))
    table["v+"] = moments[0]
    table["e+"] = _sum((1.0, {"e": 1.0, "speed_reference": period}), (-1.0, moments[1]))
    # empty for a box of one plant
    rest = (
        [FullBlock("rest", 1, len(signals))]
        if any(high[name] != low[name] for name in signals)
        else []
    )
    blocks: tuple[Uncertain, ...] = (*(RealBlock(name, levels) for name in DYNAMIC), *rest)
    return _AxisRows(("i", "v", "e") if lag > 0.0 else ("v", "e"), table, blocks)


def _drive_moments(lag: float, period: float, count: int) -> tuple[Matrix, Matrix]:
    """Return a_j, b_j (count,) with int_0^T (T - t)^j/j! i dt = a_j i(0) + b_j u.

    i goes from i(0) to u with the lag, at once if the lag is 0.
    """
    shares = np.array([period ** (j + 1) / math.factorial(j + 1) for j in range(count)])
    if lag == 0.0:
        return np.zeros(count), shares
    flow = np.zeros((count + 1, count + 1))
    flow[0, 0] = -1.0 / lag
    flow[np.arange(1, count + 1), np.arange(count)] = 1.0
    first = expm(flow * period)[1:, 0]
    return first, shares - first


def _last_moment(box: Box, lag: float, period: float, levels: int) -> tuple[Row, Row]:
    """Return the range of Y_N over the box as factors of v, i, command, friction, uncertain effort.

    Each factor is the integral of a positive kernel times exp(-s t): it falls with s, and is
    proportional to K/J, F/J or 1/J.
    """
    j = box["inertia"]
    rate = {name: (box[name][0] / j[1], box[name][1] / j[0]) for name in ("constant", "viscous")}
    least = _coefficients(rate["viscous"][1], lag, period, levels)
    most = _coefficients(rate["viscous"][0], lag, period, levels)
    scale = {
        "v": (1.0, 1.0),
        "i": rate["constant"],
        "command": rate["constant"],
        "uncertain_effort": (1.0 / j[1], 1.0 / j[0]),
    }
    low = {name: scale[name][0] * least[name] for name in scale}
    high = {name: scale[name][1] * most[name] for name in scale}
    f = largest_coulomb(box)
    low["friction"], high["friction"] = -f * high["uncertain_effort"], -f * low["uncertain_effort"]
    return low, high


def _coefficients(s: float, lag: float, period: float, levels: int) -> Row:
    """Return Y_N of v' = i - s v + d, i' = (u - i)/lag, for a unit of v, i, u or d."""
    n = 4 + levels  # i, v, u, d, then the moments
    flow = np.zeros((n, n))
    flow[1, 0] = 1.0
    flow[1, 1] = -s
    flow[1, 3] = 1.0
    if lag > 0.0:
        flow[0, 0], flow[0, 2] = -1.0 / lag, 1.0 / lag
    else:
        flow[1, 0], flow[1, 2] = 0.0, 1.0  # the drive is the command
    flow[4, 1] = 1.0
    flow[np.arange(5, n), np.arange(4, n - 1)] = 1.0
    last = expm(flow * period)[-1]
    return {
        "i": float(last[0]),
        "v": float(last[1]),
        "command": float(last[2]),
        "uncertain_effort": float(last[3]),
    }
