"""Do intervals of what loads an axis beside friction cover at their stated rate, and hold 0 where
there is no load? Over 400 seeds.

Each seed has its own axis, load, effort and noise (tests/support/loaded_axis.py). Judged as the
other coverages (check_identify.py).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from scipy.stats import binom

from frictool.identify.estimators.explanation_search import search_explanations
from frictool.identify.fit_result import SLIDING
from frictool.identify.methods import DEFAULT, IdentificationSettings, run
from tests.support.identification_statistics import CHANCE, RATE, SEEDS
from tests.support.loaded_axis import TERMS, covered, estimates, loaded_axis, rotary_bench


def coverage(kind: str) -> dict[str, Any]:
    """Every parameter of an axis under a load of this kind, by the default method; the bench names
    the load."""
    counts: dict[str, int] = {}
    told: dict[str, int] = {}
    for seed in range(SEEDS):
        for name, hit in covered(seed, kind, DEFAULT).items():
            counts[name], told[name] = counts.get(name, 0) + hit, told.get(name, 0) + 1
    enough = [counts[name] >= int(binom.ppf(CHANCE, told[name], RATE)) for name in counts]
    beside = set(told) - {"inertia", "viscous", "coulomb", "offset"}
    return {
        "passed": all(enough)
        and bool(beside)
        and min(told[name] for name in beside) >= 0.95 * SEEDS,
        "seeds": SEEDS,
        "stated_rate": RATE,
        **{f"covered_{name}": counts[name] for name in counts},
        **{f"told_{name}": told[name] for name in sorted(beside)},
    }


def not_there() -> dict[str, Any]:
    """On axes without load: how often a declared term's interval holds 0, and how often a term is
    found that nobody declared."""
    kinds, zero = ("spring", "gravity", "ripple"), list[bool]()
    axes = (loaded_axis(seed, "") for seed in range(SEEDS))
    found = sum(
        search_explanations([axis.record], axis.bench, IdentificationSettings(RATE))[0] is not None
        for axis in axes
    )
    for seed in range(SEEDS):
        bench = rotary_bench(TERMS[kinds[seed % len(kinds)]])
        fit = run(
            "least-squares", [loaded_axis(seed, "").record], bench, IdentificationSettings(RATE)
        )
        zero += [
            one.low <= 0.0 <= one.high
            for name, one in estimates(fit).items()
            if name not in SLIDING
        ]
    least = int(binom.ppf(CHANCE, len(zero), RATE))
    return {
        "passed": sum(zero) >= least and found <= SEEDS * CHANCE,
        "intervals": len(zero),
        "hold_0": sum(zero),
        "least": least,
        "found": found,
    }


CHECKS: dict[str, Callable[[], dict[str, Any]]] = {
    **{f"loads: coverage, {kind}": partial(coverage, kind) for kind in TERMS},
    "loads: none there": not_there,
}
