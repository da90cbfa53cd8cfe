"""Presliding on a SIMULATED fine encoder: how often the intervals of each law hold what was put in, and whether the right law is named."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.documents.presliding import Presliding
from frictool.documents.quantity import Estimate
from frictool.documents.registry import load
from frictool.identify.outcome import Interval
from frictool.identify.presliding.document import presliding
from tests.identify.benches import CLUTCH
from tests.identify.presliding_bench import BREAKAWAY, INERTIA, MAXWELL, STIFFNESS, TRUTHS, Z_BA, Z_MAX, curve, slow_loops

SEEDS = 60
COUNT = Z_MAX / 200.0
RATE, CHANCE = 0.95, 1e-3
UNSURE = 0.005  # of the breakaway, that is known to so much


def _held(one: Estimate, truth: float) -> bool:
    return one.interval[0] <= truth <= one.interval[1]


def hits(law: str, found: Presliding) -> dict[str, bool]:
    """Whether the intervals of the law that was put in hold it."""
    contact, elements = getattr(found, law), found.maxwell_slip
    if law != "maxwell_slip":
        out = {"stiffness": _held(contact.stiffness, STIFFNESS)}
        return out | ({"elastic_limit": _held(contact.elastic_limit, Z_BA)} if law == "elasto_plastic" else {})
    assert elements is not None
    inside = [low <= curve(d) <= high for d, low, high in zip(elements.displacement, elements.low, elements.high, strict=True)]
    return {"stiffness": _held(elements.stiffness, float(MAXWELL[1].sum())), "curve": all(inside)}


def coverage() -> dict[str, Any]:
    """All laws."""
    from frictool.documents.bench import Bench

    bench, out, passed = load(CLUTCH, Bench), {}, True
    least = int(binom.ppf(CHANCE, SEEDS, RATE))
    for law in TRUTHS:
        named, counts = 0, {}
        for seed in range(SEEDS):
            value = BREAKAWAY * (1.0 + UNSURE * float(np.random.default_rng([seed, 5]).uniform(-1.0, 1.0)))
            known = Interval(value, value - UNSURE * BREAKAWAY, value + UNSURE * BREAKAWAY)
            found = presliding([slow_loops(law, seed, COUNT)], known, INERTIA, bench, RATE)
            named += found.law == law
            for name, hit in hits(law, found).items():
                counts[name] = counts.get(name, 0) + hit
        out |= {f"{law}_named": named, **{f"{law}_{name}_covered": count for name, count in counts.items()}}
        passed &= named == SEEDS and min(counts.values()) >= least
    return {"passed": passed, "seeds": SEEDS, "least_accepted": least, **out}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {"identify: presliding": coverage}
