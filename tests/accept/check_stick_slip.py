"""The exact engine and the laws' drivers at full count: figures of 3.7, random drives against an
integrator, runs that always end."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictool.engine.body import BREAKS_AWAY, SLIPS_BACK, moving
from frictool.engine.drive import EffortFunction, pid, spring
from frictool.engine.law_simulation import LawRunSettings, body_of, run_law
from frictool.engine.status_codes import EVENTS_FULL, OK
from frictool.engine.stick_slip_run import simulate
from frictool.friction.law_extension import FrictionExtension
from frictool.friction.law_registry import LAWS
from studies.references.extended_friction import MASS, Slow
from studies.references.stick_slip import reference_breakaways, table31
from studies.rigs.table_3_1 import STRIBECK, TABLE_3_1

RUNS, REPLAYS, EXTENDED = 20_000, 40, 30
PID = pid(3.0, 6.0, 4.0, 1.0)
# half peak-to-peak [m], period [s] of the limit cycle; step [s]; relative tolerance
LIMIT_CYCLES = {
    "stribeck": (0.0669, 23.73, None, 0.01),
    "lugre": (0.0645, 24.28, None, 0.01),
    "karnopp": (0.0700, 23.08, 1e-4, 0.01),
    "hybrid_a": (0.0667, 23.77, 1e-5, 0.01),
    "hybrid_b": (0.0669, 23.73, 1e-5, 0.01),
    "hybrid_c": (0.0666, 23.81, 1e-5, 0.03),
}


def _drive(rng: np.random.Generator) -> EffortFunction:
    """Any combination of a held, ramped and swinging effort and of feedback; zeros and round
    numbers among them."""
    high = np.array([2.0, 1.0, 3.0, 40.0, 6.0, 50.0, 5.0, 4.0, 1.0, 0.2])
    low = np.array([-2.0, -1.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, -1.0, -0.2])
    values = rng.uniform(low, high)
    kind = rng.random(values.size)
    return EffortFunction(
        *np.where(
            kind < 0.25, 0.0, np.where(kind < 0.7, values, np.round(4.0 * values) / 4.0)
        ).tolist()
    )


def always_ends() -> dict[str, Any]:
    """Random masses, drives, end stops and tolerances: a run ends, or its room for events is full;
    events never repeat at one instant."""
    rng, full, most = np.random.default_rng(30), 0, 0
    for k in range(RUNS):
        stops = (-3.0, 3.0) if rng.random() < 0.5 else (-np.inf, np.inf)
        changes = {
            "mass": 10.0 ** rng.uniform(-2, 2),
            "restitution": float(rng.choice([0.0, 0.5, 0.9])),
            "tolerance": 10.0 ** rng.uniform(-10, -5),
        }
        end, drives = 10.0 ** rng.uniform(-1, 1.5), (_drive(rng), _drive(rng))
        state = moving(0.0, float(rng.uniform(-1.0, 1.0)))
        run = simulate(
            table31(stops=stops, **changes),
            [(0.5 * end, drives[0]), (end, drives[1])],
            [end],
            state=state,
        )
        at_once = (
            int(np.max(np.unique(run.events[:, 0], return_counts=True)[1]))
            if run.events.size
            else 0
        )
        full, most = full + (run.status == EVENTS_FULL), max(most, at_once)
        if run.status not in (OK, EVENTS_FULL) or at_once > 6:
            return {
                "passed": False,
                "run": k,
                "status": run.status,
                "at_once": at_once,
                "drives": str(drives),
                "changes": str(changes),
            }
    return {"passed": True, "runs": RUNS, "room_full": full, "most_events_at_one_instant": most}


def agrees_with_an_integrator() -> dict[str, Any]:
    """Random drives from rest against DOP853 with events at 1e-12: breakaway times and the last
    position."""
    rng, worst, compared = np.random.default_rng(31), 0.0, 0
    for _ in range(REPLAYS):
        drive = spring(float(rng.uniform(1.0, 20.0)), float(rng.uniform(0.02, 0.3)))
        if rng.random() < 0.5:
            drive = pid(
                float(rng.uniform(1.0, 6.0)),
                float(rng.uniform(0.0, 6.0)),
                float(rng.uniform(0.5, 6.0)),
                1.0,
            )
        expected, last = reference_breakaways(table31(), drive, 12.0)
        run = simulate(table31(), [(12.0, drive)], [12.0])
        found = np.sort(np.concatenate([run.times_of(BREAKS_AWAY), run.times_of(SLIPS_BACK)]))
        if found.size != len(expected):
            return {
                "passed": False,
                "drive": str(drive),
                "found": found.tolist(),
                "expected": expected,
            }
        worst = max(
            worst, float(np.max(np.abs(found - expected), initial=abs(run.state[0] - last[0])))
        )
        compared += found.size
    return {"passed": worst < 1e-6, "breakaways": compared, "worst_difference_s_or_m": worst}


def _extension(rng: np.random.Generator) -> FrictionExtension:
    """Each part or not: levels of the other direction, polynomials of position, dwell, knees,
    memory, boundary lubrication."""

    def maybe(value: Any, otherwise: Any) -> Any:
        return value if rng.random() < 0.6 else otherwise

    def factor() -> tuple[float, ...]:
        return (float(rng.uniform(0.8, 1.2)), *rng.uniform(-0.08, 0.08, 2).tolist())

    coulomb = float(rng.uniform(0.7, 1.3))
    slopes = rng.uniform(0.0, 0.5, 2).tolist()
    return FrictionExtension(
        backward_values=maybe({"coulomb": coulomb, "breakaway": 1.45 * coulomb}, {}),
        forward=maybe(factor(), (1.0,)),
        backward=maybe(factor(), (1.0,)),
        travel=(-1.0, 1.5),
        fresh=float(rng.uniform(0.72, 1.0)),
        rise_time=maybe(float(10.0 ** rng.uniform(-2, 1)), 0.0),
        regimes=maybe(((0.1, slopes[0]), (0.2, slopes[1])), ()),
        lag=maybe(float(10.0 ** rng.uniform(-3.5, -2)), 0.0),
        boundary=maybe(float(rng.uniform(1e-4, 5e-4)), 0.0),
    )


def extended_agrees_with_an_integrator() -> dict[str, Any]:
    """Random extensions and drives from rest against the formulae of
    studies/references/extended_friction.py under DOP853 with events."""
    rng, law, worst, compared = np.random.default_rng(32), LAWS["stribeck"], 0.0, 0
    for _ in range(EXTENDED):
        extension = _extension(rng)
        drive = spring(float(rng.uniform(1.0, 20.0)), float(rng.uniform(0.02, 0.3)))
        if rng.random() < 0.5:
            drive = pid(
                float(rng.uniform(1.0, 6.0)),
                float(rng.uniform(0.0, 6.0)),
                float(rng.uniform(0.5, 6.0)),
                1.0,
            )
        expected, last = Slow(extension, drive).breakaways(8.0)
        run = simulate(body_of(law, law.pack(STRIBECK), MASS, extension), [(8.0, drive)], [8.0])
        found = np.sort(np.concatenate([run.times_of(BREAKS_AWAY), run.times_of(SLIPS_BACK)]))
        if run.status != OK or found.size != len(expected):
            return {
                "passed": False,
                "drive": str(drive),
                "extension": str(extension),
                "found": found.tolist(),
                "expected": expected,
            }
        difference = float(np.max(np.abs(found - expected), initial=abs(run.state[0] - last[0])))
        if difference > 1e-6:
            return {
                "passed": False,
                "drive": str(drive),
                "extension": str(extension),
                "difference_s_or_m": difference,
            }
        worst, compared = max(worst, difference), compared + found.size
    return {"passed": True, "breakaways": compared, "worst_difference_s_or_m": worst}


def limit_cycles() -> dict[str, Any]:
    """300 s of (3.40): half the peak-to-peak of the last 100 s, and the period between passages of
    the target to the same side."""
    figures: dict[str, Any] = {"passed": True}
    for name, (amplitude, period, step, tolerance) in LIMIT_CYCLES.items():
        law = LAWS[name]
        run = run_law(
            law,
            law.pack(TABLE_3_1[name]),
            1.0,
            [(300.0, PID)],
            np.linspace(0.0, 300.0, 300_001),
            LawRunSettings(step=step),
        )
        late = run.position[200_000:] - 1.0
        upwards = np.flatnonzero((late[:-1] < 0.0) & (late[1:] >= 0.0)) / 1e3
        found = (0.5 * float(np.ptp(late)), float(np.mean(np.diff(upwards))))
        figures[name] = {"amplitude_m": found[0], "period_s": found[1]}
        near = (
            abs(found[0] / amplitude - 1.0) < tolerance and abs(found[1] / period - 1.0) < tolerance
        )
        figures["passed"] = figures["passed"] and run.status == OK and near
    return figures


CHECKS = {
    "stick_slip_always_ends": always_ends,
    "stick_slip_agrees_with_an_integrator": agrees_with_an_integrator,
    "stick_slip_extended_agrees_with_an_integrator": extended_agrees_with_an_integrator,
    "limit_cycles_of_the_laws": limit_cycles,
}
