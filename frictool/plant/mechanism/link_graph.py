"""Graph of blocks and links: rigid groups, loops, and unconnected parts.

A rigid group is a set of blocks that move together, q_i = ratio_i q_root + constant. Rigid links
must not form a loop, with one exception: if the ratios around a loop multiply to 1 and no link of
the loop has a loss, the link that closes the loop is redundant and is dropped.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from frictool.plant.mechanism.element_error import ElementError
from frictool.plant.mechanism.speed_scale import check_speeds

CLOSED = 1e-9  # allowed deviation from 1 of the product of the ratios around a loop


@dataclass(frozen=True)
class Transmission:
    """One link between the blocks a and b, in SI.

    - gap: half of the backlash, in the coordinate of b
    - stiffness, damping: in the coordinate of b; the stiffness of a rigid link is None

    packed_mechanism.py defines the other fields.
    """

    name: str
    a: int
    b: int
    ratio: float
    drive_loss: float = 0.0
    back_loss: float = 0.0
    thread: float = 0.0
    thesis_screw: float = 0.0
    gap: float = 0.0
    restitution: float = 0.0
    stiffness: float | None = None
    damping: float = 0.0

    @property
    def lossless(self) -> bool:
        """Return True if no power is lost in the link."""
        return self.drive_loss == self.back_loss == self.thread == self.thesis_screw == 0.0

    @property
    def self_locking(self) -> bool:
        """Return True if block b cannot drive block a."""
        return abs(self.ratio) <= max(self.back_loss, self.thread)

    @property
    def rigid(self) -> bool:
        """Return True if the link has no compliance; it may have backlash."""
        return self.stiffness is None


@dataclass(frozen=True)
class RigidGroup:
    """Blocks that move together.

    - ratios: speed of each block of the group divided by the speed of `root`
    - inertia: total inertia reflected to `root`
    """

    root: int
    blocks: tuple[int, ...]
    ratios: tuple[float, ...]
    inertia: float


class LinkForest:
    """Forest of links between blocks: a graph without loops."""

    def __init__(self, count: int) -> None:
        self.neighbours: list[list[tuple[int, float, Transmission]]] = [[] for _ in range(count)]

    def add(self, link: Transmission) -> None:
        """Add a link between two blocks that are not yet connected by any path."""
        self.neighbours[link.a].append((link.b, link.ratio, link))
        self.neighbours[link.b].append((link.a, 1.0 / link.ratio, link))

    def path(self, start: int, end: int) -> list[tuple[int, float, Transmission]] | None:
        """Return the steps of the path between two blocks; None if no path connects them.

        Each step is (next block, ratio, link). The ratio is the speed of the next block divided by
        the speed of the block before.
        """
        before: dict[int, tuple[int, tuple[int, float, Transmission]] | None] = {start: None}
        queue = deque([start])
        while queue and end not in before:
            here = queue.popleft()
            for step in self.neighbours[here]:
                if step[0] not in before:
                    before[step[0]] = (here, step)
                    queue.append(step[0])
        if end not in before:
            return None
        steps = []
        at = end
        while (origin := before[at]) is not None:
            steps.append(origin[1])
            at = origin[0]
        return steps[::-1]

    def reached(self, root: int) -> dict[int, float]:
        """Return the speed of every block connected to `root`, relative to the speed of `root`."""
        ratio = {root: 1.0}
        queue = deque([root])
        while queue:
            here = queue.popleft()
            for there, step, _ in self.neighbours[here]:
                if there not in ratio:
                    ratio[there] = ratio[here] * step
                    queue.append(there)
        return ratio


def without_loops(
    links: Sequence[Transmission], names: Sequence[str]
) -> tuple[list[Transmission], list[str]]:
    """Return the rigid links, without redundant links, and a note for each redundant link.

    Raises ElementError if a loop has no redundant link.
    """
    forest = LinkForest(len(names))
    kept: set[str] = set()
    notes = []
    for link in sorted(
        links, key=lambda link: link.gap > 0.0
    ):  # links with backlash last: the error of a loop then names the link with backlash
        path = forest.path(link.a, link.b)
        if path is None:
            forest.add(link)
            kept.add(link.name)
        else:
            notes.append(_redundant(link, path, names))
    _refuse_facing(
        forest, [link for link in links if link.name in kept and link.self_locking], names
    )
    return [link for link in links if link.name in kept], notes


def _refuse_facing(forest: LinkForest, links: Sequence[Transmission], names: Sequence[str]) -> None:
    for one, other in itertools.combinations(links, 2):
        path = forest.path(one.a, other.a)
        if (
            path and path[0][2] is one and path[-1][2] is other
        ):  # way is empty if one block drives both links
            driven = (
                f"{names[one.b]},"
                if one.b == other.b
                else f"{names[one.b]} and {names[other.b]}, rigidly linked,"
            )
            raise ElementError(
                f"links.{other.name}",
                f"{other.name} and {one.name} are self-locking and both drive {driven} "
                "so that nothing can move; make one of these two links back-drivable or compliant",
            )


def _redundant(
    link: Transmission, path: list[tuple[int, float, Transmission]], names: Sequence[str]
) -> str:
    """Return a note if the link is redundant; raise ElementError if its loop is not allowed."""
    key = f"links.{link.name}"
    round_trip = 1.0 / link.ratio
    for _, step, _ in path:
        round_trip *= step
    loop = (
        f"{names[link.a]} - "
        f"{' - '.join(f'{other.name} - {names[there]}' for there, _, other in path)} - {link.name}"
    )
    if len(path) == 1 and abs(round_trip - 1.0) > CLOSED:
        first = names[link.a]
        second = names[link.b]
        other = path[0][2].name
        raise ElementError(
            key,
            f"moves {second} {link.ratio:.6g} times as far as {first}, but the link {other} moves "
            f"{second} {path[0][1]:.6g} times as far; make the ratios equal, or one of the two "
            "links compliant",
        )
    if abs(round_trip - 1.0) > CLOSED:
        raise ElementError(
            key,
            f"closes the loop {loop}, whose ratios multiply to {round_trip:.10g}; "
            "allowed: a product of 1; "
            "correct a ratio or a direction, or make a link compliant",
        )
    playing = next(
        (other.name for other in (link, *(step[2] for step in path)) if other.gap > 0.0), None
    )
    if playing is not None:
        raise ElementError(
            key,
            f"closes the loop {loop}, in which {playing} has backlash but no compliance; give "
            f"{playing} a compliance",
        )
    lossy = next(
        (other.name for other in (link, *(step[2] for step in path)) if not other.lossless), None
    )
    if lossy is not None:
        raise ElementError(
            key,
            f"closes the loop {loop}, in which {lossy} has a loss: "
            "the forces in the loop are not determined; "
            f"allowed: a rigid loop without loss; remove {link.name}, or give it a compliance",
        )
    return f"{link.name} is left out: it closes the loop {loop} and adds no constraint"


def groups_of(
    links: Sequence[Transmission], inertia: Sequence[float], names: Sequence[str]
) -> tuple[RigidGroup, ...]:
    """Return the rigid groups in the order of their first blocks.

    `links` must form no loop. Links with backlash do not join blocks to a group. Raises
    ElementError for a group without inertia.
    """
    forest = LinkForest(len(names))
    for link in links:
        if link.gap == 0.0:
            forest.add(link)
    groups: list[RigidGroup] = []
    seen: set[int] = set()
    for root in range(len(names)):
        if root in seen:
            continue
        ratio = forest.reached(root)
        seen |= set(ratio)
        check_speeds(ratio, root, names)
        blocks = tuple(sorted(ratio))
        total = sum(ratio[block] ** 2 * inertia[block] for block in blocks)
        if total <= 0.0:
            group_names = ", ".join(names[block] for block in blocks)
            raise ElementError(
                f"blocks.{names[root]}",
                f"{group_names} has no inertia; add an inertia, or a rigid link without backlash "
                "to a block with inertia",
            )
        groups.append(RigidGroup(root, blocks, tuple(ratio[block] for block in blocks), total))
    return tuple(groups)


def loose_parts(
    links: Sequence[tuple[int, int]], anchored: set[int], count: int
) -> list[list[int]]:
    """Return the connected parts of the mechanism that contain none of the blocks `anchored`.

    - links: pairs of blocks that a link of any kind connects
    - count: number of blocks
    """
    neighbours: list[list[int]] = [[] for _ in range(count)]
    for a, b in links:
        neighbours[a].append(b)
        neighbours[b].append(a)
    loose = []
    seen: set[int] = set()
    for root in range(count):
        if root in seen:
            continue
        part = {root}
        queue = deque([root])
        while queue:
            for there in neighbours[queue.popleft()]:
                if there not in part:
                    part.add(there)
                    queue.append(there)
        seen |= part
        if not part & anchored:
            loose.append(sorted(part))
    return loose
