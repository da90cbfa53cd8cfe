"""The published gammas of annex C and of 5.4.3 in the readings that the text leaves open, and what
the annex's designs do once sampled.

python -m tests.accept build/accept.json "annex C: gamma" "position: gamma" "position: what the text
leaves open" ...
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from frictool.adapters.model_polytope import polytope, uncertain_centre, uncertain_polytope
from frictool.lmi.hinf_synthesis import PoleDisc, controller, minimise, vertex_controllers
from frictool.plant.generalised_plant import (
    FirstOrderWeight,
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.lti import tustin
from frictool.plant.polytope import PlantPoint, Polytope
from frictool.verify.hinf_norm import norm
from frictool.verify.speed_loop import check_loop
from studies.rigs.annex_model import annex_model
from studies.rigs.clutch_model import clutch_model
from studies.rigs.published_plants import LAG, READINGS, annex_lft, annex_mixed, position

NEAR = 0.01  # of a published or known gamma
RECENTRING, DEFAULT_RECENTRING = 1.05, 1.1
STRICT, RELAXED = (1.0, 1.26), (0.1, 0.05)  # W1, W3
PUBLISHED = (20.9, 1.15)
PERIOD = 1e-3


def _optimum(plants: list[GeneralisedPlant], region: PoleDisc | None = None) -> float:
    return minimise(plants, RECENTRING, region).optimum


def annex_gamma() -> dict[str, Any]:
    """LFT and LPV+LFT in four readings, 1.03 and 1.05 published."""
    found, wrong = {}, []
    for name, reading in READINGS.items():
        for form, known, plants in (
            ("LFT", reading.lft, [annex_lft(reading)]),
            ("LPV+LFT", reading.mixed, annex_mixed(reading)),
        ):
            gamma = found[f"{form}, {name}"] = _optimum(plants)
            if abs(gamma / known - 1.0) > NEAR:
                wrong.append(f"{form}, {name}: {gamma:.4f} for {known}")
    return {"passed": not wrong, **found, "wrong": wrong}


def annex_controllers_agree() -> dict[str, Any]:
    """rho = 0 and rho = 1 get controllers that differ by less than 4 % below 1 kHz; each holds
    gamma; sampled by Tustin none is stable.

    Recentred as designs are by default; nearer to the optimum they differ by some tenths of a per
    cent more, which is told.
    """
    frequencies = 2.0 * np.pi * np.geomspace(1e-2, 1e3, 2000)
    told: dict[str, Any] = {}
    passed = True
    for name in list(READINGS)[:3]:
        plants = annex_mixed(READINGS[name])
        for recentring in (DEFAULT_RECENTRING, RECENTRING):
            lyapunov = minimise(plants, recentring)
            slow, fast = vertex_controllers(plants, lyapunov)
            apart = float(
                np.max(np.abs(fast.response(frequencies) / slow.response(frequencies) - 1.0))
            )
            norms = [
                norm(plant.closed(k))[0] for plant, k in zip(plants, (slow, fast), strict=True)
            ]
            radii = _sampled_radii(READINGS[name].unit, (slow, fast))
            passed = passed and max(norms) <= lyapunov.gamma * (1.0 + NEAR) and min(radii) > 1.0
            passed = passed and (recentring != DEFAULT_RECENTRING or apart < 0.04)
            told |= {
                f"apart, {name}, {recentring:g}": apart,
                f"sampled radius, {name}, {recentring:g}": max(radii),
            }
    return {"passed": passed, **told}


def _sampled_radii(unit: float, controllers: tuple[Any, ...]) -> list[float]:
    """Spectral radius of each vertex's loop with its controller sampled by Tustin at 1 ms, without
    a delay."""
    _, plants = uncertain_polytope(annex_model(), ("regime",), unit)
    return [
        check_loop(tustin(k, PERIOD), plant.rates, LAG, 0).spectral_radius
        for plant, k in zip(plants, controllers, strict=True)
    ]


def annex_sampled() -> dict[str, Any]:
    """Designed at 1 ms directly the annex's weights cannot be met: gamma is far above 1, and rises
    with one sample of delay."""
    told: dict[str, Any] = {}
    passed = True
    for name, reading in READINGS.items():
        plant = uncertain_centre(annex_model(), reading.unit)
        sampled = [
            _optimum(
                [
                    generalised_plant(
                        "speed", plant.rates, LAG, reading.weights, PERIOD, delay, plant.uncertainty
                    )
                ]
            )
            for delay in (0, 1)
        ]
        passed = passed and 1.5 * reading.lft < sampled[0] < sampled[1]
        told |= {f"no delay, {name}": sampled[0], f"one sample, {name}": sampled[1]}
    return {"passed": passed, **told}


def position_gamma() -> dict[str, Any]:
    """Sixteen vertices, continuous: 27.15 and 0.912 at z2 = 20 rad/s, 28.99 and 1.039 at 40."""
    known = {
        (20.0, STRICT): 27.15,
        (20.0, RELAXED): 0.912,
        (40.0, STRICT): 28.99,
        (40.0, RELAXED): 1.039,
    }
    found = {key: _optimum(position(key[0], *key[1])) for key in known}
    wrong = [str(key) for key, gamma in found.items() if abs(gamma / known[key] - 1.0) > NEAR]
    return {
        "passed": not wrong,
        **{f"z2 {z2:g}, W1 {w[0]:g}, W3 {w[1]:g}": gamma for (z2, w), gamma in found.items()},
        "wrong": wrong,
    }


def speed_gamma() -> dict[str, Any]:
    """5.4.4: as drawn gamma is the floor W2(infinity) = 0.5; with 0.01 rad of noise and 30 % of W3
    on the command 2.43."""
    rates = [point.rates for point in polytope(clutch_model()).vertices]

    def optimum(command: float, noise: float) -> float:
        weights = PlantWeights(
            template(40.0, 0.5, 2 / 63), *RELAXED, command, FirstOrderWeight(noise)
        )
        return _optimum([generalised_plant("speed", one, LAG, weights) for one in rates])

    bare, weighed = optimum(0.0, 0.0), optimum(0.3 * RELAXED[1], 0.01)
    return {
        "passed": 0.5 <= bare < 0.52 and abs(weighed / 2.43 - 1.0) < NEAR,
        "as drawn": bare,
        "noise and command": weighed,
    }


def _box(
    inertia: tuple[float, float] = (1.11e-5, 1.53e-5),
    viscous: tuple[float, float] = (0.0, 7.62e-4),
    coulomb: tuple[float, float] = (0.018, 0.180),
    constant: tuple[float, float] = (12.8e-3, 14.0e-3),
) -> Polytope:
    """Table 5.2 with one of its intervals read otherwise."""
    ranges = (inertia, viscous, coulomb, constant)
    corners = tuple(
        PlantPoint(f"v{i}", *corner) for i, corner in enumerate(itertools.product(*ranges), start=1)
    )
    return Polytope(PlantPoint("centre", *(0.5 * sum(ends) for ends in ranges)), corners)


OPEN: dict[str, dict[str, Any]] = {
    "as it stands": {},
    "vertices by (5.49)": {"form": "inertia"},
    "vertices by (5.50)": {"form": "first_order"},
    "centre only": {"box": Polytope(_box().centre, (_box().centre,))},
    "e_stat 1/63": {"static_error": 1 / 63},
    "e_stat 0.05": {"static_error": 0.05},
    "M_mod 0.7": {"margin": 0.7},
    "tau 1 ms": {"lag": 1e-3},
    "tau 10 ms": {"lag": 1e-2},
    "x_max 60 rad": {"travel": 60.0},
    "x_max 48 rad": {"travel": 48.0},
    "K by annex, 13.4 +- 1.2": {"box": _box(constant=(12.2e-3, 14.6e-3))},
    "F_c at its mean": {"box": _box(coulomb=(0.099, 0.099))},
    "F_c by annex, 0.100 +- 0.027": {"box": _box(coulomb=(0.073, 0.127))},
}
DISCS = (300.0, 400.0, 1000.0, 5000.0)  # rad/s, of the closed loop's poles


def what_the_text_leaves_open() -> dict[str, Any]:
    """Each reading's gamma before and after the relaxation, beside the published 20.9 and 1.15.

    Passed where what docs/theory/plants.md says of them holds: none of the readings of the
    vertices, the lag or e_stat moves either by 4 %; the annex's F_c and poles within 300 rad/s, a
    thousand times the slow pole's 0.3, give both within 2 %, and table 5.2's do not.
    """
    told = {}
    for name, reading in OPEN.items():
        travel = reading.get("travel", 63.0)
        rest = {key: value for key, value in reading.items() if key != "travel"}
        told[name] = [
            _optimum(position(20.0, 1.0, travel / 50.0, **rest)),
            _optimum(position(20.0, *RELAXED, **rest)),
        ]
    for radius in DISCS:
        told[f"poles within {radius:g} rad/s"] = [
            _optimum(position(20.0, *STRICT), PoleDisc(-radius, radius)),
            _optimum(position(20.0, *RELAXED), PoleDisc(-radius, radius)),
        ]
    annex = _box(coulomb=(0.073, 0.127))
    both = (
        told["F_c by annex, 0.100 +- 0.027"][0],
        _optimum(position(20.0, *RELAXED, box=annex), PoleDisc(-300.0, 300.0)),
    )
    near = [
        abs(found / published - 1.0) < 0.02
        for found, published in zip(both, PUBLISHED, strict=True)
    ]
    base = told["as it stands"]
    told |= {"F_c by annex, then poles within 300": list(both), "published": list(PUBLISHED)}
    still = all(
        abs(found / start - 1.0) < 0.04
        for name in (
            "vertices by (5.49)",
            "vertices by (5.50)",
            "tau 1 ms",
            "tau 10 ms",
            "e_stat 1/63",
            "e_stat 0.05",
        )
        for found, start in zip(told[name], base, strict=True)
    )
    floor = STRICT[1] * 0.180 / 12.8e-3  # W3 times the current that cancels the largest friction
    for name, (strict, relaxed) in told.items():
        print(f"    {name:<36} {strict:8.3f} {relaxed:8.4f}")
    passed = still and all(near) and floor < base[0]
    return {
        "passed": passed,
        "annex F_c": both[0],
        "and poles within 300 rad/s": both[1],
        "floor of W3 F/K": floor,
        "readings": told,
    }


def the_published_controller_has_poles_of_300_rad_s() -> dict[str, Any]:
    """5.4.3.1: the slowest pole is near -0.3 rad/s, a thousand times slower than the others: so
    with the pole region, not without."""
    weights = PlantWeights(template(20.0, 0.5, 2 / 63), *RELAXED)
    centre = generalised_plant("position", polytope(clutch_model()).centre.rates, LAG, weights)
    fastest = {}
    for name, region in (("none", None), ("disc", PoleDisc(-300.0, 300.0))):
        lyapunov = minimise([centre, *position(20.0, *RELAXED)], RECENTRING, region)
        fastest[name] = float(np.max(np.abs(np.linalg.eigvals(controller(centre, lyapunov).a))))
    return {
        "passed": fastest["disc"] < 400.0 < 3000.0 < fastest["none"],
        **{f"fastest pole, {k}": v for k, v in fastest.items()},
    }


CHECKS = {
    "annex C: gamma": annex_gamma,
    "annex C: the two LPV controllers": annex_controllers_agree,
    "annex C: designed at 1 ms": annex_sampled,
    "position: gamma": position_gamma,
    "speed: gamma": speed_gamma,
    "position: what the text leaves open": what_the_text_leaves_open,
    "position: the published poles": the_published_controller_has_poles_of_300_rad_s,
}
