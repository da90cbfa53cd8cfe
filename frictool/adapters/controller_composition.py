"""Conversion of a controller document to the program that runs on the target hardware.

    speed_cascade   reference ─▶ prefilter ─▶ e = filtered - y ─▶ position law, band ─▶ omega_c
                    ─▶ eta = integral(omega_c) - y ─▶ linear controller ─▶ drive stages
    position        reference ─▶ prefilter ─▶ e = filtered - y ─▶ linear controller
                    ─▶ drive stages, with limiter and virtual friction (thesis, (5.7), (5.41))
    drive stages    ─▶ feedforward, friction compensation ─▶ limit ─▶ anti-windup ─▶ drive

y is the measured position, omega_c the speed reference. The band is an interval of e around 0 in
which the drive is set to 0 (control/target_band.py). The limiter sets the drive to 0 or to the
virtual friction (control/limit_cycle_limiter.py). A profile replaces the prefilter. With a
feedforward, the filtered reference in e is delayed by the number of samples after which the drive
acts. A cascade then adds the speed of this delayed reference to omega_c. A linear controller with
the input `speed_error` takes omega_c minus the measured speed instead of eta.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from frictool.adapters.observer_composition import observer_block, reach, top_speed
from frictool.control import (
    difference_equation,
    drive_limit,
    friction_compensation,
    limit_cycle_limiter,
    second_order_sections,
)
from frictool.control import target_band as bands
from frictool.control.difference_equation import DifferenceEquation, state_bounds
from frictool.control.drive_model import mean_effort
from frictool.control.effort_feedforward import (
    FeedforwardGains,
    delayed,
    feedforward,
    sample_motion,
)
from frictool.control.eta_integral import next_eta
from frictool.control.gain_schedule import corner_weights, weighted_coefficients
from frictool.control.jerk_limited_profile import ProfileLimits, profile
from frictool.control.measurement_guard import write_guard
from frictool.control.position_law import proportional_law, square_root_law
from frictool.control.prefilter import prefilter
from frictool.control.program import Program, ProgramNode
from frictool.control.reference_derivatives import reference_derivatives
from frictool.control.speed_filter import velocity
from frictool.documents.controller import Controller, FrictionCompensation, Profile, StateSpace

ETA_WIDTHS = 2.0  # bound of |eta| in widths of the position range


def controller_program(controller: Controller) -> Program:
    """Return the program of a controller document."""
    return _Composition(controller).program


def uses_speed(controller: Controller) -> bool:
    """Return True if a block of the controller uses the measured or estimated speed."""
    law, limiter, compensation = (
        controller.position_law,
        controller.limiter,
        controller.friction_compensation,
    )
    return (
        controller.linear.input == "speed_error"
        or (law is not None and law.action == "brake")
        or (
            limiter is not None and (limiter.condition == "energy" or limiter.virtual_coulomb > 0.0)
        )
        or (
            compensation is not None
            and not (compensation.source == "model" and compensation.velocity == "reference")
        )
        or controller.bench.actuator.winding is not None
    )


def profile_limits(settings: Profile) -> ProfileLimits:
    """Return the limits of speed, acceleration and smoothing in a document's profile."""
    return ProfileLimits(settings.speed, settings.acceleration, settings.smoothing_samples)


