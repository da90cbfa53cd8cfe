"""Packed mechanisms for tests, assembled without a document."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from frictool.friction.law_registry import LAWS, ROWS
from frictool.plant.mechanism import packed_mechanism as pk
from frictool.typing import Vector


def _columns(rows: Sequence[Mapping[str, Any]], kind: Any, whole: Sequence[str]) -> Any:
    return kind(
        **{
            name: np.array(
                [row[name] for row in rows], dtype=np.int64 if name in whole else np.float64
            )
            for name in kind._fields
        }
    )


@dataclass
class Builder:
    """Builder to which elements are added one by one; `packed()` returns the arrays."""

    inertia: list[float] = field(default_factory=list)
    scale: list[float] = field(default_factory=list)
    joints: list[dict[str, Any]] = field(default_factory=list)
    couplings: list[dict[str, Any]] = field(default_factory=list)
    frictions: list[tuple[int, int, Vector, int]] = field(default_factory=list)
    pressings: list[dict[str, Any]] = field(default_factory=list)
    pushes: list[dict[str, Any]] = field(default_factory=list)
    stops: list[dict[str, Any]] = field(default_factory=list)
    sources: list[dict[str, Any]] = field(default_factory=list)
    curves: list[tuple[Vector, Vector]] = field(default_factory=list)

    def block(self, inertia: float, scale: float = 1.0) -> int:
        self.inertia.append(inertia)
        self.scale.append(scale)
        return len(self.inertia) - 1

    def joint(self, a: int, b: int, ratio: float = 1.0, **more: float) -> int:
        row = {
            "offset": 0.0,
            "gap": 0.0,
            "restitution": 0.0,
            "drive_loss": 0.0,
            "back_loss": 0.0,
            "thread": 0.0,
            "thesis_screw": 0.0,
        }
        self.joints.append({**row, "a": a, "b": b, "ratio": ratio, **more})
        return len(self.joints) - 1

    def coupling(
        self,
        a: int,
        b: int,
        stiffness: float,
        damping: float = 0.0,
        ratio: float = 1.0,
        **more: Any,
    ) -> int:
        row = {"offset": 0.0, "gap": 0.0, "curve": -1, "drive_loss": 0.0, "back_loss": 0.0}
        self.couplings.append(
            {
                **row,
                "a": a,
                "b": b,
                "ratio": ratio,
                "stiffness": stiffness,
                "damping": damping,
                **more,
            }
        )
        return len(self.couplings) - 1

    def friction(self, block: int, law: str, level: int = -1, **values: float) -> int:
        chosen = LAWS[law]
        self.frictions.append((block, ROWS.index(chosen), chosen.pack(values), level))
        return len(self.frictions) - 1

    def pressing(
        self, block: int, force: int, coefficient: float, breakaway_ratio: float = 1.0
    ) -> None:
        self.pressings.append(
            {
                "block": block,
                "force": force,
                "coefficient": coefficient,
                "breakaway_ratio": breakaway_ratio,
            }
        )

    def push(self, block: int, constant: float = 0.0, curve: int = -1) -> None:
        self.pushes.append({"block": block, "constant": constant, "curve": curve})

    def stop(
        self, block: int, low: float = -math.inf, high: float = math.inf, restitution: float = 0.0
    ) -> None:
        self.stops.append({"block": block, "low": low, "high": high, "restitution": restitution})

    def source(
        self,
        block: int,
        constant: float = 1.0,
        limit: float = math.inf,
        lag: float = 0.0,
        **more: float,
    ) -> None:
        row = {"resistance": 0.0, "supply": 0.0}
        self.sources.append(
            {**row, "block": block, "constant": constant, "limit": limit, "lag": lag, **more}
        )

    def curve(self, breaks: Sequence[float], cubic: Sequence[Sequence[float]]) -> int:
        self.curves.append((np.array(breaks, dtype=float), np.array(cubic, dtype=float)))
        return len(self.curves) - 1

    def packed(self) -> pk.PackedMechanism:
        f = self.frictions
        values = [row[2] for row in f]
        curves = pk.Curves(
            np.concatenate([[0], np.cumsum([c[1].shape[0] for c in self.curves])]).astype(np.int64),
            np.concatenate([c[0] for c in self.curves]) if self.curves else np.zeros(0),
            np.concatenate([c[1] for c in self.curves]) if self.curves else np.zeros((0, 4)),
        )
        places = [np.array([row[i] for row in f], dtype=np.int64) for i in (0, 1, 3)]
        starts = np.concatenate([[0], np.cumsum([v.size for v in values])]).astype(np.int64)
        frictions = pk.Frictions(
            places[0],
            places[1],
            starts,
            np.concatenate(values) if values else np.zeros(0),
            places[2],
        )
        return pk.PackedMechanism(
            np.array(self.inertia),
            np.array(self.scale),
            _columns(self.joints, pk.Joints, ("a", "b")),
            _columns(self.couplings, pk.Couplings, ("a", "b", "curve")),
            frictions,
            _columns(self.pressings, pk.Pressings, ("block", "force")),
            _columns(self.pushes, pk.Pushes, ("block", "curve")),
            _columns(self.stops, pk.Stops, ("block",)),
            _columns(self.sources, pk.PackedDrives, ("block",)),
            curves,
        )
