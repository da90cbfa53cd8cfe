"""Simulator of the laws in friction/law_registry.py, with the parameters of a ComparisonSetting."""

from __future__ import annotations

import itertools
import math

import numpy as np

from frictool.compare import input_protocol, law_probes, prescribed_motion
from frictool.compare.comparison_setting import ComparisonSetting
from frictool.compare.trajectory import LawTrajectory, Phases, slow_phases
from frictool.engine.body import BREAKS_AWAY, SLIPS_BACK, STOPS
from frictool.engine.drive import held, ramped
from frictool.engine.law_simulation import LawRunSettings, run_law
from frictool.engine.status_codes import MESSAGES, OK
from frictool.errors import NoSolutionError
from frictool.friction.hybrid_time_step import HybridBench, HybridSettings, violations
from frictool.friction.law import DynamicKernels
from frictool.friction.law_registry import LAWS
from frictool.typing import Vector

SLOW = 0.1  # speed below which a law without exact stick counts as stuck, units of v_s
SHORTEST_STICK = 0.1  # shortest phase that counts as a stick, units of time
YIELD_FORCE = 0.25  # peak effort of the test for compliance, units of F_c
YIELD_SAMPLES = 3001
RETURNED = 0.5  # least share of the displacement that a compliant contact returns
SLOW_RATE, FAST_RATE = 0.1, 1.0  # rates of the two ramps, units of force per unit of time
RAMP_END = 1.15  # force at the end of a ramp, units of F_s
RAMP_SAMPLES = 60_001
MOST_STEPS = 1e9  # largest number of steps of a run
# limits in units of time, length and speed
LONGEST_STEP, LEAST_PRESLIDING, LEAST_SPEED = 0.1, 1e-7, 1e-6
# upper limits in F_c, F_c and sqrt(m sigma_0)
MOST_BREAKAWAY, MOST_EFFORT, MOST_DAMPING = 100.0, 1e4, 100.0
SETTLED = 5.0  # s, time from which the mass must stand still in the drift test


def law_values(setting: ComparisonSetting) -> dict[str, float]:
    """Map names to the values of `setting` from which the laws compute their parameters."""
    return {
        "coulomb": setting.coulomb,
        "breakaway": setting.breakaway,
        "viscous": setting.viscous,
        "stribeck_velocity": setting.stribeck_velocity,
        "stribeck_exponent": setting.stribeck_exponent,
        "stiffness": setting.stiffness,
        "damping": setting.damping,
        "presliding_limit": setting.presliding,
        "plastic_from": setting.plastic_from,
        "leuven_exponent": setting.leuven_exponent,
        "band": setting.dead_band,
        "inertia": setting.mass,
        "capture_velocity": setting.switch_velocity,
        "convergence_rate": setting.decay,
        "preisach_intervals": setting.preisach_intervals,
    }


def setting_violations(
    setting: ComparisonSetting, laws: tuple[str, ...]
) -> tuple[list[str], list[str]]:
    """Return the conditions of the hybrid laws in `laws` that the setting violates, as text.

    The first list contains violated requirements, the second violated recommendations.
    friction/hybrid_time_step.py lists the conditions. The conditions on sample period and encoder
    step are checked only if the setting contains these two values.
    """
    period = setting.sample_period or 10.0 / setting.decay
    resolution = setting.encoder_step or 2.0 * setting.switch_velocity / setting.decay
    bench = HybridBench(
        period, resolution, setting.mass, setting.effort_limit, setting.stribeck_velocity
    )
    settings = HybridSettings(setting.decay, setting.switch_velocity, setting.step)
    violated = (violations(LAWS[law], bench, settings, setting.axis) for law in laws)
    lines = list(dict.fromkeys(itertools.chain.from_iterable(violated)))
    advice = [line for line in lines if line.startswith("Sigma > 3 v_s")]
    return [line for line in lines if line not in advice], advice


