"""Change of a block's elements to the coordinate of another block (thesis 2.1.5, (2.16)).

    q = ratio p + offset
    effort f on q          ratio f on p
    mass m, stiffness k    ratio^2 m, ratio^2 k

The power is the same in both coordinates, f q' = (ratio f) p', so that the change is exact.
Friction opposes the motion in both coordinates: the efforts in a friction law are multiplied by
|ratio|, the speeds and distances by 1/|ratio|.
"""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from frictool.adapters.mechanism.bearing_friction import si_parameters
from frictool.documents.mechanism import (
    Cam,
    Compliance,
    Curve,
    FrictionOf,
    Level,
    Sensor,
    Source,
    Spring,
    Stop,
)
from frictool.documents.quantity import Axis, Quantity, Series, si_unit
from frictool.friction.law_registry import LAWS

Ends = tuple[float, ...]
TURN = 6.283185307179586  # rad per revolution
# power of |ratio| for a law's parameter, by its unit on a linear axis
POWERS = {"N": 1, "N/s": 1, "N s/m": 2, "N/m": 2, "kg": 2, "m/s": -1, "m": -1}


@dataclass(frozen=True)
class CoordinateFrame:
    """Map q = ratio p + offset [SI] between a block's coordinate q and another coordinate p.

    axis: kind of p, rotary or linear.
    block_axis: kind of q, rotary or linear.
    """

    ratio: float
    offset: float
    axis: Axis
    block_axis: Axis

    def position(self, q: Quantity) -> Quantity:
        """Convert a position from the block's coordinate to the frame's coordinate."""
        offset = Quantity(
            q.value - self.offset, _less(q.low, self.offset), _less(q.high, self.offset)
        )
        return scaled(offset, 1.0 / self.ratio, self._unit("position"))

    def width(self, q: Quantity) -> Quantity:
        """Convert an unsigned distance from the block's coordinate to the frame's coordinate."""
        return scaled(q, 1.0 / abs(self.ratio), self._unit("position"))

    def effort(self, f: Quantity) -> Quantity:
        """Convert an effort from the block's coordinate to the frame's coordinate."""
        return scaled(f, self.ratio, self._unit("effort"))

    def stiffness(self, k: Quantity) -> Quantity:
        """Convert a stiffness from the block's coordinate to the frame's coordinate."""
        return scaled(k, self.ratio**2, self._unit("stiffness"))

    def damping(self, d: Quantity) -> Quantity:
        """Convert a damping from the block's coordinate to the frame's coordinate."""
        return scaled(d, self.ratio**2, self._unit("viscous"))

    def inertia(self, m: Quantity) -> Quantity:
        """Convert an inertia or mass from the block's coordinate to the frame's coordinate."""
        return scaled(m, self.ratio**2, self._unit("inertia"))

    def curve(self, curve: Curve, factor: float, unit: str | None = None) -> Curve:
        """Convert the positions of a curve to the frame, and multiply the values by `factor`."""
        positions, values = self._points(
            curve.position.values, tuple(value * factor for value in curve.value.values)
        )
        return Curve(
            Series(positions, self._unit("position")), Series(values, unit or curve.value.unit)
        )

    def _level(self, level: Level) -> Level:
        positions, factors = self._points(level.position.values, level.factor)
        return Level(Series(positions, self._unit("position")), factors)

    def _points(self, positions: Ends, values: Ends) -> tuple[Ends, Ends]:
        order = -1 if self.ratio < 0.0 else 1
        return tuple((value - self.offset) / self.ratio for value in positions)[::order], values[
            ::order
        ]

    def compliance(self, one: Compliance | None) -> Compliance | None:
        """Convert stiffness and damping from the block's coordinate to the frame's coordinate."""
        return (
            None
            if one is None
            else Compliance(self.stiffness(one.stiffness), self.damping(one.damping))
        )

    def spring(self, spring: Spring, on: str) -> Spring:
        """Convert a spring between the block and ground to the frame's coordinate.

        A spring without the key `free` is unstrained at the start, in both coordinates.
        """
        force = (
            None
            if spring.force is None
            else self.curve(spring.force, self.ratio, self._unit("effort"))
        )
        return Spring(
            (on, "ground"),
            None if spring.stiffness is None else self.stiffness(spring.stiffness),
            force,
            None if spring.damping is None else self.damping(spring.damping),
            None if spring.free is None else self.position(spring.free),
            None if spring.preload is None else self.effort(spring.preload),
        )

    def cam(self, cam: Cam, on: str) -> Cam:
        """Convert a cam from the block's coordinate to the frame's coordinate.

        The force is multiplied by |ratio|, the slope angle by the sign of the ratio.
        """
        side = 1.0 if self.ratio > 0.0 else -1.0
        force = self.curve(cam.force, abs(self.ratio), self._unit("effort"))
        return msgspec.structs.replace(cam, on=on, force=force, angle=self.curve(cam.angle, side))

    def stop(self, stop: Stop, on: str) -> Stop:
        """Convert end stops to the frame's coordinate; a negative ratio swaps low and high."""
        low, high = (stop.low, stop.high) if self.ratio > 0.0 else (stop.high, stop.low)
        ends = [None if end is None else self.position(end) for end in (low, high)]
        return Stop(on, ends[0], ends[1], stop.restitution, self.compliance(stop.compliance))

    def friction(self, friction: FrictionOf, on: str) -> FrictionOf:
        """Convert a friction element: multiply each parameter by a power of |ratio| (POWERS)."""
        law = LAWS[friction.law]
        sizes = si_parameters(on, friction, self.block_axis)
        parameters = {}
        for name, quantity in sizes.items():
            parameter = law.parameters[law.index(name)]
            power = POWERS.get(parameter.unit("linear"), 0)
            parameters[name] = scaled(
                quantity, abs(self.ratio) ** power, parameter.unit(self.axis) or "1"
            )
        level = None if friction.level is None else self._level(friction.level)
        return FrictionOf(on, friction.law, parameters, level)

    def source(self, source: Source, on: str) -> Source:
        """Convert a source to the frame's coordinate; the constant is multiplied by |ratio|.

        If the ratio is negative, the caller must reverse the command.
        """
        constant = None
        if source.constant is not None:
            per = "A" if source.constant.unit.endswith("A") else "V"
            constant = scaled(source.constant, abs(self.ratio), f"{self._unit('effort')}/{per}")
        effort = None if source.effort is None else self.effort(source.effort)
        limit = source.limit
        if source.drive == "effort" and limit is not None:
            limit = scaled(limit, abs(self.ratio), self._unit("effort"))
        return msgspec.structs.replace(source, on=on, constant=constant, effort=effort, limit=limit)

    def sensor(self, sensor: Sensor, on: str) -> Sensor:
        """Convert the sensor's resolution, which has no sign, to the frame's coordinate."""
        step = sensor.step
        if sensor.counts_per_revolution is not None:
            step = Quantity(TURN / sensor.counts_per_revolution, unit="rad")
        return Sensor(on, sensor.measures, None, None if step is None else self.width(step))

    def _unit(self, dimension: str) -> str:
        return si_unit(dimension, self.axis)


def scaled(quantity: Quantity, factor: float, unit: str) -> Quantity:
    """Return the quantity times a factor; a negative factor swaps the ends of the interval."""
    ends = [None if end is None else end * factor for end in (quantity.low, quantity.high)]
    if factor < 0.0:
        ends.reverse()
    return Quantity(quantity.value * factor, ends[0], ends[1], unit)


def _less(end: float | None, offset: float) -> float | None:
    return None if end is None else end - offset
