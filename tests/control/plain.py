"""The controller once more, in plain Python on named values: slow, and read beside the thesis rather than beside the kernels."""

from __future__ import annotations

import math

from frictool.documents.controller import Controller


class PlainController:
    """One axis under a controller document. `mode` is "run", "brake" or "rest"."""

    def __init__(self, controller: Controller, position: float) -> None:
        self.document = controller
        self.mode = "rest"
        self.r = self.r_last = position
        self.r_speed = 0.0
        self.y = position
        self.speed = self.difference = 0.0
        self.eta = 0.0
        self.limited = 0
        self.x = [0.0] * len(controller.linear.discrete.a)

    def step(self, reference: float, position: float) -> float:
        law, period = self.document.position_law, self.document.sample_period_s
        self.prefilter(reference)
        error = self.r - position
        motion = position - self.y
        self.y = position
        self.measure(motion)
        inside = abs(error) <= law.band and abs(self.r_speed) < law.settled_speed
        if not inside:
            self.mode = "run"
        elif law.action == "cut" or self.mode == "rest" or abs(self.speed) < law.rest_speed:
            self.mode = "rest"
        else:
            self.mode = "brake"
        if self.mode == "rest":
            self.x = [0.0] * len(self.x)
            self.eta, self.limited = 0.0, 0
            return 0.0
        return self.speed_loop(period * self.wanted_speed(error) if self.mode == "run" else 0.0, motion)

    def wanted_speed(self, error: float) -> float:
        """(5.19), and inside its band the straight line to its edges."""
        law = self.document.position_law
        if abs(error) <= law.band:
            return law.gain / math.sqrt(law.band) * error
        return math.copysign(law.gain * math.sqrt(abs(error)), error)

    def prefilter(self, reference: float) -> None:
        """(5.69) by the trapezoidal rule, solved for the new speed."""
        if self.document.prefilter is None:
            self.r = reference
            return
        w, m = self.document.prefilter.natural_frequency_rad_s, self.document.prefilter.damping
        h = 0.5 * self.document.sample_period_s
        viscous, elastic = 2.0 * m * w * h, w * w * h * h
        p = (1.0 - viscous - elastic) / (1.0 + viscous + elastic)
        q = w * w * h / (1.0 + viscous + elastic)
        speed = p * self.r_speed + q * ((reference + self.r_last) - 2.0 * self.r)
        self.r += h * (speed + self.r_speed)
        self.r_speed, self.r_last = speed, reference

    def measure(self, motion: float) -> None:
        bandwidth, period = self.document.velocity.bandwidth_rad_s, self.document.sample_period_s
        difference = motion * (1.0 / period)
        if bandwidth == 0.0:
            self.speed = difference
        else:
            x = bandwidth * period
            pole, gain = (2.0 - x) / (2.0 + x), x / (2.0 + x)
            self.speed = pole * self.speed + gain * difference + gain * self.difference
        self.difference = difference

    def speed_loop(self, increment: float, motion: float) -> float:
        k, anti_windup = self.document.linear.discrete, self.document.linear.anti_windup
        change = increment - motion
        if self.limited * change <= 0.0:
            self.eta += change
        drive = k.d[0][0] * self.eta
        for c, x in zip(k.c[0], self.x, strict=True):
            drive += c * x
        bound = self.document.drive_limit
        limited = min(max(drive, -bound), bound)
        self.limited = (drive > bound) - (drive < -bound)
        self.x = [self.row(i, drive, limited, anti_windup[i]) for i in range(len(self.x))]
        return limited

    def row(self, i: int, drive: float, limited: float, anti_windup: float) -> float:
        k = self.document.linear.discrete
        value = k.b[i][0] * self.eta + anti_windup * (limited - drive)
        for a, x in zip(k.a[i], self.x, strict=True):
            value += a * x
        return value