class LawSimulator:
    """Simulator of every law; implements LawRunner (compare/comparison.py)."""

    def __init__(self, setting: ComparisonSetting) -> None:
        self._setting = setting

    def names(self) -> tuple[str, ...]:
        """Return the names of the laws, in the order in which tables show them."""
        return tuple(LAWS)

    def title(self, law: str) -> str:
        """Return the display name of the law."""
        return LAWS[law].title

    def check(self, laws: tuple[str, ...]) -> None:
        """Raise ValueError if a parameter is out of range or makes the simulation too long."""
        setting = self._setting
        scales = self._setting.scales
        loop = input_protocol.limit_cycle(scales)[-1][0]
        for name, value, low, high in (
            ("breakaway", setting.breakaway, scales.force, MOST_BREAKAWAY * scales.force),
            ("effort_limit", setting.effort_limit, scales.force, MOST_EFFORT * scales.force),
            ("hybrid.step_s", setting.step, loop / MOST_STEPS, LONGEST_STEP * scales.time),
            ("presliding", setting.presliding, LEAST_PRESLIDING * scales.length, scales.length),
            (
                "breakaway/bristle_stiffness",
                setting.breakaway / setting.stiffness,
                LEAST_PRESLIDING * scales.length,
                scales.length,
            ),
            (
                "stribeck_velocity",
                setting.stribeck_velocity,
                LEAST_SPEED * scales.speed,
                scales.speed,
            ),
            ("dead_band", setting.dead_band, LEAST_SPEED * scales.speed, scales.speed),
            (
                "hybrid.switch_velocity",
                setting.switch_velocity,
                LEAST_SPEED * scales.speed,
                scales.speed,
            ),
            ("hybrid.decay_rad_s", setting.decay, 1.0 / scales.time, 1.0 / setting.step),
            (
                "bristle_damping",
                setting.damping,
                0.0,
                MOST_DAMPING * math.sqrt(setting.mass * setting.stiffness),
            ),
        ):
            if not low <= value <= high:
                raise ValueError(
                    f"{name} is {value:g}; allowed for these tests: {low:g} to {high:g}"
                )
        for law in laws:
            self.packed(law)

    def refusals(self, laws: tuple[str, ...]) -> dict[str, str]:
        """Map each law that does not support an extension of the setting to the reason."""
        reasons = {}
        for law in laws:
            try:
                self._setting.extension.pack(LAWS[law], self.packed(law), self._setting.axis)
            except ValueError as error:
                reasons[law] = str(error)
        return reasons

    def packed(self, law: str) -> Vector:
        """Return the parameters of the law in the order that its kernels expect.

        Raises ValueError if the law does not allow the parameters of the setting.
        """
        return LAWS[law].pack_shared(law_values(self._setting), self._setting.axis)

    def defaults(self, laws: tuple[str, ...]) -> list[str]:
        """Return a line of text for each parameter of `laws` whose default is used.

        The default is used if the setting does not contain the parameter.
        """
        values = law_values(self._setting)
        return [
            f"the comparison of {law} uses {parameter.name} = {parameter.default:g} "
            f"{parameter.unit(self._setting.axis)}".rstrip()
            for law in laws
            for parameter in LAWS[law].parameters
            if parameter.comparison_value is None and parameter.name not in values
        ]

    def parameters(self, law: str) -> int:
        """Return the number of physical parameters to identify.

        A Preisach law has one parameter per cell, a Maxwell law two per element.
        """
        friction_law = LAWS[law]
        fixed = sum(not parameter.simulation_only for parameter in friction_law.parameters)
        return fixed + friction_law.tail_parameters(
            self.packed(law).size - len(friction_law.parameters)
        )

    def run(
        self, law: str, segments: tuple[input_protocol.Segment, ...], samples: int
    ) -> LawTrajectory:
        """Simulate a law from rest at position 0; raise NoSolutionError if this fails."""
        setting = self._setting
        friction_law = LAWS[law]
        end = segments[-1][0]
        times = np.linspace(0.0, end, samples)
        p = self.packed(law)
        ran = run_law(
            friction_law,
            p,
            setting.mass,
            segments,
            times,
            LawRunSettings(
                step=setting.step,
                speed_scale=setting.stribeck_velocity,
                length_scale=setting.presliding,
                extension=setting.extension,
            ),
        )
        if ran.status != OK:
            raise NoSolutionError(
                f"{law}: at {ran.reached:g} s {MESSAGES[ran.status]}; check the parameters"
            )
        shortest = SHORTEST_STICK * setting.scales.time
        if friction_law.approximation or isinstance(friction_law.kernels, DynamicKernels):
            sticks = slow_phases(ran.time, ran.velocity, SLOW * setting.stribeck_velocity, shortest)
        else:
            sticks = _phases(ran.events, end, shortest)
        return LawTrajectory(ran.time, ran.position, ran.velocity, ran.friction, sticks)

    def creep(self, law: str, path: Vector, speed: float) -> Vector | None:
        """Return the friction [N | N m] along the positions `path` at constant `speed`.

        Returns None if an effort below breakaway does not move the mass, or if the mass does not
        spring back.
        """
        if not self._springs_back(law):
            return None
        moves = np.diff(path)
        friction = prescribed_motion.friction_along(
            LAWS[law], self.packed(law), np.sign(moves) * speed, np.abs(moves) / speed
        )
        return np.concatenate([[0.0], friction])

    def _springs_back(self, law: str) -> bool:
        """Return True if an effort of F_c/4 moves the mass, which then springs back.

        The mass must return by more than half of its displacement. F_c is the Coulomb friction.
        """
        scales = self._setting.scales
        force = YIELD_FORCE * scales.force
        time = scales.time
        segments = (
            (time, ramped(0.0, force / time)),
            (2.0 * time, ramped(force, -force / time, time)),
            (3.0 * time, held(0.0)),
        )
        position = self.run(law, segments, YIELD_SAMPLES).position
        peak = float(np.max(position))
        return peak > 0.0 and peak - float(position[-1]) > RETURNED * peak

    def properties(self, law: str, compliance: bool, drift: LawTrajectory) -> dict[str, str]:
        """Return the symbols of those rows of thesis table 2.1 that simulations can determine.

        - compliance: True if the contact is compliant in presliding
        - drift: trajectory of the drift test
        """
        setting = self._setting
        friction_law = LAWS[law]
        p = self.packed(law)

        def follow(velocity: Vector, steps: Vector) -> Vector:
            return prescribed_motion.friction_along(friction_law, p, velocity, steps)

        still = drift.position[drift.between(SETTLED * setting.scales.time, float(drift.time[-1]))]
        settles = friction_law.kind == "hybrid" or (
            friction_law.kind == "static"
            and law_probes.settles(prescribed_motion.law_as_printed(friction_law, p), setting)
        )
        slow, fast = self._breakaway(law, SLOW_RATE), self._breakaway(law, FAST_RATE)
        return {
            "dynamic": "S" if friction_law.kind == "static" else "D",
            "stiction": law_probes.stiction(compliance, bool(np.ptp(still) == 0.0), settles),
            "rising_static_friction": "+"
            if setting.extension.rise_time > 0.0
            else law_probes.rising_static_friction(slow, fast, setting),
            "frictional_memory": "+"
            if setting.extension.lag > 0.0
            else law_probes.frictional_memory(follow, setting),
            "stribeck_effect": law_probes.stribeck_effect(follow, setting),
            "viscous": law_probes.viscous_friction(follow, setting),
        }

    def _breakaway(self, law: str, rate: float) -> float:
        """Return the largest friction in a force ramp, at speeds below 10 Stribeck velocities."""
        setting = self._setting
        growth = rate * self._setting.scales.force / self._setting.scales.time
        ran = self.run(
            law, ((RAMP_END * setting.breakaway / growth, ramped(0.0, growth)),), RAMP_SAMPLES
        )
        fast = np.flatnonzero(np.abs(ran.velocity) > 10.0 * setting.stribeck_velocity)
        return float(np.max(ran.friction[: int(fast[0]) if fast.size else None]))


def _phases(events: Vector, end: float, shortest: float) -> Phases:
    phases: list[tuple[float, float]] = []
    begin: float | None = 0.0
    for time, kind, *_ in events.tolist():
        if kind in (BREAKS_AWAY, SLIPS_BACK) and begin is not None:
            phases.append((begin, time))
            begin = None
        elif kind == STOPS:
            begin = time
    if begin is not None:
        phases.append((begin, end))
    return tuple(phase for phase in phases if phase[1] - phase[0] >= shortest)
