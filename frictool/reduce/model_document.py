"""Model document of a reduced mechanism, with a bench derived from its source and sensor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import msgspec

from frictool.adapters.mechanism.block_references import axis_kind
from frictool.documents.bench import Actuator, Bench, Column, Encoder, Mechanics
from frictool.documents.laws import (
    Backward,
    FrictionOverPosition,
    Gravity,
    Laws,
    Load,
    Polynomial,
    Ripple,
)
from frictool.documents.mechanism import Sensor, Source
from frictool.documents.model import Model, Parameters
from frictool.documents.provenance import Provenance
from frictool.documents.quantity import Axis, Estimate, Quantity, Span, drive_dimension, si_unit
from frictool.documents.resonances import Oscillation, Resonances
from frictool.errors import NoSolutionError
from frictool.reduce.one_inertia import DirectionFriction, OneInertia
from frictool.reduce.polynomial_fit import mean_of
from frictool.reduce.reduction_chain import ReductionChain

CONFIDENCE = 0.95
ROUNDING = 1e-12  # relative width below which an interval is omitted
SMALLEST_STEP = 1e-6  # encoder step of a perfect sensor, relative to the travel
SIGNED = ("offset", "stiffness", "sine", "cosine")
Ends = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class _Estimates:
    one: OneInertia
    ends: Ends
    axis: Axis

    def of(self, name: str, dimension: str, value: float | None = None) -> Estimate:
        """Return the model's estimate of the parameter `name`, with its interval.

        If `value` is not None, it replaces the parameter's value, and the interval is shifted by
        the difference.
        """
        nominal = self.one.scalars()[name]
        centre = nominal if value is None else value
        low, high = (end + centre - nominal for end in self.ends.get(name, (nominal, nominal)))
        if low < 0.0 <= centre and name not in SIGNED:
            low = 0.0
        known = high - low > ROUNDING * max(abs(low), abs(high))
        return Estimate(
            centre,
            low if known else None,
            high if known else None,
            si_unit(dimension, self.axis),
            source="bench",
        )

    def level(self, name: str, side: DirectionFriction) -> Estimate:
        """Return the estimate of a Coulomb friction or breakaway: the mean of its polynomial."""
        low, high = self.one.ends
        terms = side.breakaway_terms if name.endswith("breakaway") else side.coulomb.coefficients
        return self.of(name, "effort", mean_of(terms, low, high))


def model_of(
    chain: ReductionChain, ends: Ends, provenance: Provenance, bench: Bench | None = None
) -> Model:
    """Return the model document of a reduction.

    ends: interval of each number in OneInertia.scalars, by name.
    bench: the user's bench document; None to derive it from the mechanism.

    Raises NoSolutionError if the bench contradicts the mechanism, or if the source has no limit.
    """
    one = chain.one
    axis = axis_kind(chain.last.blocks[chain.last.sources[chain.source].on])
    derived = bench_of(chain, ends, axis)
    used = derived if bench is None else merged(bench, derived)
    estimates = _Estimates(one, ends, axis)
    parameters = _parameters(estimates)
    laws = _laws(estimates, parameters)
    return Model(
        format="model/1",
        name=used.name,
        axis=axis,
        law=parameters.law,
        method="reduced",
        confidence=CONFIDENCE,
        bench=used,
        parameters=parameters,
        provenance=provenance,
        laws=None if laws == Laws() else laws,
        resonances=_resonances(one, ends),
    )


def _parameters(estimates: _Estimates) -> Parameters:
    one = estimates.one
    inertia = estimates.of("inertia", "inertia")
    # inside the backlash, the masses behind it rest; lossy links change the reflected inertia
    low = estimates.ends["inner.least" if one.play.width > 0.0 else "inertia.least"][0]
    high = estimates.ends["inertia.most"][1]
    if high - low > ROUNDING * high:
        inertia = msgspec.structs.replace(inertia, low=low, high=high)
    return Parameters(
        inertia=inertia,
        viscous=estimates.of("viscous", "viscous"),
        coulomb=estimates.level("coulomb", one.forward),
        breakaway=estimates.level("breakaway", one.forward),
        offset=estimates.of("offset", "effort"),
        stribeck_velocity=estimates.of("stribeck_velocity", "velocity")
        if one.stribeck_velocity > 0.0
        else None,
    )


def _laws(estimates: _Estimates, forward: Parameters) -> Laws:
    one = estimates.one
    coulomb, breakaway = (
        estimates.level(f"backward.{name}", one.backward) for name in ("coulomb", "breakaway")
    )
    same = math.isclose(forward.coulomb.value, coulomb.value) and math.isclose(
        forward.breakaway.value, breakaway.value
    )
    return Laws(
        backward=None
        if same and one.forward.flat and one.backward.flat
        else Backward(coulomb=coulomb, breakaway=breakaway),
        position=_position(one, estimates.axis),
        stribeck_exponent=min(4.0, max(0.5, one.stribeck_exponent)),
        restitution=one.restitution,
        load=_load(estimates),
    )


def _load(estimates: _Estimates) -> Load | None:
    one = estimates.one.residual
    axis = estimates.axis
    if one.number == 0.0:
        return (
            None if one.stiffness == 0.0 else Load(stiffness=estimates.of("stiffness", "stiffness"))
        )
    sine, cosine = (estimates.of(name, "effort") for name in ("sine", "cosine"))
    if axis == "rotary" and math.isclose(one.number, 1.0, rel_tol=1e-9):
        return Load(gravity=Gravity(sine, cosine))
    if axis == "rotary":
        return Load(ripple=Ripple(one.number, Quantity(2.0 * math.pi, unit="rad"), sine, cosine))
    return Load(ripple=Ripple(1.0, Quantity(2.0 * math.pi / one.number, unit="m"), sine, cosine))


def _resonances(one: OneInertia, ends: Ends) -> Resonances | None:
    if one.resonances is None:
        return None

    def known(kind: str, oscillations: tuple[Oscillation, ...]) -> tuple[Oscillation, ...]:
        return tuple(
            msgspec.structs.replace(
                each,
                interval_rad_s=ends[f"{kind}.{k}"]
                if ends[f"{kind}.{k}"][0] < ends[f"{kind}.{k}"][1]
                else None,
            )
            for k, each in enumerate(oscillations)
        )

    return msgspec.structs.replace(
        one.resonances,
        poles=known("poles", one.resonances.poles),
        zeros=known("zeros", one.resonances.zeros),
    )


def _position(one: OneInertia, axis: Axis) -> FrictionOverPosition | None:
    if one.forward.flat and one.backward.flat:
        return None
    coulomb = Polynomial(one.forward.coulomb.coefficients, one.backward.coulomb.coefficients)
    breakaway = Polynomial(one.forward.breakaway_terms, one.backward.breakaway_terms)
    return FrictionOverPosition(Span(*one.ends, si_unit("position", axis)), coulomb, breakaway)


def bench_of(chain: ReductionChain, ends: Ends, axis: Axis) -> Bench:
    """Return a bench derived from the controlled source and sensor of the mechanism.

    Raises NoSolutionError if the source has no limit.
    """
    last, one = chain.last, chain.one
    source = last.sources[chain.source]
    numbers = one.scalars()

    def quantity(
        name: str, dimension: str, low: float | None = None, high: float | None = None
    ) -> Quantity:
        least, most = ends[name][0] if low is None else low, ends[name][1] if high is None else high
        known = most - least > ROUNDING * max(abs(least), abs(most))
        least = max(0.0, least)
        return Quantity(
            numbers[name],
            least if known else None,
            most if known else None,
            si_unit(dimension, axis),
        )

    most = max(ends["most"][1], numbers["coulomb"])
    travel = one.travel
    return Bench(
        format="bench/1",
        name=chain.whole.name,
        axis=axis,
        sample_period_s=last.sample_period_s,
        encoder=_encoder(chain, axis),
        actuator=_actuator(source, chain.source, axis),
        mechanics=Mechanics(
            inertia=quantity(
                "inertia", "inertia", low=ends["inner.least"][0], high=ends["inertia.most"][1]
            ),
            viscous=quantity("viscous", "viscous"),
            coulomb=quantity("coulomb", "effort", low=ends["least"][0], high=most),
            backlash=quantity("backlash", "position") if one.play.width > 0.0 else None,
            backlash_coulomb=quantity("backlash_coulomb", "effort")
            if one.play.width > 0.0
            else None,
            travel=None if travel is None else Span(*travel, si_unit("position", axis)),
            top_speed=last.top_speed,
        ),
        columns={
            "time": Column("time", "s"),
            "position": Column("position", si_unit("position", axis)),
            source.drive if source.drive != "effort" else "current": Column(
                "drive", "V" if source.drive == "voltage" else "A"
            ),
        },
        delay_samples=last.delay_samples,
    )


def _actuator(source: Source, name: str, axis: Axis) -> Actuator:
    if source.limit is None:
        raise NoSolutionError(
            f"sources.{name}.limit: missing; the bench of a model needs the drive's limit"
        )
    drive = "current" if source.drive == "effort" else source.drive
    unit = si_unit(drive_dimension(drive, constant=True), axis)
    constant = Quantity(1.0, unit=unit) if source.constant is None else source.constant
    limit = Quantity(
        source.limit.value, source.limit.low, source.limit.high, "V" if drive == "voltage" else "A"
    )
    return Actuator(
        drive,
        Quantity(constant.value, constant.low, constant.high, unit),
        limit,
        source.loop_time_constant_s,
        source.winding,
    )


def _encoder(chain: ReductionChain, axis: Axis) -> Encoder:
    """Return the sensor as an encoder; a sensor without resolution gets a very small step."""
    sensor: Sensor = chain.whole.sensors[chain.sensor]
    sign = next(
        (step.report.figures[0].value for step in chain.steps if step.report.step == "sensor"), 1.0
    )
    direction: Literal[1, -1] = 1 if sign > 0.0 else -1
    if sensor.counts_per_revolution is not None:
        return Encoder(counts_per_revolution=sensor.counts_per_revolution, direction=direction)
    low, high = chain.one.ends
    step = sensor.step.value if sensor.step is not None else SMALLEST_STEP * (high - low)
    return Encoder(step=Quantity(step, unit=si_unit("position", axis)), direction=direction)


def merged(bench: Bench, derived: Bench) -> Bench:
    """Return the user's `bench`, with missing values from `derived`, the mechanism's bench.

    Raises NoSolutionError if the two benches contradict each other.
    """
    pairs = {
        "axis": (bench.axis, derived.axis),
        "sample_period_s": (bench.sample_period_s, derived.sample_period_s),
        "delay_samples": (bench.delay_samples, derived.delay_samples),
        "actuator.drive": (bench.actuator.drive, derived.actuator.drive),
        "actuator.constant": (bench.actuator.constant.value, derived.actuator.constant.value),
        "actuator.limit": (bench.actuator.limit.value, derived.actuator.limit.value),
        "actuator.loop_time_constant_s": (
            bench.actuator.loop_time_constant_s,
            derived.actuator.loop_time_constant_s,
        ),
        "encoder": (bench.encoder.resolution, derived.encoder.resolution),
    }
    for key, (provided, expected) in pairs.items():
        equal = (
            math.isclose(provided, expected, rel_tol=1e-6)
            if isinstance(provided, float) and isinstance(expected, float)
            else provided == expected
        )
        if not equal:
            raise NoSolutionError(
                f"bench {bench.name}: {key}: found {provided}, but {expected} in the mechanism; "
                "both must describe the same rig"
            )
    missing = {
        name: getattr(derived.mechanics, name)
        for name in ("backlash", "backlash_coulomb", "travel", "top_speed")
        if getattr(bench.mechanics, name) is None
    }
    return msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, **missing)
    )
