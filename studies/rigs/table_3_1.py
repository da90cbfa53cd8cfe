"""Parameters of every friction law, from the thesis's table 3.1.

A law that is not in the thesis has the same values of shared parameters (`STRIBECK`), and small
values of its other parameters. The tests of all laws move 1 kg with some newtons at some tenths of
a metre per second.
"""

from __future__ import annotations

import math

import numpy as np

from frictool.friction.law import Law

STRIBECK = {
    "coulomb": 1.0,
    "breakaway": 1.5,
    "stribeck_velocity": 1e-3,
    "stribeck_exponent": 2.0,
    "viscous": 0.4,
}
STIFF = {"stiffness": 1.5e5, "damping": 2 * math.sqrt(1.5e5)}
HYBRID = {**STRIBECK, "inertia": 1.0, "capture_velocity": 1e-4}

TABLE_3_1: dict[str, dict[str, float]] = {
    "coulomb": {"coulomb": 1.0},
    "coulomb_tanh": {"coulomb": 1.0, "smoothing_velocity": 1e-3},
    "coulomb_atan": {"coulomb": 1.0, "smoothing_velocity": 1e-3},
    "svc": {"coulomb": 1.0, "breakaway": 1.5, "viscous": 0.4},
    "svc_band": {"coulomb": 1.0, "breakaway": 1.5, "viscous": 0.4, "band": 1e-3},
    "stribeck": STRIBECK,
    "karnopp": {"coulomb": 1.0, "breakaway": 1.5, "viscous": 0.4, "band": 1e-3},
    "dahl": {"coulomb": 1.0, "stiffness": 1.5e5},
    "lugre": {**STRIBECK, **STIFF},
    "elasto_plastic": {**STRIBECK, **STIFF, "elastic_limit": 9e-6},
    "leuven": {**STRIBECK, "presliding_limit": 1e-5, "damping": 2 * math.sqrt(1.5e5)},
    "leuven_masing": {**STRIBECK, "presliding_limit": 1e-5, "damping": 2 * math.sqrt(1.5e5)},
    "maxwell_slip": {**STRIBECK, "presliding_limit": 1e-5, "attraction": 1e3},
    "hybrid_a": {**HYBRID, "convergence_rate": 1e3},
    "hybrid_b": {**HYBRID, "presliding_limit": 1e-5},
    "hybrid_c": {**HYBRID, "presliding_limit": 1e-5},
}


def packed(law: Law, chosen: dict[str, float] | None = None) -> np.ndarray:
    return law.pack(chosen or TABLE_3_1[law.name])
