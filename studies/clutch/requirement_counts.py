"""Number of plants on which a design meets 5.4.1, their metrics, and the energy of table 5.3.

    python -m studies.clutch.requirement_counts judge SPEC CONTROLLER LOG... -o FIGURES.json
        writes a line of metrics for each plant of the logs

    python -m studies.clutch.requirement_counts print FIGURES.json...
        prints the table (make -C configs/clutch counts)

Each plant is judged separately with the requirements of `frictool report`. The nominal plant of a
log is not counted. The exit code is 1 if a design misses its TARGETS.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import mean, median

from frictool.documents.controller import Controller
from frictool.documents.registry import load
from frictool.documents.spec import Spec
from frictool.logs.log import MAIN_TOPIC, Log
from frictool.logs.log_reader import read_log
from frictool.metrics.energy import energy
from frictool.report.verdict import judge

T_INT = 0.28  # s, table 5.3
PUBLISHED = {"rst": 223.81, "position": 222.45, "speed": 210.28}  # A^2, table 5.3
FAST = 0.122  # s


@dataclass(frozen=True)
class Target:
    """Least numbers of vertices (of 16) and random plants (of 1000) that meet the specification.

    response: largest response time at a vertex [s], or None.
    """

    vertices: int
    plants: int
    response: float | None = None


TARGETS = {"speed": Target(16, 995), "position": Target(14, 825), "fast": Target(16, 995, FAST)}


@dataclass(frozen=True)
class Plant:
    """Result of one plant: requirements, worst values over the steps, and energy.

    met: requirement -> True if it is met. response [s], overshoot [%], error [rad]: worst value;
    None if undefined. energy [A^2]: of the steps from 5 to 55 rad and back.
    """

    name: str
    met: dict[str, bool]
    response: float | None
    overshoot: float | None
    error: float | None
    rest_drive: float | None
    energy: tuple[float, float]

    @property
    def all_met(self) -> bool:
        return all(self.met.values())


@dataclass(frozen=True)
class Counted:
    """Results of one design on all plants.

    margin: worst modulus margin over the vertices, with the bench's delay.
    """

    design: str
    margin: float
    nominal: Plant
    vertices: tuple[Plant, ...]
    plants: tuple[Plant, ...]


def judged(spec: Spec, log: Log) -> list[Plant]:
    """Return the result of each stream of a log, judged separately.

    Raises ValueError if a requirement is undecided, since the plant could not be counted.
    """
    found = []
    for stream in log.streams:
        requirements = {
            one.name: one
            for one in judge(spec, [Log((stream,), log.metadata, log.source)]).requirements
        }
        del requirements["modulus_margin"]
        undecided = [name for name, one in requirements.items() if one.met is None]
        if undecided:
            raise ValueError(f"{log.source} {stream.topic}: cannot tell {', '.join(undecided)}")
        met = {name: bool(one.met) for name, one in requirements.items()}
        response, overshoot, error, rest = (
            requirements[name].value
            for name in ("response_time_95", "overshoot", "static_error", "rest")
        )
        spent = _energies(log, stream.topic)
        found.append(Plant(stream.topic, met, response, overshoot, error, rest, spent))
    return found


def _energies(log: Log, topic: str) -> tuple[float, float]:
    """Return the energies of the first two steps, (T_e/t_int) sum i^2 over [0, t_int] (table 5.3).

    T_e is the sample period, and i the measured current.
    """
    stream = next(one for one in log.streams if one.topic == topic)
    reference, current = stream.signals["reference"], stream.signals["current"]
    starts = [0, int((reference != reference[0]).argmax())]
    first, second = (energy(stream.time[k:], current[k:], T_INT) for k in starts)
    assert isinstance(first, float)
    assert isinstance(second, float)
    return first, second


def counted(spec: Spec, controller: Controller, logs: Iterable[Log]) -> Counted:
    """Return the results of all logs of a design.

    A plant with the name of a vertex of the controller is a vertex; the others are random plants.
    """
    names = {f"{MAIN_TOPIC}/{vertex.name}" for vertex in controller.verified.vertices}
    nominal: list[Plant] = []
    vertices: list[Plant] = []
    plants: list[Plant] = []
    for log in logs:
        for plant in judged(spec, log):
            (
                nominal if plant.name == MAIN_TOPIC else vertices if plant.name in names else plants
            ).append(plant)
    margin = min(vertex.modulus_margin for vertex in controller.verified.vertices)
    return Counted(controller.name, margin, nominal[0], tuple(vertices), tuple(plants))


def missed(found: Counted) -> list[str]:
    """Return a line for each part of its target that the design misses."""
    target = TARGETS.get(found.design)
    if target is None:
        return []
    out = []
    for what, group, least in (
        ("vertices", found.vertices, target.vertices),
        ("random plants", found.plants, target.plants),
    ):
        if sum(plant.all_met for plant in group) < least:
            out.append(
                f"{what}: {sum(plant.all_met for plant in group)} of {len(group)}, asked {least}"
            )
        resting = sum(plant.met["rest"] for plant in group)
        if resting < least:
            out.append(f"{what} at rest without current: {resting} of {len(group)}, asked {least}")
    slow = [
        plant
        for plant in found.vertices
        if target.response is not None and (plant.response or 9.0) > target.response
    ]
    if slow:
        out.append(f"{len(slow)} vertices slower than {target.response} s")
    if found.margin < 0.5:
        out.append(f"modulus margin {found.margin:.3f}, asked 0.5")
    return out


def table(designs: list[Counted]) -> list[str]:
    """Return the lines of the counts, then of table 5.3."""
    names = list(designs[0].nominal.met)
    heads = "".join(f"{name.replace('_', ' ').replace(' time 95', ''):>14}" for name in names)
    lines = [
        f"{'':<26}{'all of them':>12}{heads}   response ms      overshoot %     error rad       "
        "(median, worst)"
    ]
    for found in designs:
        for what, group in (
            (f"{len(found.vertices)} vertices", found.vertices),
            (f"{len(found.plants)} random plants", found.plants),
        ):
            if group:
                lines.append(_row(f"{found.design}, {what}", group, names))
    lines += [
        "",
        f"{'energy over 0.28 s, A²':<26}{'5-55 rad':>9}{'55-5 rad':>9}{'both':>9}   published   "
        "vertices   random plants   margin",
    ]
    for found in designs:
        printed = f"{PUBLISHED[found.design]:.2f}" if found.design in PUBLISHED else "-"
        groups = [
            f"{mean(mean(p.energy) for p in group):.1f}" if group else "-"
            for group in (found.vertices, found.plants)
        ]
        first, second = found.nominal.energy
        figures = f"{first:>9.1f}{second:>9.1f}{mean((first, second)):>9.1f}"
        lines.append(
            f"{found.design:<26}{figures}{printed:>12}{groups[0]:>11}{groups[1]:>16}"
            f"{found.margin:>9.3f}"
        )
    return lines


def _row(title: str, group: tuple[Plant, ...], names: list[str]) -> str:
    counts = "".join(f"{sum(plant.met[name] for plant in group):>14}" for name in names)
    scales = (("response", 1e3, 0), ("overshoot", 1.0, 1), ("error", 1.0, 2))
    figures = "   ".join(
        _middle_and_worst([getattr(plant, name) for plant in group], scale, digits)
        for name, scale, digits in scales
    )
    return f"{title:<26}{sum(plant.all_met for plant in group):>12}{counts}   {figures}"


def _middle_and_worst(values: list[float | None], scale: float, digits: int) -> str:
    known = [float("inf") if value is None else scale * value for value in values]
    return f"{median(known):.{digits}f}, {max(known):.{digits}f}".rjust(13)


def spends_least(designs: list[Counted]) -> bool:
    """Return True if the speed controller uses less energy than the position controller and RST.

    This must hold for the nominal plant, and for the means over vertices and over random plants.
    """
    known = {found.design: found for found in designs if found.design in PUBLISHED}
    if len(known) < len(PUBLISHED):
        return True

    def spent(found: Counted) -> tuple[float, ...]:
        groups = ((found.nominal,), found.vertices, found.plants)
        return tuple(mean(mean(plant.energy) for plant in group) for group in groups if group)

    speed = spent(known.pop("speed"))
    return all(
        ours < theirs
        for other in known.values()
        for ours, theirs in zip(speed, spent(other), strict=True)
    )


def _read(path: Path) -> Counted:
    raw = json.loads(path.read_text())
    groups = {
        key: tuple(Plant(**{**plant, "energy": tuple(plant["energy"])}) for plant in raw[key])
        for key in ("vertices", "plants")
    }
    nominal = Plant(**{**raw["nominal"], "energy": tuple(raw["nominal"]["energy"])})
    return Counted(raw["design"], raw["margin"], nominal, **groups)


def main(arguments: list[str]) -> int:
    match arguments:
        case ["judge", spec, controller, *logs, "-o", target]:
            found = counted(
                load(Path(spec), Spec),
                load(Path(controller), Controller),
                (read_log(Path(log)) for log in logs),
            )
            Path(target).write_text(json.dumps(asdict(found)) + "\n")
            return 0
        case ["print", *paths] if paths:
            designs = [_read(Path(path)) for path in paths]
            wrong = [f"{found.design}: {what}" for found in designs for what in missed(found)]
            wrong += (
                []
                if spends_least(designs)
                else ["the speed controller does not use less energy than the others"]
            )
            print("\n".join([*table(designs), *(["", "MISSED", *wrong] if wrong else [])]))
            return 1 if wrong else 0
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
