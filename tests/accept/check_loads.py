"""Do intervals of what loads an axis beside friction cover at their stated rate, and is a load that is not there left out? Over 400 seeds.

Each seed has its own axis, load, effort and noise (tests/identify/loaded_axis.py). Judged as the other coverages (check_identify.py).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from scipy.stats import binom

from frictool.identify.estimators.load_search import with_found_loads
from frictool.identify.methods import DEFAULT, Settings, run
from tests.accept.check_identify import CHANCE, RATE, SEEDS
from tests.identify.loaded_axis import TERMS, covered, loaded_axis, rotary_bench


def coverage(kind: str) -> dict[str, Any]:
    """Every parameter of an axis under a load of this kind, by the default method; the bench names the load."""
    counts: dict[str, int] = {}
    told: dict[str, int] = {}
    for seed in range(SEEDS):
        for name, hit in covered(seed, kind, DEFAULT).items():
            counts[name], told[name] = counts.get(name, 0) + hit, told.get(name, 0) + 1
    enough = [counts[name] >= int(binom.ppf(CHANCE, told[name], RATE)) for name in counts]
    beside = set(told) - {"inertia", "viscous", "coulomb", "offset"}
    return {
        "passed": all(enough) and bool(beside) and min(told[name] for name in beside) >= 0.95 * SEEDS,
        "seeds": SEEDS,
        "stated_rate": RATE,
        **{f"covered_{name}": counts[name] for name in counts},
        **{f"told_{name}": told[name] for name in sorted(beside)},
    }


def needless() -> dict[str, Any]:
    """On axes without load: how often a term that the bench names is kept, and how often one is found that nobody named."""
    kinds, kept = ("spring", "gravity", "ripple", "viscous"), 0
    axes = (loaded_axis(seed, "") for seed in range(SEEDS))
    found = sum(with_found_loads([axis.record], axis.bench, Settings(RATE)).load is not None for axis in axes)
    for seed in range(SEEDS):
        bench = rotary_bench(TERMS[kinds[seed % len(kinds)]])
        kept += run("least-squares", [loaded_axis(seed, "").record], bench, Settings(RATE)).laws is not None
    most = int(binom.isf(CHANCE, SEEDS, 2.0 * (1.0 - RATE)))  # two intervals, of sine and cosine, may fail to hold 0
    return {"passed": kept <= most and found <= SEEDS * CHANCE, "seeds": SEEDS, "kept": kept, "most": most, "found": found}


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    **{f"loads: coverage, {kind}": partial(coverage, kind) for kind in TERMS},
    "loads: none there, none kept": needless,
}
