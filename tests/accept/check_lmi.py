"""The matrix inequalities at full count: random polytopes of both domains, the vertices of the
thesis's problems, and where D12 = 0.

300 random polytopes     solved and rebuilt at the vertices and between them, or refused in one
                         line, within a bounded time
vertex controllers       each of the thesis's problems: the true norm at each vertex over the gamma
                         asked
D12 = 0                  how fast the controllers are, free and within a disc of poles, and what the
                         disc costs
plain form               how far (5.61)-(5.62) without scaling comes on the same plants
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from frictool.adapters.model_polytope import polytope
from frictool.errors import NoSolutionError
from frictool.lmi.hinf_synthesis import PoleDisc, controller, minimise, vertex_controllers
from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti
from frictool.verify.hinf_norm import norm
from frictool.verify.speed_loop import check_loop
from studies.references.printed_inequalities import plain
from studies.rigs.clutch_model import clutch_model
from studies.rigs.published_plants import READINGS, annex_lft, annex_mixed, position
from tests.support.synthesis_plants import LAG, between, clutch_speed, random_polytope

POLYTOPES, BLENDS, RECENTRING, DEFAULT_RECENTRING = 300, 5, 1.05, 1.1
NEAR, ROUNDING, LONGEST = 0.01, 1e-6, 30.0  # of the gamma asked; s for one problem
EASES = (1.0, 1.5, 2.0, 3.0, 5.0)
DISCS = (500.0, 2000.0, 10_000.0)  # rad/s


def reached(plant: GeneralisedPlant, k: Lti) -> float:
    return norm(plant.closed(k))[0]


def random_polytopes() -> dict[str, Any]:
    """Orders 2 to 6, 1 to 8 vertices, small to hopeless spreads. A solved one must hold at the
    vertices and at random blends."""
    rng = np.random.default_rng(5)
    solved, refused, wrong, worst, longest = 0, {}, [], 0.0, 0.0
    for trial in range(POLYTOPES):
        n, count, sampled = (
            int(rng.integers(2, 7)),
            int(2 ** rng.integers(0, 4)),
            bool(rng.integers(2)),
        )
        plants = random_polytope(
            trial, count, n, sampled=sampled, spread=float(10 ** rng.uniform(-2.0, -0.3))
        )
        start = time.perf_counter()
        try:
            found = minimise(plants, RECENTRING)
            controllers = vertex_controllers(plants, found)
        except NoSolutionError as error:
            reason = str(error).split(";")[0].split("(")[0].strip()
            refused[reason] = refused.get(reason, 0) + 1
            continue
        finally:
            longest = max(longest, time.perf_counter() - start)
        solved += 1
        for weights in (*np.eye(count), *rng.dirichlet(np.ones(count), size=BLENDS)):
            parts = (
                sum(
                    weight * getattr(k, part)
                    for weight, k in zip(weights, controllers, strict=True)
                )
                for part in "abcd"
            )
            ratio = reached(between(plants, weights), Lti(*parts, plants[0].period)) / found.gamma
            worst = max(worst, ratio)
            if not ratio <= 1.0 + ROUNDING:
                wrong.append((trial, ratio))
    passed = not wrong and longest < LONGEST and solved > POLYTOPES / 3 and refused
    told = {
        "solved": solved,
        "refused": sum(refused.values()),
        "worst_norm_over_gamma": worst,
        "longest_s": longest,
    }
    return {"passed": bool(passed), **told, "reasons": refused, "wrong": wrong}


PROBLEMS: dict[str, list[GeneralisedPlant]] = {
    "position, strict": position(20.0, 1.0, 1.26),
    "position, relaxed": position(),
    "speed, 1 ms, one sample": clutch_speed(),
    **{f"LFT, {name}": [annex_lft(reading)] for name, reading in READINGS.items()},
    **{f"LPV+LFT, {name}": annex_mixed(reading) for name, reading in READINGS.items()},
}


def controllers_of_the_vertices() -> dict[str, Any]:
    """The controller of each vertex, at that vertex, near the optimum and at the default
    recentring."""
    told: dict[str, Any] = {}
    for name, plants in PROBLEMS.items():
        for recentring in (RECENTRING, DEFAULT_RECENTRING):
            found = minimise(plants, recentring)
            told[f"{name}, {recentring:g}"] = (
                max(reached(plant, controller(plant, found)) for plant in plants) / found.gamma
            )
    return {"passed": max(told.values()) <= 1.0 + NEAR, **told}


def without_d12() -> dict[str, Any]:
    """Position loop: the fastest pole of the centre's controller, and gamma, with closed-loop poles
    within discs of several radii."""
    plants = position()
    told: dict[str, Any] = {}
    for name, region in (
        ("free", None),
        *((f"{radius:g} rad/s", PoleDisc(-radius, radius)) for radius in DISCS),
    ):
        found = minimise(plants, RECENTRING, region)
        controllers = [controller(plant, found) for plant in plants]
        told[f"gamma, {name}"] = found.optimum
        told[f"fastest, {name}"] = max(
            float(np.max(np.abs(np.linalg.eigvals(k.a)))) for k in controllers
        )
        told[f"norm over gamma, {name}"] = (
            max(reached(plant, k) for plant, k in zip(plants, controllers, strict=True))
            / found.gamma
        )
    gammas = [told[f"gamma, {radius:g} rad/s"] for radius in DISCS]
    inside = all(
        told[f"norm over gamma, {name}"] <= 1.0
        for name in ("free", *(f"{radius:g} rad/s" for radius in DISCS))
    )
    return {
        "passed": inside
        and gammas == sorted(gammas, reverse=True)
        and gammas[-1] >= 0.999 * told["gamma, free"],
        **told,
    }


def at_ease() -> dict[str, Any]:
    """The recipe of the speed loop, frozen at the centre: the central controller at gamma and above
    it. Norms over the gamma asked."""
    plants, points = clutch_speed(), polytope(clutch_model()).vertices
    found = minimise(plants, DEFAULT_RECENTRING)
    told: dict[str, Any] = {"gamma": found.optimum}
    kept, margins = True, []
    for ease in EASES:
        k = controller(plants[0], found, ease)
        loops = {
            delay: min(check_loop(k, point.rates, LAG, delay).modulus_margin for point in points)
            for delay in (0, 1)
        }
        own, worst = (
            reached(plants[0], k) / found.gamma,
            max(reached(plant, k) for plant in plants[1:]) / found.gamma,
        )
        corners = (
            max(
                reached(plant, corner)
                for plant, corner in zip(
                    plants, vertex_controllers(plants, found, ease), strict=True
                )
            )
            / found.gamma
        )
        kept = kept and max(own, corners) <= ease * (1.0 + ROUNDING)
        margins.append(loops[1])
        told |= {f"margins, {ease:g}": f"{loops[0]:.3f} / {loops[1]:.3f}", f"own, {ease:g}": own}
        told |= {f"frozen, worst vertex, {ease:g}": worst, f"vertex controllers, {ease:g}": corners}
    return {"passed": kept and margins == sorted(margins), **told}


def plain_form() -> dict[str, Any]:
    """In SI units, as printed: what cvxpy says, and the norm that its controllers (5.63) reach.
    Ours beside it holds."""
    told: dict[str, Any] = {}
    kept = True
    for name in ("position, relaxed", "LPV+LFT, regularised"):
        plants = PROBLEMS[name]
        ours = minimise(plants, RECENTRING)
        kept = kept and all(
            reached(plant, controller(plant, ours)) <= ours.gamma for plant in plants
        )
        told[f"ours, {name}"] = ours.optimum
        for solver, options in (("CLARABEL", {}), ("SCS", {"max_iters": 20_000})):
            try:
                found = plain(plants, solver, **options)
            except (
                Exception
            ) as error:  # whatever cvxpy raises is what a user of the plain form gets
                told[f"{solver}, {name}"] = f"{type(error).__name__}"
                continue
            worst = max(
                reached(plant, k)
                for plant, k in zip(plants, found.controllers(plants), strict=True)
            )
            told[f"{solver}, {name}"] = (
                f"{found.status}, gamma {found.gamma:.4g}, true norm {worst:.4g}"
            )
    return {"passed": kept, **told}


CHECKS = {
    "lmi: random polytopes": random_polytopes,
    "lmi: vertex controllers of the thesis": controllers_of_the_vertices,
    "lmi: D12 = 0": without_d12,
    "lmi: at ease": at_ease,
    "lmi: the plain form": plain_form,
}
