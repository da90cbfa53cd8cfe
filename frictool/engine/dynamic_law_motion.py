"""Simulation of a mass under a friction law with internal states z, such as Dahl or LuGre.

    m v' = u(t, x, v, q) - load(x) - F(z, z', v)      x' = v      q' = x - r      z' = rate(z, v)

x is the position, v the velocity, r the position reference, u the effort (engine/drive.py), and F
the friction. `run_dynamic` simulates a run of a mass without load; engine/dynamic_law_axis.py uses
the steps of this module for an axis in a sampled loop.

A dynamic law does not switch between stick and slip: in stick, v is small, but not zero. In slip
the equations are stiff, because the contact relaxes in microseconds. The integrator is therefore an
implicit Rosenbrock method (engine/rosenbrock.py) with error control on v and z.

In some laws, part of z is a memory, for example of past reversals. This memory is updated after
accepted steps only. The memory must register each reversal; a step therefore ends there. An
extension (friction/law_extension.py) makes Coulomb friction and breakaway depend on position and
direction, and adds viscous friction by ranges of speed. The Jacobian neglects the change of
friction with position, which is small compared with the contact stiffness.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictool.engine import body as fb
from frictool.engine import drive as dr
from frictool.engine.drive import effort, effort_rate, reference
from frictool.engine.mechanism.address_calls import call_by_address
from frictool.engine.rosenbrock import CONTACT, NODES, STAGES, between, complete_stage, stage_point
from frictool.engine.status_codes import LAW_FAILED, NOT_FINITE, OK, STEP_TOO_SMALL
from frictool.friction import kernel_signatures as s
from frictool.friction.law import DynamicKernels
from frictool.friction.law_extension import levels, regime_table
from frictool.friction.speed_regimes import knee_force, knee_slope
from frictool.plant.position_load import load_effort, load_slope
from frictool.runtime.kernels import function_pointer, kernel
from frictool.typing import Vector

Laws = tuple[Vector, Vector, Vector, Vector]

law_rate = call_by_address(s.RATE)
law_force = call_by_address(s.FORCE)
law_commit = call_by_address(s.COMMIT)

FIRST_STEP = 1e-9  # first step, relative to the length of the segment
SHORTEST_STEP = 2.0**-50  # shortest step, relative to the time
GROWTH, SHRINKAGE, SAFETY = 5.0, 0.2, 0.9
DIFFERENCE = 1e-7  # step of the law's difference quotients, relative to the size of a state
AT_REVERSAL = 1e-3  # speed below which a step may pass v = 0, relative to the reference speed


class LawKernels(NamedTuple):
    """Addresses of the kernels of a dynamic law (friction/law.py `DynamicKernels`)."""

    rate: int
    force: int
    commit: int


class DrivenContact(NamedTuple):
    """Mass with a dynamic friction law, its drive, and its load (plant/position_load.py)."""

    kernels: LawKernels
    laws: Laws
    mass: float
    drive: Vector
    load: Vector


class Linearisation(NamedTuple):
    """Derivatives of y' with respect to the state y and time (rosenbrock.py `complete_stage`)."""

    gains: Vector
    couplings: Vector
    in_time: Vector


def law_kernels(kernels: DynamicKernels) -> LawKernels:
    """Return the addresses of the kernels of a dynamic law."""
    return LawKernels(
        function_pointer(kernels.rate, s.RATE).address,
        function_pointer(kernels.force, s.FORCE).address,
        function_pointer(kernels.commit, s.COMMIT).address,
    )


def virgin_contact(
    kernels: DynamicKernels, p: Vector, speed_scale: float, length_scale: float
) -> tuple[Vector, int, Vector]:
    """Return (z, m, scales) of a contact that has never moved.

    - z (n,): internal state. The first m elements follow differential equations; the other elements
      are memory
    - scales (n,): change of each element of z over `length_scale` [m | rad], for error control
    """
    z = kernels.reset(p)
    rates = np.zeros_like(z)
    kernels.rate(z, speed_scale, p, rates)
    # every state of a virgin contact has a rate, except memory, which needs no error control
    return z, int(np.count_nonzero(rates)), np.abs(rates) / speed_scale * length_scale


@kernel
def hold_levels(laws: Laws, y: Vector) -> float:
    """Evaluate the law's parameters at the state y; write them to the last array of `laws`.

    Returns the additional viscous friction [N | N m] of the friction extension at the speed in y.
    """
    forward, backward, table, p = laws
    if table.shape[0] == 0:
        return 0.0
    levels(forward, backward, table, y[0], math.copysign(1.0, y[1]), math.inf, p)
    added: float = knee_force(y[1], regime_table(table))
    return added


