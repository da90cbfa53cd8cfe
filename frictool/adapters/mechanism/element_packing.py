"""Conversion of all elements of a mechanism, except rigid links and sources, to arrays."""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import cache
from typing import Any, NamedTuple, TypeVar, get_type_hints

import numpy as np

from frictool.adapters.mechanism.bearing_friction import law_row, pack_law
from frictool.adapters.mechanism.block_references import BlockNames, check_compliance, check_unit
from frictool.documents.mechanism import (
    GROUND,
    Cam,
    Curve,
    FrictionOf,
    Level,
    Mechanism,
    Spring,
    Stop,
)
from frictool.documents.quantity import Axis, si_unit
from frictool.plant.mechanism.curves import CurveList, PiecewiseCubic, cam_push, monotone_cubic
from frictool.plant.mechanism.element_error import ElementError
from frictool.plant.mechanism.link_graph import RigidGroup, Transmission
from frictool.plant.mechanism.packed_mechanism import FRAME, Frictions
from frictool.typing import IntVector, Vector

STEEPEST = math.radians(80.0)  # rad, largest angle of a cam's profile
FAR: dict[Axis, float] = {
    "rotary": 1e5,
    "linear": 1e3,
}  # rad, m: assumed distance of the missing side of a compliant stop with one side


Arrays = TypeVar("Arrays", bound=tuple[Any, ...])


class CouplingRow(NamedTuple):
    """Row of `Couplings` (plant/mechanism/packed_mechanism.py).

    `curve`: index in `Curves` of a curve from deflection to effort, or -1 for no curve. The effort
        of the curve is added to the efforts of `stiffness` and `damping`.
    """

    a: int
    b: int
    ratio: float
    offset: float
    gap: float
    stiffness: float
    damping: float
    curve: int = -1
    drive_loss: float = 0.0
    back_loss: float = 0.0


