"""The controller once more, in plain Python on named values: slow, and read beside the thesis
rather than beside the program.

Sums are in the order that docs/theory/control.md states, so that it is equal to the program bit by
bit, and not nearly.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from frictool.documents.controller import Controller, FrictionCompensation


def summed(coefficients: Sequence[float], values: Sequence[float]) -> float:
    """From the left, without what is times 0."""
    products = [c * v for c, v in zip(coefficients, values, strict=True) if c != 0.0]
    total = products[0] if products else 0.0
    for product in products[1:]:
        total += product
    return total


def plain_sum(coefficients: Sequence[float], values: Sequence[float]) -> float:
    """From the left, with what is times 0."""
    total = coefficients[0] * values[0]
    for c, v in zip(coefficients[1:], values[1:], strict=True):
        total += c * v
    return total


def within(value: float, low: float, high: float) -> float:
    return high if value > high else low if value < low else value


def saturating(x: float) -> float:
    """s(x) = t - 4/27 t^3, t = x within +-3/2."""
    t = min(max(x, -1.5), 1.5)
    return t - 4.0 / 27.0 * (t * (t * t))


def ramps(speeds: Sequence[float], drives: Sequence[float], speed: float) -> float:
    """A table over the speed, piece by piece; the ends continue."""
    total, last = drives[0], len(speeds) - 2
    for k in range(last + 1):
        inside = speed if k == last else min(speed, speeds[k + 1])
        inside = inside if k == 0 else max(inside, speeds[k])
        slope = (drives[k + 1] - drives[k]) / (speeds[k + 1] - speeds[k])
        total += slope * (inside - speeds[k])
    return total


class PlainController:
    """One axis under a controller document. `mode` is "run", "brake" or "rest"; `scheduled`:
    parameters by name, to be set."""

    def __init__(self, controller: Controller, position: float) -> None:
        self.document, self.period = controller, controller.sample_period_s
        self.mode = "rest"
        self.released = False
        self.r = self.r_last = self.y = position
        self.r_speed = self.r_speed_last = 0.0
        self.tracked = self.tracked_last = position
        self.fed = 0.0
        self.direction = 0.0
        self.line = [position] * 64  # filtered references, the latest first
        self.distance = 0.0
        self.profile_speeds = [0.0] * (
            controller.profile.smoothing_samples - 1 if controller.profile else 0
        )
        self.derived = [0.0] * 3  # lag, speed and acceleration of the state-variable filter
        self.speed = 0.0
        self.stages = [
            (0.0, 0.0)
        ] * controller.velocity.order  # of the low-pass: what entered last, and what left
        self.eta = 0.0
        self.limited = 0
        self.observed = self.found = 0.0
        space = (
            controller.schedule.corners[0].discrete
            if controller.schedule
            else controller.linear.discrete
        )
        self.x = [0.0] * (2 * len(controller.linear.sos) if self.sections else len(space.a))
        self.scheduled: dict[str, float] = {}
        for name in controller.schedule.parameters if controller.schedule else ():
            values = [getattr(corner, name) for corner in controller.schedule.corners]
            self.scheduled[name] = 0.5 * (min(values) + max(values))

    @property
    def filters(self) -> bool:
        """A prefilter or a profile gives the speed of the reference."""
        return self.document.prefilter is not None or self.document.profile is not None

    @property
    def sections(self) -> bool:
        return self.document.linear.form == "sos" and self.document.schedule is None

    def step(self, reference: float, position: float, velocity: float = 0.0) -> float:
        """The drive of this sample."""
        self.follow(reference)
        self.position = position
        self.error = self.tracked - position
        motion = position - self.y
        self.y = position
        self.measure(motion, velocity)
        self.bounds()
        return self.cascade(motion) if self.document.position_law else self.position_loop()

    # what comes before the linear controller

    def follow(self, reference: float) -> None:
        """The filtered reference, the feedforward, and the reference that the loop tracks."""
        last = self.r_last
        self.line = [self.r, *self.line[:-1]]  # the filtered reference 1, 2 ... samples ago
        self.r_speed_last, self.tracked_last = self.r_speed, self.tracked
        if self.document.prefilter is not None:
            self.prefilter(reference)
        elif self.document.profile is not None:
            self.profile(reference)
        else:
            self.r = reference
        self.r_last = reference
        self.tracked = self.r
        if self.document.feedforward is not None:
            self.feedforward(reference - last)

    def profile(self, reference: float) -> None:
        """The braking law, and the mean over the last speeds."""
        own, period = self.document.profile, self.period
        step, half = own.acceleration * period, 0.5 * period
        distance = self.distance + (reference - self.r_last)
        before = self.profile_speeds[0]
        ahead = distance - half * before
        corner = 0.5 * own.acceleration * period
        size = min(abs(ahead), (own.speed + corner) ** 2 / (2.0 * own.acceleration))
        root = math.sqrt(2.0 * own.acceleration * size) - corner
        root = min(1.0 / period * size if size <= corner * period else root, own.speed)
        speed = min(max(-root if ahead < 0.0 else root, before - step), before + step)
        left = distance - half * (before + speed)
        if abs(left) <= step * period / 256.0 and abs(speed) <= step / 256.0:
            speed = left = 0.0
        self.distance = left
        speeds, n = [speed, *self.profile_speeds], own.smoothing_samples
        lags = [period * (n - 1 if k == 0 else 2 * n - 1 - 2 * k) / (2 * n) for k in range(n)]
        self.r = (reference - left) - plain_sum(lags, speeds)
        self.r_speed = plain_sum([1.0 / n] * n, speeds)
        self.profile_speeds = speeds[:-1]

    def feedforward(self, change: float) -> None:
        """Inertia, viscous and Coulomb friction of the sample in which the drive acts."""
        own, actuator = self.document.feedforward, self.document.bench.actuator
        delay = self.document.delay_samples + actuator.loop_time_constant_s / self.period
        if own.filter_rad_s:
            speed, acceleration = self.derivatives(change, (delay + 0.5) * self.period)
        else:
            speed = 0.5 * (self.r_speed + self.r_speed_last)
            acceleration = 1.0 / self.period * (self.r_speed - self.r_speed_last)
            whole, part = math.floor(delay), delay - math.floor(delay)
            self.tracked = self.line[whole]
            if part > 0.0:
                self.tracked += part * (self.line[whole + 1] - self.tracked)
        if speed > own.switch_on_speed:
            self.direction = 1.0
        elif speed < -own.switch_on_speed:
            self.direction = -1.0
        elif abs(speed) < own.switch_off_speed or self.direction * speed <= 0.0:
            self.direction = 0.0
        k = actuator.constant.value
        drive = plain_sum(
            [own.inertia / k, own.viscous / k, own.coulomb / k],
            [acceleration, speed, self.direction],
        )
        self.fed = min(max(drive, -self.document.drive_limit), self.document.drive_limit)

    def derivatives(self, change: float, ahead: float) -> tuple[float, float]:
        """Speed and acceleration `ahead` [s] from now, by the state-variable filter."""
        w, h = self.document.feedforward.filter_rad_s, 0.5 * self.period
        a = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [w**3, -3.0 * w**2, -3.0 * w]])
        left = np.eye(3) - h * a
        rows = np.linalg.solve(left, np.eye(3) + h * a).tolist()
        entry = np.linalg.solve(left, np.array([1.0, 0.0, 0.0])).tolist()
        entering = [change, *self.derived]
        self.derived = [plain_sum([b, *row], entering) for b, row in zip(entry, rows, strict=True)]
        c1, c2 = 3.0 / w + ahead, 3.0 / w**2 + 3.0 * ahead / w + 0.5 * ahead**2
        jerk = (w**3, -3.0 * w**2, -3.0 * w)
        speed = [c2 * jerk[0], 1.0 + c2 * jerk[1], c1 + c2 * jerk[2]]
        acceleration = [c1 * jerk[0], c1 * jerk[1], 1.0 + c1 * jerk[2]]
        return plain_sum(speed, self.derived), plain_sum(acceleration, self.derived)

    def prefilter(self, reference: float) -> None:
        """(5.69) by the trapezoidal rule, solved for the new speed."""
        w, m = self.document.prefilter.natural_frequency_rad_s, self.document.prefilter.damping
        h = 0.5 * self.period
        viscous, elastic = 2.0 * m * w * h, w * w * h * h
        p = (1.0 - viscous - elastic) / (1.0 + viscous + elastic)
        q = w * w * h / (1.0 + viscous + elastic)
        speed = p * self.r_speed + q * ((reference + self.r_last) - 2.0 * self.r)
        self.r += h * (speed + self.r_speed)
        self.r_speed = speed

    def measure(self, motion: float, velocity: float) -> None:
        """The encoder's difference through as many equal low-passes as the order says: (5.70) with
        two."""
        own = self.document.velocity
        if own.source == "measured":
            self.speed = velocity
            return
        self.speed = motion * (1.0 / self.period)
        if own.bandwidth_rad_s > 0.0:
            x = own.bandwidth_rad_s * self.period
            pole, gain = (2.0 - x) / (2.0 + x), x / (2.0 + x)
            for stage, (entered, left) in enumerate(self.stages):
                entering = self.speed
                self.speed = pole * left + gain * (entering + entered)
                self.stages[stage] = entering, self.speed

    def bounds(self) -> None:
        """|u| <= limit, and |R i + K v| <= V."""
        limit, actuator = self.document.drive_limit, self.document.bench.actuator
        self.low, self.high = -limit, limit
        if actuator.winding is not None:
            resistance, voltage = actuator.winding.resistance_ohm, actuator.winding.voltage_v
            stall, back = voltage / resistance, actuator.constant.value / resistance * self.speed
            self.low, self.high = (
                max(-limit, min(limit, -stall - back)),
                min(limit, max(-limit, stall - back)),
            )

    # the two structures

    def cascade(self, motion: float) -> float:
        law = self.document.position_law
        self.mode = self.next_mode() if law.action != "none" else "run"
        wanted = self.wanted_speed()
        if self.document.feedforward is not None:
            wanted += 1.0 / self.period * (self.tracked - self.tracked_last)
        wanted = wanted if self.mode != "brake" else 0.0
        if self.document.linear.input == "speed_error":
            return self.linear(wanted - self.speed)
        change = self.period * wanted - motion
        eta = self.eta if self.limited * change > 0.0 else self.eta + change
        drive = self.linear(eta)
        self.eta = 0.0 if self.mode == "rest" else eta
        return drive

    def next_mode(self) -> str:
        law = self.document.position_law
        moving = (
            law.settled_speed is not None
            and self.filters
            and abs(self.r_speed) >= law.settled_speed
        )
        if abs(self.error) > law.band or moving:
            return "run"
        stops = law.action == "cut" or self.mode == "rest" or abs(self.speed) < law.rest_speed
        return "rest" if stops else "brake"

    def wanted_speed(self) -> float:
        """(5.19), and inside its band the straight line to its edges; or a gain."""
        law = self.document.position_law
        if law.kind == "proportional":
            return law.gain * self.error
        if abs(self.error) <= law.band:
            return law.gain / math.sqrt(law.band) * self.error
        return math.copysign(law.gain * math.sqrt(abs(self.error)), self.error)

    def position_loop(self) -> float:
        self.mode = "run"
        self.released = self.is_released()
        return self.linear(self.error)

    def is_released(self) -> bool:
        own = self.document.limiter
        if own is None:
            return False
        path = 0.0
        if own.condition == "energy":
            path = (
                0.5 * own.inertia / (own.coulomb + own.virtual_coulomb) * (self.speed * self.speed)
            )
        if (
            own.settled_speed is not None
            and self.filters
            and abs(self.r_speed) >= own.settled_speed
        ):
            return False
        return abs(abs(self.error) - path) < own.band  # (5.7)

    def brake(self) -> float:
        """(5.41), inside the band."""
        own = self.document.limiter
        if own is None or own.virtual_coulomb == 0.0:
            return 0.0
        torque = (
            own.virtual_coulomb
            / self.document.bench.actuator.constant.value
            * saturating(1.0 / own.virtual_speed * self.speed)
        )
        return within(-torque, self.low, self.high)

    # the linear controller, and what is added

    def compensation(self) -> float:
        own, constant = (
            self.document.friction_compensation,
            self.document.bench.actuator.constant.value,
        )
        if own is None:
            return 0.0
        if own.source == "model":
            speed = self.speed
            if own.velocity == "reference":
                speed = self.r_speed if self.filters else 0.0
            sign = saturating(1.0 / own.smoothing_speed * speed)
            if own.speeds:
                drives = [own.gain * effort / constant for effort in own.efforts]
                added = ramps(own.speeds, drives, speed)
            else:
                dry = own.gain * own.coulomb / constant * sign
                added = dry + own.gain * own.viscous / constant * speed
            return added + self.change(own, sign) if own.positions else added
        carried = own.observer_rad_s * (own.inertia / constant) * self.speed
        self.found = min(
            max(self.observed - carried, -self.document.drive_limit), self.document.drive_limit
        )
        return own.gain * self.found

    def change(self, own: FrictionCompensation, sign: float) -> float:
        """Drive for the Coulomb friction at the position minus its mean."""
        constant = self.document.bench.actuator.constant.value
        at = self.tracked if own.velocity == "reference" else self.position
        at = within(at, own.positions[0], own.positions[-1])
        ahead, back = (
            ramps(own.positions, [own.gain * effort / constant for effort in side], at)
            for side in (own.forward, own.backward or own.forward)
        )
        if not own.backward or own.backward == own.forward:
            return sign * ahead
        return max(sign, 0.0) * ahead + min(sign, 0.0) * back

    def linear(self, entering: float) -> float:
        added = self.compensation()
        drive, left = (
            self.chain(entering) if self.sections else (self.equation_output(entering), [])
        )
        drive = drive + self.fed if self.document.feedforward is not None else drive
        drive = drive + added if self.document.friction_compensation is not None else drive
        limited = within(drive, self.low, self.high)
        met = (drive > self.high) - (drive < self.low)
        excess = 0.0 if self.released else limited - drive
        applied = 0.0 if self.mode == "rest" else self.brake() if self.released else limited
        if self.sections:
            self.advance_chain(entering, left, excess)
        else:
            self.advance_equation(entering, excess, met)
        self.limited = 0 if self.mode == "rest" else met
        own = self.document.friction_compensation
        if own is not None and own.source == "observer":
            self.observed += own.observer_rad_s * self.period * (applied - self.found)
        return applied

    def coefficients(
        self,
    ) -> tuple[list[list[float]], list[float], list[float], float, list[float]]:
        """(a, b, c, d, l) at this sample: the document's, or the sum over the corners (5.64)."""
        spaces, gains = [self.document.linear.discrete], [self.document.linear.anti_windup]
        weights = [1.0]
        if self.document.schedule is not None:
            corners = self.document.schedule.corners
            spaces, gains, weights = (
                [one.discrete for one in corners],
                [one.anti_windup for one in corners],
                self.weights(),
            )

        def total(values: Sequence[float]) -> float:
            return (
                values[0]
                if all(value == values[0] for value in values)
                else summed_all(values, weights)
            )

        n = len(spaces[0].a)
        a = [[total([s.a[i][j] for s in spaces]) for j in range(n)] for i in range(n)]
        b, c = (
            [total([s.b[i][0] for s in spaces]) for i in range(n)],
            [total([s.c[0][i] for s in spaces]) for i in range(n)],
        )
        return (
            a,
            b,
            c,
            total([s.d[0][0] for s in spaces]),
            [total([one[i] for one in gains]) for i in range(n)],
        )

    def weights(self) -> list[float]:
        """alpha_i of (5.46)."""
        corners, found = self.document.schedule.corners, []
        for corner in corners:
            product = 1.0
            for name in self.document.schedule.parameters:
                values = [getattr(one, name) for one in corners]
                low, high = min(values), max(values)
                if high > low:
                    share = (min(max(self.scheduled[name], low), high) - low) * (1.0 / (high - low))
                    product *= share if getattr(corner, name) == high else 1.0 - share
            found.append(product)
        return found

    def equation_output(self, entering: float) -> float:
        _, _, c, d, _ = self.coefficients()
        return summed([d, *c], [entering, *self.x])

    def advance_equation(self, entering: float, excess: float, met: int) -> None:
        own = self.document.linear
        a, b, _, _, gains = self.coefficients()
        schedule, x = self.document.schedule, []
        spaces = [one.discrete for one in schedule.corners] if schedule else [own.discrete]
        for i in range(len(b)):
            rows = [space.a[i] for space in spaces]
            integrator = all(
                row[i] == 1.0 and sum(value != 0.0 for value in row) == 1 for row in rows
            )
            holds = own.conditional and (met * entering > 0.0 or self.mode == "rest")
            if integrator and (holds or self.released):
                x.append(self.x[i])
            elif self.mode == "rest" and not (integrator and own.conditional):
                x.append(0.0)
            else:
                x.append(summed([b[i], gains[i], *a[i]], [entering, excess, *self.x]))
        self.x = x

    def chain(self, entering: float) -> tuple[float, list[tuple[float, float]]]:
        """The sections' output, and what enters and leaves each."""
        passed, signal = [], entering
        for k, (b0, *_) in enumerate(self.document.linear.sos):
            leaving = b0 * signal + self.x[2 * k]
            passed.append((signal, leaving))
            signal = leaving
        return signal, passed

    def advance_chain(
        self, entering: float, passed: list[tuple[float, float]], excess: float
    ) -> None:
        gains, x = self.document.linear.sos_anti_windup, []
        for k, ((_, b1, b2, _, a1, a2), (e, y)) in enumerate(
            zip(self.document.linear.sos, passed, strict=True)
        ):
            one, two = b1 * e - a1 * y + self.x[2 * k + 1], b2 * e - a2 * y
            for value, gain in ((one, gains[2 * k]), (two, gains[2 * k + 1])):
                value = value + gain * excess if gain != 0.0 else value
                x.append(0.0 if self.mode == "rest" else value)
        self.x = x


def summed_all(values: Sequence[float], weights: Sequence[float]) -> float:
    total = values[0] * weights[0]
    for value, weight in zip(values[1:], weights[1:], strict=True):
        total += value * weight
    return total