class _Composition:
    """The document's blocks, written into one program in the order in which they run."""

    def __init__(self, controller: Controller) -> None:
        self.document = controller
        self.period = controller.sample_period_s
        self.program = Program()
        self.low, self.high = reach(controller.bench)
        program = self.program
        guard = write_guard(program, self._inputs(), controller.measurement_hold_samples)
        self.fault = guard.fault
        self.sensed = guard.used.get("velocity")
        self.reference, self.position = guard.used["reference"], guard.used["position"]
        self.zero = program.constant(0.0)
        self.speed_reference: ProgramNode | None = None
        filtered = self.reference
        if controller.prefilter is not None:
            settings = controller.prefilter
            filtered, self.speed_reference = prefilter(
                program,
                self.reference,
                settings.natural_frequency_rad_s,
                settings.damping,
                self.period,
            )
        elif controller.profile is not None:
            filtered, self.speed_reference = profile(
                program, self.reference, profile_limits(controller.profile), self.period
            )
        self.fed, self.tracked = self._feedforward(filtered)
        if controller.profile is not None:
            program.profile = self.tracked
        program.block("position error, and the position's difference")
        self.error = program.named("error", self.tracked - self.position)
        self.move: Callable[[ProgramNode], None] | None = None
        self.motion, self.speed = self._motion()
        self.program.speed = self.speed
        self._low_high()
        if controller.structure == "speed_cascade":
            self._cascade()
        else:
            self._position()
        self._observe()

    def _feedforward(self, filtered: ProgramNode) -> tuple[ProgramNode | None, ProgramNode]:
        """Return (drive of the feedforward or None, reference that the position loop tracks)."""
        settings = self.document.feedforward
        if settings is None:
            return None, filtered
        actuator = self.document.bench.actuator
        constant = actuator.constant.value
        lag = self.document.delay_samples + actuator.loop_time_constant_s / self.period
        if self.speed_reference is None:
            tracked = filtered
            speed, acceleration = reference_derivatives(
                self.program,
                filtered,
                settings.filter_rad_s,
                (lag + 0.5) * self.period,
                self.period,
            )
        else:
            speed, acceleration = sample_motion(self.program, self.speed_reference, self.period)
            tracked = delayed(self.program, 1.0 + lag)
        gains = FeedforwardGains(
            settings.inertia / constant,
            settings.viscous / constant,
            settings.coulomb / constant,
            settings.switch_on_speed,
            settings.switch_off_speed,
        )
        most = self.document.drive_limit
        return feedforward(self.program, speed, acceleration, gains, most), tracked

    def _tracked_speed(self) -> ProgramNode:
        program = self.program
        program.block("speed of the tracked reference")
        before = program.states["reference_before"]
        if self.tracked is not self.reference:
            line = program.states["filtered_before"]
            before = program.state("tracked_before", line.low, line.high, start="position")
            program.update("tracked_before", self.tracked)
        return program.constant(1.0 / self.period, "rate") * (self.tracked - before)

    def _inputs(self) -> dict[str, ProgramNode]:
        inputs = {
            name: self.program.input(name, self.low, self.high)
            for name in ("reference", "position")
        }
        if self.document.velocity.source == "measured":
            bound = top_speed(self.document.bench)
            inputs["velocity"] = self.program.input("velocity", -bound, bound)
        return inputs

    def _observe(self) -> None:
        if self.move is not None:
            assert self.program.output is not None
            document = self.document
            actuator = self.document.bench.actuator
            drive = document.drive_limit, document.delay_samples, actuator.loop_time_constant_s
            self.move(
                mean_effort(
                    self.program, self.program.output, actuator.constant.value, *drive, self.period
                )
            )

    def _motion(self) -> tuple[ProgramNode | None, ProgramNode | None]:
        """Return the change of the position since the last sample, and the speed.

        A value that no block uses is None.
        """
        settings = self.document.velocity
        program = self.program
        measured = None
        if settings.observer is not None and uses_speed(self.document):
            estimates, self.move = observer_block(program, self.position, settings.observer)
            measured = estimates.velocity
        elif settings.source == "measured":
            measured = self.sensed
        derives = measured is None and uses_speed(self.document)
        if not derives and not (
            self.document.structure == "speed_cascade" and self.document.linear.input == "eta"
        ):
            return None, measured
        motion = program.named(
            "motion", self.position - program.last("position", self.position, "position")
        )
        if not derives:
            return motion, measured
        return motion, velocity(
            program, motion, self.period, settings.bandwidth_rad_s, settings.order
        )

    def _low_high(self) -> None:
        bench = self.document.bench.actuator
        winding = (
            None
            if bench.winding is None
            else (bench.winding.resistance_ohm, bench.constant.value, bench.winding.voltage_v)
        )
        self.drive_low, self.drive_high = drive_limit.bounds(
            self.program, self.document.drive_limit, winding, self.speed
        )

    def _cascade(self) -> None:
        document, program = self.document, self.program
        law = document.position_law
        assert law is not None  # checked with the document
        edge = program.constant(law.band, "band")
        resting = running = None
        if law.action != "none":
            program.block(
                "the band around the target, where the drive becomes zero after the prefilter has "
                "settled"
            )
            inside = bands.is_settled(
                program, self.error, edge, self.speed_reference, law.settled_speed
            )
            mode = bands.next_mode(
                program, inside, self.speed if law.action == "brake" else None, law.rest_speed
            )
            resting = program.named("resting", mode >= program.constant(bands.REST))
            running = (
                program.named("running", mode <= program.constant(bands.RUN))
                if law.action == "brake"
                else None
            )
        wanted = (
            square_root_law(program, self.error, law.gain, edge)
            if law.kind == "square_root"
            else proportional_law(program, self.error, law.gain)
        )
        if self.fed is not None:
            wanted = wanted + self._tracked_speed()
        if running is not None:
            wanted = program.select(running, wanted, self.zero)
        if document.linear.input == "speed_error":
            assert self.speed is not None
            entering = program.named("speed_error", wanted - self.speed)
            widest = 2.0 * self._speed_reach(law.gain, law.kind)
        else:
            assert self.motion is not None
            widest = ETA_WIDTHS * (self.high - self.low)
            limited_before = program.state("limited_before", -1.0, 1.0)
            increment = program.constant(self.period, "period") * wanted
            entering = next_eta(program, increment, self.motion, limited_before, resting, widest)
        self._linear(entering, widest, resting, None, self.zero)
        program.names.setdefault(entering.index, "entering")

    def _speed_reach(self, gain: float, kind: str) -> float:
        width = self.high - self.low
        return gain * (math.sqrt(width) if kind == "square_root" else width)

    def _position(self) -> None:
        document = self.document
        program = self.program
        limiter = self.document.limiter
        released = None
        braking = self.zero
        if limiter is not None:
            if limiter.condition == "energy":
                assert self.speed is not None
                friction = limiter.coulomb + limiter.virtual_coulomb
                released = limit_cycle_limiter.energy_released(
                    program, self.error, self.speed, limiter.band, limiter.inertia, friction
                )
            else:
                released = limit_cycle_limiter.error_released(program, self.error, limiter.band)
            if limiter.settled_speed is not None and self.speed_reference is not None:
                slow = abs(self.speed_reference) < program.constant(
                    limiter.settled_speed, "settled_speed"
                )
                released = program.named("released_and_settled", released & slow)
            if limiter.virtual_coulomb > 0.0:
                assert self.speed is not None
                per_virtual = limiter.virtual_coulomb / document.bench.actuator.constant.value
                braking = limit_cycle_limiter.virtual_friction(
                    program, self.speed, per_virtual, limiter.virtual_speed
                )
        self._linear(self.error, self.high - self.low, None, released, braking)

    def _compensation(self) -> tuple[ProgramNode | None, ProgramNode | None]:
        """Return the drive that compensates friction, and the observed friction.

        A value that no block uses is None.
        """
        settings = self.document.friction_compensation
        program = self.program
        if settings is None:
            return None, None
        constant = self.document.bench.actuator.constant.value
        if settings.source == "model":
            by_reference = settings.velocity == "reference"
            speed = self.speed_reference if by_reference else self.speed
            return self._modelled_friction(
                settings,
                self.zero if speed is None else speed,
                self.tracked if by_reference else self.position,
            ), None
        assert self.speed is not None
        limit = self.document.drive_limit
        return friction_compensation.observer_compensation(
            program,
            self.speed,
            settings.observer_rad_s,
            settings.inertia / constant,
            settings.gain,
            limit,
        )

    def _modelled_friction(
        self, settings: FrictionCompensation, speed: ProgramNode, position: ProgramNode
    ) -> ProgramNode:
        program = self.program
        constant = self.document.bench.actuator.constant.value

        def drives(efforts: Sequence[float]) -> list[float]:
            return [settings.gain * effort / constant for effort in efforts]

        if settings.speeds:
            drive = friction_compensation.curve_compensation(
                program, speed, settings.speeds, drives(settings.efforts)
            )
        else:
            coulomb, viscous = drives((settings.coulomb, settings.viscous))
            drive = friction_compensation.model_compensation(
                program, speed, coulomb, viscous, settings.smoothing_speed
            )
        if not settings.positions:
            return drive
        change = friction_compensation.position_compensation(
            program,
            position,
            friction_compensation.direction(program, speed, settings.smoothing_speed),
            settings.positions,
            drives(settings.forward),
            drives(settings.backward or settings.forward),
        )
        return program.named("compensation_at_position", drive + change)

    def _linear(
        self,
        entering: ProgramNode,
        widest: float,
        resting: ProgramNode | None,
        released: ProgramNode | None,
        braking: ProgramNode,
    ) -> None:
        linear = self.document.linear
        program = self.program
        compensation, observed = self._compensation()
        equation = _equation(linear.discrete, linear.anti_windup)
        chain = linear.sos if linear.form == "sos" and self.document.schedule is None else None
        if chain is not None:
            a, b, c, d = second_order_sections.chain_state_space(chain)
            chain_equation = DifferenceEquation(a, b, c, d, np.array(linear.sos_anti_windup))
            drive, passed = second_order_sections.output(
                program,
                chain,
                entering,
                state_bounds(chain_equation, widest, self.document.drive_limit, False),
            )
        else:
            equations = self._equations(equation)
            bound = np.max(
                [
                    state_bounds(one, widest, self.document.drive_limit, linear.conditional)
                    for one in equations
                ],
                axis=0,
            )
            if self.document.schedule is not None:
                bound = np.full(
                    len(bound), np.inf
                )  # the bounds of the corners do not hold between the corners
                k = weighted_coefficients(program, equations, self._weights())
            else:
                k = difference_equation.coefficients(program, equation)
            drive = difference_equation.output(program, k, entering, bound)
        for added in (self.fed, compensation):
            if added is not None:
                drive = program.named("drive", drive + added)
        limited, met = drive_limit.limit(program, drive, self.drive_low, self.drive_high)
        excess = program.named("excess", limited - drive)
        hold = None
        if linear.conditional:
            program.block("conditional integration")
            hold = program.named("held", met * entering > self.zero)
        applied = limited
        if released is not None:
            braked, _ = (
                drive_limit.limit(program, braking, self.drive_low, self.drive_high)
                if braking is not self.zero
                else (braking, met)
            )
            applied = program.select(released, braked, limited)
            excess = program.select(released, self.zero, excess)
            hold = released if hold is None else hold | released
        if resting is not None:
            applied = program.select(resting, self.zero, applied)
            hold = hold | resting if hold is not None else None
        applied = program.select(self.fault, self.zero, applied)
        program.output = program.named("output", applied)
        if chain is not None:
            second_order_sections.advance(
                program, chain, np.array(linear.sos_anti_windup), passed, excess, resting
            )
        else:
            difference_equation.advance(
                program, _integrators(equations), k, entering, excess, hold, resting
            )
        if "limited_before" in program.states:
            program.update(
                "limited_before",
                met if resting is None else program.select(resting, self.zero, met),
            )
        if observed is not None:
            compensated = self.document.friction_compensation
            assert compensated is not None
            friction_compensation.observe(
                program, applied, observed, compensated.observer_rad_s, self.period
            )

    def _equations(self, equation: DifferenceEquation) -> list[DifferenceEquation]:
        schedule = self.document.schedule
        if schedule is None:
            return [equation]
        return [_equation(corner.discrete, corner.anti_windup) for corner in schedule.corners]

    def _weights(self) -> list[ProgramNode]:
        schedule = self.document.schedule
        assert schedule is not None
        corners = [
            {str(name): float(getattr(corner, name)) for name in schedule.parameters}
            for corner in schedule.corners
        ]
        return corner_weights(self.program, schedule.parameters, corners)


def _equation(space: StateSpace, gains: tuple[float, ...]) -> DifferenceEquation:
    n = len(space.a)
    a = np.array(space.a, dtype=np.float64).reshape(n, n)
    b, c = (
        np.array(space.b, dtype=np.float64).reshape(n),
        np.array(space.c, dtype=np.float64).reshape(n),
    )
    return DifferenceEquation(a, b, c, float(space.d[0][0]), np.array(gains, dtype=np.float64))


def _integrators(equations: list[DifferenceEquation]) -> list[int]:
    return [
        i for i in equations[0].integrators if all(i in other.integrators for other in equations)
    ]
