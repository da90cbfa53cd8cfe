"""H-infinity synthesis: time and gamma, compared with SLICOT and with a plain formulation.

Riccati equations solve one plant; the peer is SLICOT's sb10ad, timed alone in a separate process.
Matrix inequalities solve polytopes; the peer is the plain form (5.61)-(5.62) in cvxpy. SLICOT
cannot solve polytopes. The plain form gets the scaled states and unit of time with which frictool's
synthesis begins; without them, its solvers end with errors on these plants. Further rows show the
growth of the time with the numbers of vertices and states.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.timing import pair
from frictool.adapters.parameter_intervals import intervals
from frictool.lmi.hinf_synthesis import controller, minimise
from frictool.lmi.pole_regions import frame
from frictool.lmi.state_balancing import even_out
from frictool.plant.generalised_plant import (
    GeneralisedPlant,
    PlantWeights,
    generalised_plant,
    template,
)
from frictool.plant.polytope import PlantPoint
from frictool.verify.hinf_norm import norm
from studies.references.printed_inequalities import plain
from studies.references.slicot import AVAILABLE, MISSING, slicot
from studies.rigs.clutch_model import clutch_model
from studies.rigs.mixed_sensitivity import mixed_sensitivity
from studies.rigs.published_plants import LAG, position

RECENTRING, ROUNDS, TIMEOUT = 1.05, 3, 120.0
VERTICES = (1, 2, 4, 8, 16, 32, 64)
ORDERS = (4, 6, 8, 10, 12, 16, 20, 24)
LARGE = 12  # order from which the ratio to SLICOT is judged
SCS_ITERATIONS = 50_000


def row(name: str, peer: str, seconds: tuple[float, float], accuracy: str) -> dict[str, Any]:
    ours, theirs = seconds
    return {
        "id": name,
        "peer": peer,
        "ours": ours,
        "theirs": theirs,
        "unit": "s",
        "ratio": theirs / ours,
        "accuracy": accuracy,
    }


def conditioned(plants: Sequence[GeneralisedPlant]) -> list[GeneralisedPlant]:
    """Return the plants in units of time of the fastest mode, with states of similar size."""
    framed = [frame(plants, None).plant(plant) for plant in plants]
    t = even_out(framed)
    return [plant.transformed(t) for plant in framed]


def worst(plants: Sequence[GeneralisedPlant], recentring: float = RECENTRING) -> str:
    """Return a text on the optimum and the largest norm that the vertex controllers reach."""
    found = minimise(plants, recentring)
    reached = max(norm(plant.closed(controller(plant, found)))[0] for plant in plants)
    return f"gamma {found.optimum:.4f}, at most {reached:.4f} reached of {found.gamma:.4f} asked"


def outcome(plants: Sequence[GeneralisedPlant], solver: str, options: dict[str, Any]) -> str:
    """Return a text on the plain form: solver status, gamma, largest norm of its controllers."""
    try:
        found = plain(plants, solver, **options)
    except Exception as error:  # whatever cvxpy raises is what its user gets
        return type(error).__name__
    reached = max(
        norm(plant.closed(k))[0] for plant, k in zip(plants, found.controllers(plants), strict=True)
    )
    return f"{found.status}, gamma {found.gamma:.4f}, {reached:.4f} reached"


def quietly(call: Callable[[], Any]) -> Callable[[], None]:
    """Return a function that runs `call` and ignores errors of the solver."""

    def run() -> None:
        try:
            call()
        except Exception as error:  # a failure takes its time too; `outcome` tells of it
            if "Solver" not in type(error).__name__:
                raise

    return run


def against_plain(solver: str, options: dict[str, Any], repeats: int) -> dict[str, Any]:
    plants = position()
    given = conditioned(plants)
    seconds = pair(
        lambda: minimise(plants, RECENTRING),
        quietly(lambda: plain(given, solver, **options)),
        repeats,
    )
    said = (
        f"ours {worst(plants)}; plain: {outcome(given, solver, options)}; plain in SI units: "
        f"{outcome(plants, solver, options)}"
    )
    return row(f"synth.clutch_{solver.lower()}", f"plain (5.61), cvxpy+{solver}", seconds, said)


def synth_clutch_clarabel() -> dict[str, Any]:
    """Return the row of the clutch's position loop with 16 vertices, against Clarabel."""
    return against_plain("CLARABEL", {}, ROUNDS)


