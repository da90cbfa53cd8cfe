"""Report on a simulated mechanism: energy balance, events of each element, warnings.

    work of sources and external efforts = gain of kinetic and stored energy
                                           + losses in friction, links and impacts + residual

The log's metadata record `energy/TOPIC` has the energies [J], `events/TOPIC` the numbers of events.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator

import numpy as np

from frictool.documents.quantity import si_unit
from frictool.engine.mechanism.energy import balance
from frictool.engine.mechanism.events import NAMES, STRIKES
from frictool.engine.mechanism.state import SWINGS, work_by_element
from frictool.plant.mechanism.fastest_link import rates_of
from frictool.simulate.mechanism_runs import MOST_EVENTS, MechanismOutcome, element_of

ENERGY, EVENTS = "energy", "events"


def metadata_of(outcome: MechanismOutcome) -> dict[str, dict[str, str]]:
    """Return the log's metadata records on energies and events of one simulated variant."""
    topic = outcome.variant.whole_topic
    return {
        f"{ENERGY}{topic}": {name: repr(value) for name, value in energy_of(outcome).items()},
        f"{EVENTS}{topic}": {name: str(count) for name, count in events_of(outcome).items()},
    }


def energy_of(outcome: MechanismOutcome) -> dict[str, float]:
    """Return the energies [J] of one simulated variant over the whole simulation.

    The keys are `input`, `kinetic`, `stored`, `lost in NAME` for each element with losses, and
    `residual`. `kinetic` and `stored` are gains of energy.
    """
    made = outcome.variant.assembled
    work = work_by_element(outcome.machine, outcome.state)
    now = balance(outcome.machine, outcome.state)
    energies = {
        "input": now.put_in,
        "kinetic": now.kinetic - outcome.before.kinetic,
        "stored": now.stored - outcome.before.stored,
    }
    lost: Counter[str] = Counter()
    for names, values in (
        (made.joints, work.joints),
        (made.joints, work.impacts),
        (made.couplings, work.couplings),
        (made.frictions, work.frictions),
        (made.pressings, work.pressings),
        (made.stops, work.stops),
    ):
        for name, value in zip(names, values.tolist(), strict=True):
            lost[name] += value
    energies |= {f"lost in {name}": value for name, value in lost.items() if value != 0.0}
    return energies | {"residual": outcome.before.total - now.total}


def events_of(outcome: MechanismOutcome) -> dict[str, int]:
    """Return the number of events by element and kind, with keys such as `ELEMENT KIND`.

    The key `not kept` has the number of events that were not stored (more than MOST_EVENTS).
    """
    counts = Counter(
        f"{element_of(outcome.variant, event)} {NAMES[int(event[1])]}"
        for event in outcome.out.events
    )
    more = int(outcome.out.happened[0]) - MOST_EVENTS
    return dict(sorted(counts.items())) | ({"not kept": more} if more > 0 else {})


def left_out(outcome: MechanismOutcome) -> Iterator[tuple[int, float, float]]:
    """Yield (link, deflection, deflection rate) of each oscillation that the engine suppresses.

    The engine damps a fast link critically. The deflection [rad | m] of the real oscillation is
    about V/k, and its rate [rad/s | m/s] about V/sqrt(k m). V is the sum of the absolute changes of
    the link's spring effort in the simulation, k the stiffness and m the reduced mass. The
    estimates assume that the oscillation causes no event; after an impact, the real values can be
    about 1.4 times as large.
    """
    packed = outcome.variant.assembled.packed
    rates = rates_of(outcome.variant.assembled)
    for link in np.flatnonzero(rates.raised).tolist():
        changes = float(outcome.state.pace[SWINGS + link])
        stiffness = float(packed.couplings.stiffness[link])
        yield (
            link,
            changes / stiffness,
            changes * math.sqrt(float(rates.mobility[link]) / stiffness),
        )


def warnings_of(outcome: MechanismOutcome) -> Iterator[str]:
    """Yield warnings about the assembly, suppressed oscillations, and end stops that were hit."""
    made = outcome.variant.assembled
    if not outcome.variant.name:
        yield from made.notes
    for link, deflection, speed in left_out(outcome):
        unit = si_unit("position", made.kinds[int(made.packed.couplings.b[link])])
        warning = (
            f"{made.couplings[link]} is damped critically; its oscillation of about "
            f"{deflection:.2g} {unit} and {speed:.2g} {unit}/s is left out, "
            "which assumes that the oscillation causes no event"
        )
        yield f"{outcome.variant.topic}: {warning}"
    strikes = outcome.out.events[outcome.out.events[:, 1] == STRIKES]
    for index in np.unique(strikes[:, 2]).astype(int).tolist():
        block = int(made.packed.stops.block[index])
        first = strikes[strikes[:, 2] == index][0]
        warning = (
            f"{made.blocks[block]} strikes its end stop {made.stops[index]}, first at "
            f"{first[0]:.3f} s"
        )
        yield f"{outcome.variant.topic}: {warning}"
