"""Slow simulation of an extended Stribeck body: scipy's DOP853 in slip, a root finder at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from frictool.engine.drive import EffortFunction, effort, reference
from frictool.friction.law_extension import FrictionExtension
from frictool.typing import Vector
from studies.rigs.table_3_1 import STRIBECK

MASS = 1.0


@dataclass
class Slow:
    """Simulation of an extension of table 3.1's Stribeck law under a drive."""

    extension: FrictionExtension
    drive: EffortFunction
    step: float = 2e-3  # s, largest step; a fast body passes the layer in a short time

    def levels(self, x: float, direction: float, rested: float) -> tuple[float, float, float]:
        """Return (F_c, F_s, sigma_v) at a position, for a direction and a time at rest."""
        e, values = (
            self.extension,
            {**STRIBECK, **(self.extension.backward_values if direction < 0.0 else {})},
        )
        place = min(max(x, e.travel[0]), e.travel[1])
        powers = enumerate(e.forward if direction > 0.0 else e.backward)
        factor = sum(coefficient * place**power for power, coefficient in powers)
        grown = (
            1.0 - (1.0 - e.fresh) * e.rise_time / (e.rise_time + rested)
            if e.rise_time > 0.0
            else 1.0
        )
        return values["coulomb"] * factor, values["breakaway"] * factor * grown, values["viscous"]

    def curve(self, x: float, direction: float, rested: float, w: float) -> float:
        """Return the dry friction at the lagged velocity."""
        coulomb, breakaway, _ = self.levels(x, direction, rested)
        film = max(0.0, abs(w) - self.extension.boundary)
        return coulomb + (breakaway - coulomb) * math.exp(
            -((film / STRIBECK["stribeck_velocity"]) ** 2)
        )

    def friction(self, x: float, v: float, w: float, direction: float, rested: float) -> float:
        added = sum(
            slope * max(0.0, direction * v - knee) for knee, slope in self.extension.regimes
        )
        return (
            direction * (self.curve(x, direction, rested, w) + added)
            + self.levels(x, direction, rested)[2] * v
        )

    def slip(
        self, t: float, end: float, y: Vector, direction: float, rested: float
    ) -> tuple[float, Vector, bool]:
        array, lag = self.drive.as_array(), self.extension.lag

        def field(at: float, now: Vector) -> list[float]:
            x, v, q, w = now.tolist()
            seen = w if lag > 0.0 else v
            u = effort(at, x, v, q, array)
            return [
                v,
                (u - self.friction(x, v, seen, direction, rested)) / MASS,
                x - reference(at, array),
                (v - w) / lag if lag else 0.0,
            ]

        def speed(_: float, now: Vector) -> float:
            return direction * float(now[1])

        stop: Any = speed
        stop.terminal, stop.direction = True, -1
        run = solve_ivp(
            field,
            (t, end),
            y,
            method="DOP853",
            rtol=1e-10,
            atol=1e-13,
            max_step=self.step,
            events=stop,
        )
        return float(run.t[-1]), run.y[:, -1], bool(run.t_events[0].size)

    def rest(self, t: float, end: float, y: Vector) -> tuple[float, float]:
        """Return time and direction of the breakaway of a body that rests from t on.

        Return (end, 0) without a breakaway before `end`.
        """
        array, lag = self.drive.as_array(), self.extension.lag
        x, _, q, w = y.tolist()

        def gap(at: float, direction: float) -> float:
            moved = (x - self.drive.target) * (at - t) - 0.5 * self.drive.target_speed * (
                at * at - t * t
            )
            left = w * math.exp(-(at - t) / lag) if lag else 0.0
            return self.curve(x, direction, at - t, left) - direction * effort(
                at, x, 0.0, q + moved, array
            )

        grid = np.linspace(t, end, 2001)
        for before, after in zip(grid[:-1].tolist(), grid[1:].tolist(), strict=True):
            for direction in (-1.0, 1.0):
                if gap(before, direction) < 0.0:
                    return before, direction
                if gap(after, direction) < 0.0:
                    return float(brentq(gap, before, after, (direction,), xtol=1e-14)), direction
        return end, 0.0

    def breakaways(self, end: float) -> tuple[list[float], Vector]:
        """Return the breakaway times from rest at 0 up to `end`, and the state at `end`.

        The state is position, velocity, integral of the position error, and lagged velocity.
        """
        t, y, found, lag = 0.0, np.zeros(4), [], self.extension.lag
        while t < end:
            later, direction = self.rest(t, end, y)
            moved = (y[0] - self.drive.target) * (later - t) - 0.5 * self.drive.target_speed * (
                later**2 - t**2
            )
            y = np.array(
                [y[0], 0.0, y[2] + moved, y[3] * math.exp(-(later - t) / lag) if lag else 0.0]
            )
            rested, t = later - t, later
            if direction == 0.0:
                break
            found.append(t)
            t, y, stopped = self.slip(t, end, y, direction, rested)
            if stopped:
                y[1] = 0.0
        return found, y