def synth_clutch_scs() -> dict[str, Any]:
    return against_plain("SCS", {"max_iters": SCS_ITERATIONS}, 1)


def synth_slicot() -> dict[str, Any]:
    """Return the row of one plant of order 12 against SLICOT."""
    if not AVAILABLE:
        raise ModuleNotFoundError(MISSING, name="ctrlsys")
    plant = mixed_sensitivity(12)
    ours, theirs = [], []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        minimise([plant], RECENTRING)
        ours.append(time.perf_counter() - start)
        answer = slicot(plant, TIMEOUT)
        theirs.append(answer.seconds)
    said = f"ours {worst([plant])}; SLICOT gamma {answer.gamma:.4f}"
    return row(
        "synth.slicot",
        "SLICOT sb10ad, order 12",
        (statistics.median(ours), statistics.median(theirs)),
        said,
    )


def timed(plants: Sequence[GeneralisedPlant], repeats: int) -> float:
    """Return the median wall time of `minimise` [s]."""
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        minimise(plants, RECENTRING)
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds)


def synth_vertices() -> dict[str, Any]:
    """Return the row of the growth with the number of plants, 1 to 64.

    The plants are random points of the clutch's ranges. The time for 64 plants is compared with 16
    times the time for four plants (linear growth).
    """
    rng, box, weights = (
        np.random.default_rng(1),
        intervals(clutch_model()),
        PlantWeights(template(20.0, 0.5, 2 / 63), 0.1, 0.05),
    )
    points = [
        PlantPoint(f"r{k}", **{name: float(rng.uniform(*ends)) for name, ends in box.items()})
        for k in range(max(VERTICES))
    ]
    plants = [generalised_plant("position", point.rates, LAG, weights) for point in points]
    minimise(plants[:1], RECENTRING)
    seconds = {count: timed(plants[:count], ROUNDS) for count in VERTICES}
    said = ", ".join(f"{count}: {value:.3f}" for count, value in seconds.items())
    return row(
        "synth.vertices",
        "16 times four vertices",
        (seconds[64], 16.0 * seconds[4]),
        f"seconds for {said} vertices",
    )


def synth_states() -> dict[str, Any]:
    """Return the row of one plant of orders 4 to 24 against SLICOT.

    The ratio is the worst of all orders from LARGE on.
    """
    if not AVAILABLE:
        raise ModuleNotFoundError(MISSING, name="ctrlsys")
    ours = {order: timed([mixed_sensitivity(order)], ROUNDS) for order in ORDERS}
    theirs = {order: slicot(mixed_sensitivity(order), TIMEOUT) for order in ORDERS}
    said = ", ".join(
        f"{order}: {ours[order]:.3f} / {theirs[order].seconds:.3f}" for order in ORDERS
    )
    worst_order = min(
        (order for order in ORDERS if order >= LARGE),
        key=lambda order: theirs[order].seconds / ours[order],
    )
    return row(
        "synth.states",
        f"SLICOT sb10ad, order {worst_order}",
        (ours[worst_order], theirs[worst_order].seconds),
        f"seconds, ours / SLICOT, for {said} states",
    )


def synth_plain_states() -> dict[str, Any]:
    """Return the row of the plain form on plants of orders 4 to 12, without scaled states.

    The accuracy compares the plain form's gamma with frictool's at each order.
    """
    plants = {order: mixed_sensitivity(order) for order in (4, 6, 8, 10, 12)}
    seconds = pair(
        lambda: minimise([plants[12]], RECENTRING), quietly(lambda: plain([plants[12]])), 1
    )
    said = "; ".join(
        f"{order}: {minimise([p], RECENTRING).optimum:.4f}, plain {outcome([p], 'CLARABEL', {})}"
        for order, p in plants.items()
    )
    return row("synth.plain_states", "plain (5.61), order 12", seconds, said)


ROWS = [
    synth_clutch_clarabel,
    synth_clutch_scs,
    synth_slicot,
    synth_vertices,
    synth_states,
    synth_plain_states,
]
