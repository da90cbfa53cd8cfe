"""A screw and its nut against a spring, from its own free bodies, by scipy: what the engine is
compared with (thesis 2.1.6).

    J w' = u - rho f - s L        M v' = f - K x        x = rho theta, v = rho w, rho = r tan(alpha)
                                  (2.10)-(2.11)

f: what the thread gives the nut; s the direction of slip; L >= 0 what the thread loses, brought to
the screw. Of a square thread, whose normal force follows from both free bodies (the textbook's
raising and lowering torques):

    L = r (tan(alpha + phi) - tan(alpha)) |f|   where the screw drives the nut (f s > 0)
    L = r (tan(alpha) - tan(alpha - phi)) |f|   where the nut drives the screw                  phi
                                                = atan(mu)

As printed in (2.12): L = mu |r f - u tan(alpha)|.

f holds M v' and L holds f, so that w' solves a piecewise linear equation; at rest it sticks where
neither direction would start.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from frictool.typing import Vector

Torque = Callable[[float], float]


@dataclass(frozen=True)
class Screw:
    """J [kg m2], M [kg], r [m], tan(alpha), mu, K [N/m]; thesis: (2.12) in place of the square
    thread."""

    inertia: float
    mass: float
    radius: float
    steep: float
    friction: float
    stiffness: float
    thesis: bool = False

    @property
    def way(self) -> float:
        """rho, of the nut per radian [m]."""
        return self.radius * self.steep

    @property
    def driving(self) -> float:
        """Torque on the screw that moves the nut by a unit of its force, all told [m]."""
        alpha, phi = math.atan(self.steep), math.atan(self.friction)
        return self.radius * math.tan(alpha + phi)

    @property
    def driven(self) -> float:
        """Torque that a unit of the nut's force gives the screw [m]; below 0 the nut cannot drive
        it."""
        alpha, phi = math.atan(self.steep), math.atan(self.friction)
        return self.radius * math.tan(alpha - phi)

    def acceleration(self, theta: float, torque: float, direction: int) -> float:
        """w' in slip [rad/s2]: of the linear pieces the one that agrees with itself."""
        found = []
        for side in (1, -1):  # the sign of what stands between the bars
            # L = side (force f + push u), linear in f
            if self.thesis:
                force, push = self.friction * self.radius * side, -self.friction * self.steep * side
            else:
                loss = self.driving - self.way if side * direction > 0 else self.way - self.driven
                force, push = loss * side, 0.0
            # J w' = u - way f - direction (force f + push u), f = M way w' + K way theta
            taken = self.way + direction * force
            spring = self.stiffness * self.way * theta
            rate = (torque * (1.0 - direction * push) - taken * spring) / (
                self.inertia + taken * self.mass * self.way
            )
            between = self._between(self.mass * self.way * rate + spring, torque)
            found.append((side * between, rate))
        return max(found)[1]

    def _between(self, force: float, torque: float) -> float:
        return self.radius * force - torque * self.steep if self.thesis else force

    def starts(self, theta: float, torque: float) -> int:
        """The direction in which it leaves rest, or 0."""
        return next(
            (way for way in (1, -1) if way * self.acceleration(theta, torque, way) > 0.0), 0
        )

    def trajectory(
        self, torque: Torque, theta: float, times: Vector, breaks: tuple[float, ...] = ()
    ) -> tuple[Vector, Vector]:
        """theta [rad], w [rad/s] at `times` from rest at theta; `breaks`: where the torque
        jumps."""
        angle, speed = np.empty_like(times), np.empty_like(times)
        now, state, direction = float(times[0]), np.array([theta, 0.0]), 0
        cuts = [*sorted(one for one in breaks if one > now), float(times[-1])]
        while now < times[-1]:
            end = next(one for one in cuts if one > now)
            if direction == 0:
                direction = self.starts(state[0], torque(now))
            part = (
                self._slip(torque, now, end, state, direction)
                if direction
                else self._rest(torque, now, end, state)
            )
            inside = (times >= now) & (times <= part.t[-1])
            if inside.any():
                angle[inside], speed[inside] = part.sol(times[inside])
            now, state = float(part.t[-1]), part.y[:, -1].copy()
            if part.status == 1:  # stopped, or broke away
                state[1] = 0.0
                direction = self.starts(
                    state[0], torque(now if direction else now + 1e-9)
                )  # just past the breakaway
        return angle, speed

    def _slip(self, torque: Torque, now: float, end: float, state: Vector, direction: int):
        def field(t: float, y: Vector) -> list[float]:
            return [y[1], self.acceleration(y[0], torque(t), direction)]

        def stops(t: float, y: Vector) -> float:
            return y[1] * direction if t > now + 1e-9 else 1.0

        stops.terminal, stops.direction = True, -1
        return solve_ivp(
            field,
            (now, end),
            state,
            events=stops,
            rtol=1e-10,
            atol=1e-12,
            max_step=2e-3,
            dense_output=True,
        )

    def _rest(self, torque: Torque, now: float, end: float, state: Vector):
        def still(t: float, y: Vector) -> list[float]:
            return [0.0, 0.0]

        def breaks_away(t: float, y: Vector) -> float:
            forward, backward = (self.acceleration(y[0], torque(t), way) * way for way in (1, -1))
            return max(forward, backward)

        breaks_away.terminal, breaks_away.direction = True, 1
        return solve_ivp(
            still,
            (now, end),
            state,
            events=breaks_away,
            rtol=1e-10,
            atol=1e-12,
            max_step=2e-3,
            dense_output=True,
        )


SCREW = """
blocks:
  screw: {{inertia: {{value: 2.0e-5, unit: kg m^2}}}}
  nut: {{mass: {{value: 1, unit: kg}}}}
links:
  thread:
    kind: screw
    between: [screw, nut]
    radius: {{value: 6, unit: mm}}
    lead_angle: {{value: {angle!r}, unit: rad}}
    friction_coefficient: {mu!r}
    friction_form: {form}
  spring: {{kind: spring, between: [nut, ground], stiffness: {{value: 20, unit: N/mm}},
    preload: {{value: 100, unit: N}}}}
sources:
  torque: {{on: screw, drive: effort}}
"""
