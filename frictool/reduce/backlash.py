"""Backlash reflected to the actuator and to the sensor (thesis 2.1.5).

A backlash of width rho at block b has the width rho |q_s'/q_b'| at the block s of the source; q_b'
and q_s' are the speeds of b and s. Widths in series are added. Among parallel paths, the path with
the largest width is used. While the backlash is open, only the blocks between the source and the
backlash move, against the friction of these blocks (thesis (4.45)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictool.documents.mechanism import Mechanism
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.connections import BlockMotion, Connection, connections, seen_from
from frictool.reduce.step_report import StepFigure


@dataclass(frozen=True)
class BacklashChain:
    """Backlash of a mechanism in the coordinate of its source.

    chain: links with backlash on one path; of all paths from the source to a block, this path has
        the largest total backlash.
    width: total backlash of `chain` [rad | m].
    before_sensor: width of the backlash between source and sensor [rad | m].
    hiding: names of the links with backlash between source and sensor.
    behind: names of the blocks that the source moves through a backlash.
    """

    chain: tuple[Connection, ...]
    width: float
    before_sensor: float
    hiding: tuple[str, ...]
    behind: tuple[str, ...]


def play(mechanism: Mechanism, root: str, sensor_block: str) -> BacklashChain:
    """Return the backlash of the mechanism in the coordinate of block `root`."""
    assembled = assemble_cached(mechanism)
    seen = seen_from(assembled.blocks.index(root), connections(assembled), assembled.blocks)
    widths = {
        number: sum(2.0 * link.gap / abs(_b_ratio(seen, link)) for link in one.by)
        for number, one in seen.items()
    }
    widest = max(widths, key=lambda number: (widths[number], -number))
    return BacklashChain(
        tuple(link for link in seen[widest].by if link.gap > 0.0),
        widths[widest],
        widths[assembled.blocks.index(sensor_block)],
        tuple(
            link.name for link in seen[assembled.blocks.index(sensor_block)].by if link.gap > 0.0
        ),
        tuple(assembled.blocks[number] for number in sorted(widths) if widths[number] > 0.0),
    )


def _b_ratio(seen: dict[int, BlockMotion], link: Connection) -> float:
    return seen[link.b].ratio


def play_figures(whole: Mechanism, source_block: str, sensor_block: str) -> tuple[StepFigure, ...]:
    """Return the width of each backlash in the coordinates of its block, actuator and sensor."""
    assembled = assemble_cached(whole)
    links = connections(assembled)
    seen = seen_from(assembled.blocks.index(source_block), links, assembled.blocks)
    to_sensor = abs(seen[assembled.blocks.index(sensor_block)].ratio)
    figures = []
    for link in (one for one in links if one.gap > 0.0):
        width = 2.0 * link.gap
        at_source = 2.0 * link.gap / abs(seen[link.b].ratio)
        figures += [
            StepFigure(
                f"{link.name}: at {assembled.blocks[link.b]}", width, _unit(assembled, link.b)
            ),
            StepFigure(
                f"{link.name}: at the actuator",
                at_source,
                _unit(assembled, assembled.blocks.index(source_block)),
            ),
            StepFigure(
                f"{link.name}: at the sensor",
                at_source * to_sensor,
                _unit(assembled, assembled.blocks.index(sensor_block)),
            ),
        ]
    return tuple(figures)


def _unit(assembled: AssembledMechanism, block: int) -> str:
    return "rad" if assembled.kinds[block] == "rotary" else "m"


def steepest(x: np.ndarray, values: np.ndarray) -> float:
    """Return the largest absolute slope of the curve with `values` (n,) at the positions x (n,)."""
    return float(np.max(np.abs(np.diff(values) / np.diff(x))))
