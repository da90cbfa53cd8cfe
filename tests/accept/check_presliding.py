"""Presliding on a SIMULATED fine encoder: how often the intervals of each law hold what was put in,
and whether the right law is named."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.stats import binom

from frictool.documents.presliding import Presliding
from frictool.documents.quantity import Estimate
from frictool.documents.registry import load
from frictool.friction.preisach_cycles import masing_everett
from frictool.identify.fit_result import Interval
from frictool.identify.presliding.loops import find_loops
from frictool.identify.presliding.preisach import preisach
from frictool.identify.presliding.presliding_laws import presliding
from studies.rigs.identification_rigs import CLUTCH
from tests.support.identification_statistics import HIGHEST, LOWEST
from tests.support.presliding_bench import (
    BREAKAWAY,
    INERTIA,
    MAXWELL,
    STIFFNESS,
    TRUTHS,
    Z_BA,
    Z_MAX,
    centred_cycles,
    curve,
    slow_loops,
)

SEEDS = 60
COUNT = Z_MAX / 200.0
RATE, CHANCE = 0.95, 1e-3
UNSURE = 0.005  # of the breakaway, that is known to so much
PREISACH_SEEDS, PREISACH_NOISE = 100, 0.01  # of the breakaway


def _held(one: Estimate, truth: float) -> bool:
    return one.interval[0] <= truth <= one.interval[1]


def hits(law: str, found: Presliding) -> dict[str, bool]:
    """Return, for each parameter of the simulated law, if its interval holds the true value."""
    contact, elements = getattr(found, law), found.maxwell_slip
    if law != "maxwell_slip":
        out = {"stiffness": _held(contact.stiffness, STIFFNESS)}
        return out | (
            {"elastic_limit": _held(contact.elastic_limit, Z_BA)} if law == "elasto_plastic" else {}
        )
    assert elements is not None
    inside = [
        low <= curve(d) <= high
        for d, low, high in zip(elements.displacement, elements.low, elements.high, strict=True)
    ]
    return {"stiffness": _held(elements.stiffness, float(MAXWELL[1].sum())), "curve": all(inside)}


def coverage() -> dict[str, Any]:
    """All laws."""
    from frictool.documents.bench import Bench

    bench, out, passed = load(CLUTCH, Bench), {}, True
    least = int(binom.ppf(CHANCE, SEEDS, RATE))
    for law in TRUTHS:
        named, counts = 0, {}
        for seed in range(SEEDS):
            value = BREAKAWAY * (
                1.0 + UNSURE * float(np.random.default_rng([seed, 5]).uniform(-1.0, 1.0))
            )
            known = Interval(value, value - UNSURE * BREAKAWAY, value + UNSURE * BREAKAWAY)
            found = presliding([slow_loops(law, seed, COUNT)], known, INERTIA, bench, RATE)
            named += found.law == law
            for name, hit in hits(law, found).items():
                counts[name] = counts.get(name, 0) + hit
        out |= {
            f"{law}_named": named,
            **{f"{law}_{name}_covered": count for name, count in counts.items()},
        }
        passed &= named == SEEDS and min(counts.values()) >= least
    return {"passed": passed, "seeds": SEEDS, "least_accepted": least, **out}


def preisach_coverage() -> dict[str, Any]:
    """Everett's table from centred cycles of a Masing hysteresis, 3 of each of 10 amplitudes: its
    entries, the saturation, the reach."""
    truth = masing_everett().reshape(21, 21)
    below, shares, told = (
        np.tril(np.ones(truth.shape, dtype=np.bool_), -1),
        [],
        {"saturation": 0, "limit": 0},
    )
    for seed in range(PREISACH_SEEDS):
        phase = float(np.random.default_rng([seed, 3]).random())
        known = Interval(BREAKAWAY, (1.0 - UNSURE) * BREAKAWAY, (1.0 + UNSURE) * BREAKAWAY)
        found = preisach(find_loops([centred_cycles(3, PREISACH_NOISE, seed, phase)], known), RATE)
        if found.everett.shape != truth.shape:
            continue
        shares.append(float(np.mean((np.abs(found.everett - truth) <= found.half_width)[below])))
        told["saturation"] += found.saturation.low <= BREAKAWAY <= found.saturation.high
        told["limit"] += found.limit.low <= Z_MAX <= found.limit.high
    covered, least = float(np.mean(shares)), int(binom.ppf(CHANCE, PREISACH_SEEDS, RATE))
    return {
        "passed": len(shares) == PREISACH_SEEDS
        and LOWEST <= covered <= HIGHEST
        and min(told.values()) >= least,
        "seeds": PREISACH_SEEDS,
        "all_amplitudes_told": len(shares),
        "covered_entries": covered,
        "least_accepted": least,
        **{f"covered_{name}": count for name, count in told.items()},
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    "identify: presliding": coverage,
    "identify: presliding, Preisach": preisach_coverage,
}
