"""Types of the kernels of each kind of law, in the order of the fields in friction/law.py."""

from __future__ import annotations

from typing import Any

from frictool.friction import kernel_signatures as s
from frictool.friction.law import DynamicKernels, HybridKernels, StaticKernels

SIGNATURES: dict[type, tuple[Any, ...]] = {
    StaticKernels: (s.SLIP_FORCE, s.BREAKAWAY, s.BAND, s.SEEN_VELOCITY),
    DynamicKernels: (s.RATE, s.FORCE, s.COMMIT, s.RESET),
    HybridKernels: (
        s.MODE_AFTER,
        s.ENTER,
        s.HYBRID_FORCE,
        s.HYBRID_ACCELERATION,
        s.HYBRID_RATE,
        s.HYBRID_COMMIT,
        s.RESET,
    ),
}
