"""What a scenario is played to: one axis (simulate/axis_plant.py) or a mechanism
(simulate/mechanism_plant.py), behind one face.

scenario ──▶ variants ──▶ play: the loop of each ──▶ Run: record of the axis, further streams,
warnings ──▶ log
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from frictool.control.compiled_program import CompiledProgram
from frictool.documents.controller import Controller
from frictool.documents.scenario import Scenario
from frictool.logs.log import Stream
from frictool.simulate.compiled_target import CompiledTarget
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.rig import Rig
from frictool.verify.logged_plant import LoggedPlant

Vector = NDArray[np.float64]


class PlantVariant(Protocol):
    """One plant of a scenario. name: empty for the nominal one. values: what makes it differ from
    that one. topic: of its stream."""

    @property
    def name(self) -> str: ...

    @property
    def values(self) -> Mapping[str, float]: ...

    @property
    def topic(self) -> str: ...


V = TypeVar("V", bound=PlantVariant)


class VariedParameter(NamedTuple):
    """Where a parameter of a plant lies, and where it is in the document, SI; low == high: it is
    known. label: what people call it.

    least: (the parameter that it may not fall below, the factor between their units), as a
    breakaway has its Coulomb friction. Where it varies it is drawn from what lies above; where it
    has no range it goes with the other, in the document's proportion.
    """

    low: float
    high: float
    nominal: float
    unit: str
    label: str
    least: tuple[str, float] | None = None


class VariantRun(NamedTuple):
    """record (n, 7): engine/closed_loop.py, of the controlled axis. streams: what else is known of
    the plant. metadata: further records."""

    record: Vector
    streams: tuple[Stream, ...] = ()
    warnings: tuple[str, ...] = ()
    metadata: Mapping[str, dict[str, str]] = {}


class SimulatedLoop(NamedTuple):
    """What is played to every plant: the controller, in the simulation's number format or as
    compiled code, and what happens to it.

    start [rad | m]; reference (n,); conditions (n, 8) as the loop feels them: engine/conditions.py.
    told: what a scheduled controller is told of each variant, by the machine's places.
    progress(done, total) is told before the first variants and after each batch of them.
    """

    controller: Controller
    scenario: Scenario
    running: CompiledProgram
    target: CompiledTarget | None
    start: float
    reference: Vector
    conditions: Vector
    told: Sequence[Mapping[int, float]]
    progress: Callable[[int, int], None]


class SimulatedPlant(Protocol[V]):
    """One axis or a mechanism, with what a log says of it."""

    @property
    def name(self) -> str: ...

    @property
    def rig(self) -> Rig: ...

    @property
    def width(self) -> float:
        """How many times as much as of one axis is logged of it."""

    def check(
        self, controller: Controller | None, scenario: Scenario, names: DocumentNames
    ) -> None:
        """Raises DocumentError where the scenario asks for what this kind of plant does not
        have."""

    def count(self, controller: Controller, scenario: Scenario) -> int:
        """How many variants there are, the nominal one among them."""

    def variants(self, controller: Controller, scenario: Scenario, owner: str) -> list[V]:
        """The nominal plant, then those that the scenario asks for; `owner` is what messages call
        the document.

        Raises FrictoolError where a plant's parameters are out of range, or there is no range to
        draw from.
        """

    def ranges(self) -> Mapping[str, VariedParameter]:
        """Of the parameters that `given` of a scenario may name, by their names."""

    def known(self, variant: V) -> Mapping[str, float]:
        """What a scheduled controller can be told of it, by the parameters' names [SI]."""

    def play(self, variants: Sequence[V], loop: SimulatedLoop) -> Iterator[tuple[V, VariantRun]]:
        """Each variant and its run. Raises NoSolutionError where one cannot be simulated."""

    def linear(self, variant: V, conditions: Vector) -> LoggedPlant | None:
        """Return the linear plant of a variant under conditions (n, 8); None if no margins are
        computed for it."""

    def intervals(self) -> Mapping[str, tuple[float, float]]:
        """Return the known intervals [SI] of the parameters for which a controller is synthesised;
        of a mechanism the drive's constant."""

    def described(self, variant: V) -> str:
        """Its values with their units, for the log."""