@kernel
def law_field(driven: DrivenContact, t: float, y: Vector, out: Vector) -> int:
    """Fill `out` with the derivative y' at the state y; return a status code."""
    kernels, laws, mass, drive, load = driven
    added = hold_levels(laws, y) + load_effort(load, y[0])
    law = laws[3]
    status = law_rate(kernels.rate, y[CONTACT:], y[1], law, out[CONTACT:])
    friction = law_force(kernels.force, y[CONTACT:], out[CONTACT:], y[1], law)
    out[0] = y[1]
    out[1] = (effort(t, y[0], y[1], y[2], drive) - friction - added) / mass
    out[2] = y[0] - reference(t, drive)
    return int(status)


@kernel
def linearise(
    driven: DrivenContact, t: float, y: Vector, slope: Vector, scales: Vector, linear: Linearisation
) -> int:
    """Fill `linear` with the derivatives of y' at the state y; `slope`: y' at y.

    The derivatives are difference quotients. The velocity is changed such that the speed grows. z
    is changed in the direction in which z moves, because a hysteresis is stiffer in the opposite
    direction.
    """
    kernels, laws, mass, drive, load = driven
    gains, couplings, in_time = linear
    m = couplings.shape[1]
    z = y[CONTACT:]
    zdot = slope[CONTACT:]
    table = laws[2]
    law = laws[3]
    hold_levels(laws, y)
    out = np.zeros_like(z)
    there = z.copy()
    friction = law_force(kernels.force, z, zdot, y[1], law)
    step = math.copysign(DIFFERENCE * max(scales[1], abs(y[1])), y[1])
    failed = law_rate(kernels.rate, z, y[1] + step, law, out)
    gains[0] = (drive[dr.PROPORTIONAL] + load_slope(load, y[0])) / mass
    gains[2] = drive[dr.INTEGRAL] / mass
    steeper = knee_slope(y[1], regime_table(table)) if table.shape[0] > 0 else 0.0
    faster = law_force(kernels.force, z, out, y[1] + step, law)
    gains[1] = (steeper + drive[dr.DERIVATIVE] + (faster - friction) / step) / mass
    couplings[0] = (out[:m] - zdot[:m]) / step
    for j in range(m):
        there[j] += math.copysign(DIFFERENCE * max(scales[CONTACT + j], abs(z[j])), zdot[j])
    failed += law_rate(kernels.rate, there, y[1], law, out)
    couplings[1] = (out[:m] - zdot[:m]) / (there[:m] - z[:m])
    for j in range(m):
        here = z[j]
        turned = zdot[j]
        step = there[j] - z[j]
        z[j], zdot[j] = there[j], out[j]
        deflected = law_force(kernels.force, z, zdot, y[1], law)
        couplings[2, j] = (deflected - friction) / (step * mass)
        z[j], zdot[j] = here, turned
    in_time[1] = effort_rate(t, drive) / mass
    in_time[2] = -drive[dr.TARGET_SPEED]
    return int(failed)


@kernel
def try_law_step(
    driven: DrivenContact,
    linear: Linearisation,
    t: float,
    h: float,
    y: Vector,
    slope: Vector,
    scales: Vector,
    stages: Vector,
    end: Vector,
) -> float:
    """Try one step of length h [s] from the state y to `end`; return error/tolerance.

    The result is inf if a kernel of the law fails. slope: derivative y' at y. Fills `stages` (6, n)
    with the results of the stages.
    """
    gains, couplings, in_time = linear
    rows = CONTACT + couplings.shape[1]
    stages[0, :] = slope
    complete_stage(gains, couplings, in_time, h, 0, stages)
    for i in range(1, STAGES):
        stage_point(y, stages, i, rows, end)
        if law_field(driven, t + NODES[i] * h, end, stages[i]) != OK:
            return math.inf
        complete_stage(gains, couplings, in_time, h, i, stages)
    worst = 0.0
    for row in range(rows):
        error = stages[STAGES - 1, row]
        end[row] += error
        if scales[row] > 0.0:
            worst = max(
                worst,
                abs(error) / (scales[0] * max(scales[row], abs(y[row]), abs(end[row])))
                if row > 0
                else 0.0,
            )
    return worst if math.isfinite(worst) and math.isfinite(end[1]) else math.inf


