"""Asymmetry of a PID's torque ramps due to compliant flanks (thesis 4.4.4, figures 4.14-4.16).

    python -m studies.clutch.torque_ramps yielding MECHANISM -o YIELDING
        writes the same mechanism with compliant flanks in its backlash
    python -m studies.clutch.torque_ramps compare RIGID.mcap YIELDING.mcap
        prints the table (make -C configs/clutch rebound)

In a limit cycle the integrator ramps the torque up and down between the two torques at which the
rotor breaks away. On the bench "the ramps are not centred around 0", because parts under torsion
push the rotor back. `centre` is the middle of the torques at which the rotor stands, over the
second half of a hold; `half` is half of their range. With rigid flanks the rotor cycles inside the
backlash, against the friction of its brushes only, and the ramps are centred at 0. With compliant
flanks it cycles against a flank under load. Two results are expected; otherwise, the exit code is
1:

- in every hold with rigid flanks, |centre|/half is at most 1/20
- in at least half of the holds with compliant flanks, |centre|/half is above 1/4
"""

from __future__ import annotations

import itertools
import sys
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from frictool.documents.mechanism import Backlash, Compliance, Mechanism, Rack
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.documents.writing import to_yaml
from frictool.logs.log import MAIN_TOPIC, Log
from frictool.logs.log_reader import read_log

STIFFNESS = 3e6  # N/m at the cart: a breakaway of 0.13 N m winds the rotor up by 0.8 rad
DAMPING = 150.0  # N s/m
CENTRED, OFF = 0.05, 0.25  # limits of |centre|/half


@dataclass(frozen=True)
class Ramps:
    """Torques at standstill in a hold at `reference` [rad].

    centre, half: middle and half of the range [N m]. turns: number of reversals of the ramp.
    """

    reference: float
    centre: float
    half: float
    turns: int

    @property
    def asymmetry(self) -> float:
        """Return |centre|/half: 0 for symmetric ramps, at least 1 if the torque keeps its sign."""
        return abs(self.centre) / self.half


def yielding(mechanism: Mechanism) -> Mechanism:
    """Return the clutch's mechanism with compliant flanks in the backlash of its rack."""
    rack = mechanism.links["rack"]
    assert isinstance(rack, Rack)
    assert rack.backlash is not None
    flanks = Compliance(Quantity(STIFFNESS, unit="N/m"), Quantity(DAMPING, unit="N s/m"))
    soft = msgspec.structs.replace(rack, backlash=Backlash(rack.backlash.width, compliance=flanks))
    return msgspec.structs.replace(mechanism, links={**mechanism.links, "rack": soft})


def ramps(log: Log) -> list[Ramps]:
    """Return the torque ramps of each hold of the log."""
    stream = next(one for one in log.streams if one.topic == MAIN_TOPIC)
    reference, torque = stream.signals["reference"], stream.signals["effort"]
    still = stream.signals["velocity"] == 0.0
    starts = [0, *(np.flatnonzero(np.diff(reference)) + 1).tolist(), reference.size]
    found = []
    for start, end in itertools.pairwise(starts):
        later = slice((start + end) // 2, end)
        standing = torque[later][still[later]]
        steps = np.sign(np.diff(standing))
        turns = int(np.count_nonzero(np.diff(steps[steps != 0.0])))
        low, high = float(standing.min()), float(standing.max())
        found.append(Ramps(float(reference[start]), 0.5 * (low + high), 0.5 * (high - low), turns))
    return found


def missed(rigid: list[Ramps], soft: list[Ramps]) -> list[str]:
    """Return a line for each result that contradicts the asymmetry of the thesis."""
    out = [
        f"rigid flanks, {one.reference:g} rad: ramps around {one.centre:.4f} N m"
        for one in rigid
        if one.asymmetry > CENTRED
    ]
    aside = sum(one.asymmetry > OFF for one in soft)
    if 2 * aside < len(soft):
        out.append(f"compliant flanks: ramps off centre on {aside} of {len(soft)} holds")
    return out


def _shown(centred: int, holds: int) -> str:
    return (
        f"rigid flanks: ramps around 0 on {centred} of {holds} holds; "
        "compliant flanks: ramps off centre on most"
    )


def main(arguments: list[str]) -> int:
    match arguments:
        case ["yielding", source, "-o", target]:
            Path(target).write_text(to_yaml(yielding(load(Path(source), Mechanism))))
            return 0
        case ["compare", rigid, soft]:
            found = [ramps(read_log(Path(path))) for path in (rigid, soft)]
            print(
                f"{'hold at rad':<14}{'rigid: centre':>15}{'half N m':>10}{'turns':>7}"
                f"{'yielding: centre':>19}{'half N m':>10}{'turns':>7}"
            )
            for one, other in zip(*found, strict=True):
                print(
                    f"{one.reference:<14g}{one.centre:>15.4f}{one.half:>10.4f}{one.turns:>7}"
                    f"{other.centre:>19.4f}{other.half:>10.4f}{other.turns:>7}"
                )
            wrong = missed(*found)
            centred = sum(one.asymmetry <= CENTRED for one in found[0])
            print("\n".join(["MISSED", *wrong]) if wrong else _shown(centred, len(found[0])))
            return 1 if wrong else 0
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
