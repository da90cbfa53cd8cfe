"""Comparison of the clutch's mechanism (2.16)-(2.23) with its one-inertia model (2.24)-(2.29).

    python -m studies.clutch.mechanism_comparison SPEC BUILD LAW...

The logs of each law, with the same controller, are BUILD/LAW/exhaustive.mcap and reduced.mcap (make
-C configs/clutch mechanism). The columns are

- rotor: largest distance between the rotors of both models at the same time (backlash: 3 rad)
- response: worst 95 % response over the steps, on the nominal plant of each log
- 5.4.1: number of plants of each log that meet all requirements

The exit code is 1 if

- the distance of the rotors exceeds the backlash,
- the responses differ by more than 5 %, or
- a law meets 5.4.1 on the reduced clutch, but not on the exhaustive clutch.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.logs.log import MAIN_TOPIC, MECHANISM_TOPIC, Log
from frictool.logs.log_reader import read_log
from studies.clutch.requirement_counts import Plant, judged

BACKLASH = 3.0  # rad, table 4.8
SAME_RESPONSE = 0.05


@dataclass(frozen=True)
class Compared:
    """One law on both clutches.

    apart, at: largest distance of the rotors [rad] and its time [s]. exhaustive, reduced: plants of
    each log; the first one is nominal.
    """

    law: str
    apart: float
    at: float
    exhaustive: tuple[Plant, ...]
    reduced: tuple[Plant, ...]

    @property
    def response_apart(self) -> float:
        """Return the relative difference of the nominal plants' worst response times.

        The difference is infinite if a plant never settles.
        """
        first, second = self.exhaustive[0].response, self.reduced[0].response
        if first is None or second is None or not np.isfinite([first, second]).all():
            return np.inf
        return abs(second - first) / first

    @property
    def meets(self) -> tuple[bool, bool]:
        """Return True for each clutch (exhaustive, reduced) whose plants all meet 5.4.1."""
        return all(plant.all_met for plant in self.exhaustive), all(
            plant.all_met for plant in self.reduced
        )


def compared(law: str, spec: Spec, exhaustive: Log, reduced: Log) -> Compared:
    """Return the comparison of two logs of one law.

    Raises ValueError if the logs have different scenarios.
    """
    first, second = (
        next(one for one in log.streams if one.topic == MAIN_TOPIC) for log in (exhaustive, reduced)
    )
    if first.time.size != second.time.size or not np.array_equal(
        first.signals["reference"], second.signals["reference"]
    ):
        raise ValueError(f"{exhaustive.source} and {reduced.source} are not of one scenario")
    distance = np.abs(first.signals["position_true"] - second.signals["position_true"])
    worst = int(distance.argmax())
    plants = (tuple(judged(spec, _axes(log))) for log in (exhaustive, reduced))
    return Compared(law, float(distance[worst]), float(first.time[worst]), *plants)


def _axes(log: Log) -> Log:
    """Return the log without the streams of the mechanism's blocks."""
    return Log(
        tuple(one for one in log.streams if not one.topic.startswith(MECHANISM_TOPIC)),
        log.metadata,
        log.source,
    )


def missed(found: Compared) -> list[str]:
    """Return a line for each requirement on the reduction that is not met."""
    out = []
    if found.apart > BACKLASH:
        out.append(
            f"{found.law}: the rotors part by {found.apart:.2f} rad at {found.at:.3f} s, more "
            "than the backlash"
        )
    if found.response_apart > SAME_RESPONSE:
        out.append(f"{found.law}: the responses differ by {100 * found.response_apart:.1f} %")
    exhaustive, reduced = found.meets
    if reduced and not exhaustive:
        out.append(f"{found.law}: meets 5.4.1 on the reduced clutch and not on the exhaustive one")
    return out


def table(laws: list[Compared]) -> list[str]:
    """Return the table with one line per law."""
    lines = [
        f"{'law':<12}{'rotor apart rad':>17}{'at s':>9}{'response ms':>22}{'apart %':>10}"
        f"{'5.4.1 exhaustive':>19}{'reduced':>12}"
    ]
    for one in laws:
        responses = ", ".join(
            "never" if p[0].response is None else f"{1e3 * p[0].response:.1f}"
            for p in (one.exhaustive, one.reduced)
        )
        counts = [
            f"{sum(plant.all_met for plant in group)} of {len(group)}"
            for group in (one.exhaustive, one.reduced)
        ]
        lines.append(
            f"{one.law:<12}{one.apart:>17.3f}{one.at:>9.3f}{responses:>22}"
            f"{100 * one.response_apart:>10.2f}{counts[0]:>19}{counts[1]:>12}"
        )
        unmet = sorted(
            {name for plant in one.exhaustive for name, met in plant.met.items() if not met}
        )
        if unmet:
            lines.append(
                f"{'':<12}exhaustive misses {', '.join(name.replace('_', ' ') for name in unmet)}"
            )
    return lines


def main(arguments: list[str]) -> int:
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    spec, build = load(Path(arguments[0]), Spec), Path(arguments[1])
    found = [
        compared(
            law, spec, *(read_log(build / law / f"{log}.mcap") for log in ("exhaustive", "reduced"))
        )
        for law in arguments[2:]
    ]
    wrong = [what for one in found for what in missed(one)]
    print("\n".join([*table(found), *(["", "MISSED", *wrong] if wrong else [])]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