@kernel
def _sample(driven: DrivenContact, t: float, y: Vector, zdot: Vector, row: Vector) -> None:
    kernels, laws, _, drive, _ = driven
    added = hold_levels(laws, y)
    law = laws[3]
    law_rate(kernels.rate, y[CONTACT:], y[1], law, zdot)
    row[fb.SAMPLE_POSITION] = y[0]
    row[fb.SAMPLE_VELOCITY] = y[1]
    row[fb.SAMPLE_EFFORT] = effort(t, y[0], y[1], y[2], drive)
    row[fb.SAMPLE_FRICTION] = law_force(kernels.force, y[CONTACT:], zdot, y[1], law) + added
    row[fb.SAMPLE_MODE] = float(np.sign(y[1]))


@kernel
def step_factor(error: float) -> float:
    """Return (next step length)/(last step length); `error`: error/tolerance of the last step."""
    if not math.isfinite(error):
        return SHRINKAGE
    return GROWTH if error == 0.0 else min(GROWTH, max(SHRINKAGE, SAFETY * error**-0.25))


@kernel
def _segment(
    driven: DrivenContact,
    y: Vector,
    moving: int,
    scales: Vector,
    t: float,
    end: float,
    times: Vector,
    samples: Vector,
    filled: int,
) -> tuple[int, float, int]:
    laws = driven.laws
    n = y.shape[0]
    slope = np.zeros(n)
    after = y.copy()
    at = y.copy()
    zdot = np.zeros(n - CONTACT)
    stages = np.zeros((STAGES, n))
    linear = Linearisation(np.zeros(3), np.zeros((3, moving)), np.zeros(CONTACT))
    h = FIRST_STEP * (end - t)
    shortest = SHORTEST_STEP * max(abs(t), abs(end))
    fresh = True
    while t < end:
        step = min(h, end - t)
        if fresh:
            failed = law_field(driven, t, y, slope)
            if failed + linearise(driven, t, y, slope, scales, linear) != OK:
                return LAW_FAILED, t, filled
        error = try_law_step(driven, linear, t, step, y, slope, scales, stages, after)
        fresh = error <= 1.0
        if not fresh:
            if step <= shortest:
                return STEP_TOO_SMALL if math.isfinite(error) else NOT_FINITE, t, filled
            h = step * step_factor(error)
            continue
        if y[1] * after[1] < 0.0 and min(abs(y[1]), abs(after[1])) > AT_REVERSAL * scales[1]:
            h = step * y[1] / (y[1] - after[1])
            fresh = False
            continue
        later = t + step if step < end - t else end
        while filled < times.shape[0] and times[filled] < later:
            between(y, after, stages, (times[filled] - t) / step, CONTACT + moving, at)
            _sample(driven, times[filled], at, zdot, samples[filled])
            filled += 1
        y[: CONTACT + moving] = after[: CONTACT + moving]
        hold_levels(laws, y)
        if law_commit(driven.kernels.commit, y[CONTACT:], y[1], laws[3]) != OK:
            return LAW_FAILED, later, filled
        after[CONTACT + moving :] = y[CONTACT + moving :]
        at[CONTACT + moving :] = y[CONTACT + moving :]
        t = later
        h = max(h if step < h else 0.0, step * step_factor(error))
    return OK, t, filled


@kernel
def run_dynamic(
    kernels: LawKernels,
    laws: Laws,
    mass: float,
    y: Vector,
    moving: int,
    scales: Vector,
    start: float,
    ends: Vector,
    drives: Vector,
    times: Vector,
    samples: Vector,
) -> tuple[int, float]:
    """Simulate y = (x, v, q, z...), in place, from `start` [s] under a sequence of efforts.

    - ends (s,), drives (s, 10): the effort drives[i] (engine/drive.py) acts up to ends[i] [s]
    - kernels: addresses of the law's kernels (`law_kernels`)
    - laws: the three arrays forward, backward and table of a PackedExtension, then an array for the
      law's current parameters. Without an extension, this fourth array must contain the parameters
    - moving: number of leading elements of z with a differential equation; the other elements are
      memory
    - scales: relative tolerance, reference speed [m/s], 0 (q has no error control), and a reference
      size for each element of z
    - times (n,): ascending, within the run

    Fills samples (n, 5) with the values at `times`.

    Returns a status of engine/status_codes.py and the time reached [s].
    """
    t = start
    filled = 0
    none = np.zeros(0)
    for k in range(ends.shape[0]):
        driven = DrivenContact(kernels, laws, mass, drives[k], none)
        status, t, filled = _segment(driven, y, moving, scales, t, ends[k], times, samples, filled)
        if status != OK:
            return status, t
    zdot = np.zeros(y.shape[0] - CONTACT)
    driven = DrivenContact(kernels, laws, mass, drives[-1], none)
    while filled < times.shape[0]:
        _sample(driven, times[filled], y, zdot, samples[filled])
        filled += 1
    return OK, t