class ElementArrays:
    """Elements of a mechanism as rows for the arrays of a `PackedMechanism`.

    The key of each dict is the name of the element. Rigid links have no row.

    - springs: (second block or FRAME, first block) of each spring
    - pushes: (name, row) of each cam and of each source of a constant effort; a cam and a source
      may have the same name
    - grounded: blocks that an element ties to the frame
    """

    def __init__(
        self, document: Mechanism, blocks: BlockNames, start: Vector, notes: list[str]
    ) -> None:
        self.document = document
        self.blocks = blocks
        self.start = start
        self.notes = list(notes)
        self.curves = CurveList()
        self.grounded: set[int] = set()
        self.couplings: dict[str, CouplingRow] = {}
        self.springs: list[tuple[int, int]] = []
        self.frictions: dict[str, tuple[int, int, Vector, int]] = {}
        self.pressings: dict[str, tuple[int, int, float, float]] = {}
        self.pushes: list[tuple[str, tuple[int, float, int]]] = []
        self.stops: dict[str, tuple[int, float, float, float]] = {}
        self._ranges: list[tuple[str, int, PiecewiseCubic]] = []

    def coupling(self, link: Transmission) -> None:
        """Add a compliant link.

        Raises ElementError for a compliant screw with the thesis's friction formula, which is valid
        for rigid screws only.
        """
        assert link.stiffness is not None
        if link.thread:
            raise ElementError(
                f"links.{link.name}.friction_form",
                "found thesis, which is valid for rigid screws only; allowed: angle",
            )
        offset = self.start[link.b] - link.ratio * self.start[link.a]
        self._couple(
            link.name,
            CouplingRow(
                link.a,
                link.b,
                link.ratio,
                float(offset),
                link.gap,
                link.stiffness,
                link.damping,
                drive_loss=link.drive_loss,
                back_loss=link.back_loss,
            ),
        )

    def spring(self, name: str, spring: Spring) -> None:
        """Add a spring between two blocks, or between a block and the frame.

        Raises ElementError if ends or units do not fit.
        """
        key = f"links.{name}"
        first, second = self.blocks.two(key, spring.between)
        kind = self.blocks.kind(f"{key}.between", first)
        if second != GROUND:
            self.blocks.sequence(key, "a spring", (first, second), (kind, kind))
        a = FRAME if second == GROUND else self.blocks.index(key, second)
        b = self.blocks.index(key, first)
        check_unit(f"{key}.stiffness", spring.stiffness, "stiffness", kind, first)
        check_unit(f"{key}.damping", spring.damping, "viscous", kind, first)
        check_unit(f"{key}.free", spring.free, "position", kind, first)
        check_unit(f"{key}.preload", spring.preload, "effort", kind, first)
        if spring.preload is not None and spring.stiffness is None:
            raise ElementError(
                f"{key}.preload",
                "found preload without stiffness; add stiffness, or write the constant effort as a "
                "source",
            )
        stiffness = 0.0 if spring.stiffness is None else spring.stiffness.value
        free = (
            float(self.start[b] - (0.0 if a == FRAME else self.start[a]))
            if spring.free is None
            else spring.free.value
        )
        offset = free - (0.0 if spring.preload is None else spring.preload.value / stiffness)
        curve = -1
        if spring.force is not None:
            offset = 0.0
            curve = self._curve(
                f"{key}.force", spring.force, kind, first, b if a == FRAME else None
            )
        damping = 0.0 if spring.damping is None else spring.damping.value
        row = CouplingRow(a, b, 1.0, offset, 0.0, stiffness, damping, curve)
        self._couple(name, row)
        self.springs.append((a, b))

    def cam(self, name: str, cam: Cam) -> None:
        """Add the effort and the friction of a cam (thesis 2.23).

        Raises ElementError if units or angles do not fit.
        """
        key = f"links.{name}"
        block = self.blocks.index(f"{key}.on", cam.on)
        kind = self.blocks.kinds[block]
        force = self._curve(f"{key}.force", cam.force, kind, cam.on, block)
        if min(cam.force.value.values) < 0.0:
            raise ElementError(
                f"{key}.force.value",
                f"found {min(cam.force.value.values):g}; allowed: >= 0, since the spring can only "
                "push",
            )
        check_unit(f"{key}.angle.position", cam.angle.position, "position", kind, cam.on)
        if cam.angle.value.unit != "rad":
            raise ElementError(
                f"{key}.angle.value.unit",
                f"found a multiple of {cam.angle.value.unit}; allowed: rad, deg",
            )
        if max(map(abs, cam.angle.value.values)) > STEEPEST:
            largest = math.degrees(max(cam.angle.value.values, key=abs))
            raise ElementError(
                f"{key}.angle.value", f"found {largest:g} deg; allowed: -80 to 80 deg"
            )
        angle = monotone_cubic(cam.angle.position.values, cam.angle.value.values)
        self._ranges.append((f"{key}.angle", block, angle))
        profile = cam_push(monotone_cubic(cam.force.position.values, cam.force.value.values), angle)
        self.pushes.append((name, (block, 0.0, self.curves.add(profile))))
        self.grounded.add(block)
        if cam.friction_coefficient > 0.0:
            self.pressings[name] = (block, force, cam.friction_coefficient, cam.breakaway_ratio)

    def stop(self, name: str, stop: Stop) -> None:
        """Add a stop: a rigid one, or a compliant one, which is a coupling with play to the frame.

        Raises ElementError if units do not fit, or if the block starts outside its stops.
        """
        key = f"links.{name}"
        block = self.blocks.index(f"{key}.on", stop.on)
        kind = self.blocks.kinds[block]
        check_unit(f"{key}.low", stop.low, "position", kind, stop.on)
        check_unit(f"{key}.high", stop.high, "position", kind, stop.on)
        low, high = (
            infinite if side is None else side.value
            for side, infinite in ((stop.low, -math.inf), (stop.high, math.inf))
        )
        if not low <= self.start[block] <= high:
            unit = {"rotary": "rad", "linear": "m"}[kind]
            raise ElementError(
                key,
                f"{stop.on} starts at {self.start[block]:g} {unit}; allowed: {low:g} to "
                f"{high:g} {unit}, between the stops",
            )
        self.grounded.add(block)
        if stop.compliance is None:
            self.stops[name] = block, low, high, stop.restitution
            return
        check_compliance(f"{key}.compliance", stop.compliance, kind, stop.on)
        stiffness, damping = stop.compliance.stiffness.value, stop.compliance.damping.value
        if not (math.isfinite(low) and math.isfinite(high)):
            self.notes.append(
                f"{name} has one stop; the opposite stop is assumed {FAR[kind]:g} "
                f"{si_unit('position', kind)} away"
            )
        low, high = (
            (low if math.isfinite(low) else high - FAR[kind]),
            (high if math.isfinite(high) else low + FAR[kind]),
        )
        middle = 0.5 * (low + high)
        half = 0.5 * (high - low)
        row = CouplingRow(FRAME, block, 0.0, middle, half, stiffness, damping)
        self._couple(name, row)

    def friction(self, name: str, friction: FrictionOf, inertia: float) -> None:
        """Add the friction of a bearing or slideway.

        Raises ElementError if law, parameters or units do not fit.
        """
        key = f"links.{name}"
        block = self.blocks.index(f"{key}.on", friction.on)
        kind = self.blocks.kinds[block]
        law, values = pack_law(key, friction, kind, inertia)
        level = (
            -1
            if friction.level is None
            else self._level(f"{key}.level", friction.level, kind, friction.on, block)
        )
        self.grounded.add(block)
        self.frictions[name] = block, law_row(law), values, level

    def constant_push(self, name: str, block: int, effort: float) -> None:
        """Add the constant effort of a source."""
        self.pushes.append((name, (block, effort, -1)))

    def note_short_curves(self, groups: tuple[RigidGroup, ...]) -> None:
        """Add a note for each curve that ends before a stop of its block.

        Stops on other blocks also count, if rigid links connect these blocks to the block of the
        curve.
        """
        for element in self.document.links.values():
            if not isinstance(element, Stop):
                continue
            block_index = self.blocks.names.index(element.on)
            group = next(group for group in groups if block_index in group.blocks)
            for key, block, curve in self._ranges:
                if block not in group.blocks:
                    continue
                over = (
                    group.ratios[group.blocks.index(block)]
                    / group.ratios[group.blocks.index(block_index)]
                )
                distances = [
                    side.value - self.start[block_index]
                    for side in (element.low, element.high)
                    if side is not None
                ]
                positions = [float(self.start[block] + over * distance) for distance in distances]
                slack = 1e-6 * (curve.breaks[-1] - curve.breaks[0])  # tolerance for rounded points
                if (
                    min(positions) < curve.breaks[0] - slack
                    or max(positions) > curve.breaks[-1] + slack
                ):
                    self.notes.append(
                        f"{key.partition('.')[2]} is defined from {curve.breaks[0]:g} to "
                        f"{curve.breaks[-1]:g}, but the stops of {element.on} are farther apart; "
                        "beyond its ends the curve is constant"
                    )

    def _couple(self, name: str, row: CouplingRow) -> None:
        self.couplings[name] = row
        if row.a == FRAME:
            self.grounded.add(row.b)

    def _curve(self, key: str, curve: Curve, kind: Axis, whose: str, block: int | None) -> int:
        check_unit(f"{key}.position", curve.position, "position", kind, whose)
        check_unit(f"{key}.value", curve.value, "effort", kind, whose)
        cubics = monotone_cubic(curve.position.values, curve.value.values)
        if block is not None:
            self._ranges.append((key, block, cubics))
        return self.curves.add(cubics)

    def _level(self, key: str, level: Level, kind: Axis, whose: str, block: int) -> int:
        check_unit(f"{key}.position", level.position, "position", kind, whose)
        cubics = monotone_cubic(level.position.values, level.factor)
        self._ranges.append((key, block, cubics))
        return self.curves.add(cubics)

    def packed_frictions(self) -> Frictions:
        """Return the frictions as arrays for kernels."""
        rows = self.frictions.values()
        block, law, values, level = zip(*rows, strict=True) if rows else ((), (), (), ())
        starts = np.cumsum([0, *(len(p) for p in values)])
        joined = np.concatenate(values) if values else np.empty(0)
        return Frictions(
            _integers(block), _integers(law), _integers(starts), joined, _integers(level)
        )


def pack_rows(kind: type[Arrays], rows: Collection[tuple[float, ...]]) -> Arrays:
    """Return a record of type `kind` whose arrays are the columns of `rows`.

    The annotations of `kind` determine the types of the arrays.
    """
    columns = zip(*rows, strict=True) if rows else [()] * len(_types(kind))
    return kind(
        *(np.array(column, dtype=of) for column, of in zip(columns, _types(kind), strict=True))
    )


@cache
def _types(kind: type) -> tuple[type, ...]:
    hints = get_type_hints(kind).values()
    return tuple(np.int64 if hint == IntVector else np.float64 for hint in hints)


def _integers(values: object) -> IntVector:
    return np.array(values, dtype=np.int64)
