"""Interface of a simulated plant: one axis or a mechanism.

A scenario has one or more variants of the plant. `SimulatedPlant.play` simulates the control loop
with each variant and yields a VariantRun. The implementations are simulate/axis_plant.py and
simulate/mechanism_plant.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol, TypeVar

from frictool.control.compiled_program import CompiledProgram
from frictool.control.machine_code import MachineCode
from frictool.control.program import Program
from frictool.documents.controller import Controller
from frictool.documents.scenario import Scenario
from frictool.logs.log import Stream
from frictool.simulate.compiled_target import CompiledTarget
from frictool.simulate.document_agreement import DocumentNames
from frictool.simulate.rig import Rig
from frictool.typing import Vector
from frictool.verify.logged_plant import LoggedPlant


class PlantVariant(Protocol):
    """Variant of the plant in a scenario."""

    @property
    def name(self) -> str:
        """Return the name of the variant; empty for the nominal plant."""

    @property
    def values(self) -> Mapping[str, float]:
        """Return the values [SI] that differ from the nominal plant, by name."""

    @property
    def topic(self) -> str:
        """Return the topic of the variant's stream."""


V = TypeVar("V", bound=PlantVariant)


class VariedParameter(NamedTuple):
    """Range and nominal value of a plant's parameter in SI; low == high if it is known exactly.

    `label`: name of the parameter in messages. `least`: lower limit of this parameter, as
    (name of another parameter, factor between their units); for a breakaway, the Coulomb friction.
    A parameter with a range is drawn from the part of its range above the limit. A parameter
    without a range keeps its ratio to the limit in the document.
    """

    low: float
    high: float
    nominal: float
    unit: str
    label: str
    least: tuple[str, float] | None = None


class VariantRun(NamedTuple):
    """Result of the run of one variant.

    `record` (n, 7): record of the controlled axis (engine/closed_loop.py). `streams`, `metadata`:
    further data for the log.
    """

    record: Vector
    streams: tuple[Stream, ...] = ()
    warnings: tuple[str, ...] = ()
    metadata: Mapping[str, dict[str, str]] = {}


class SimulatedLoop(NamedTuple):
    """Controller, reference and conditions, common to the runs of all plants.

    `running` is `program` in the number format of the simulation; `code` is its machine code, or
    None for a format without machine code. If `target` is not None, this compiled code runs
    instead. `start` and `reference` (n,) are in rad | m. `conditions` (n, 8) act on the loop
    (engine/disturbances_and_faults.py). `scheduled` has a mapping for each variant: node index of a
    scheduled parameter in `program` -> value. `progress(done, total)` is called before the first
    variants and after each batch.
    """

    controller: Controller
    scenario: Scenario
    program: Program
    running: CompiledProgram
    code: MachineCode | None
    target: CompiledTarget | None
    start: float
    reference: Vector
    conditions: Vector
    scheduled: Sequence[Mapping[int, float]]
    progress: Callable[[int, int], None]


class SimulatedPlant(Protocol[V]):
    """Interface of a simulated single axis or mechanism."""

    @property
    def name(self) -> str:
        """Return the name of the plant's document."""

    @property
    def rig(self) -> Rig:
        """Return drive, encoder, timing and travel."""

    @property
    def width(self) -> float:
        """Return the size of the plant's logged data divided by the size for one axis."""

    def check(
        self, controller: Controller | None, scenario: Scenario, names: DocumentNames
    ) -> None:
        """Raise DocumentError if the scenario uses a feature that this kind of plant lacks."""

    def count(self, controller: Controller, scenario: Scenario) -> int:
        """Return the number of variants, including the nominal plant."""

    def variants(self, controller: Controller, scenario: Scenario, owner: str) -> list[V]:
        """Return the nominal plant and the scenario's variants, or the plant with `given` values.

        `owner` is the name of the document in messages. Raises FrictoolError if a plant's
        parameters are out of range, or if there is no range to draw from.
        """

    def ranges(self) -> Mapping[str, VariedParameter]:
        """Return the parameters allowed under `given` of a scenario, by name."""

    def known(self, variant: V) -> Mapping[str, float]:
        """Return the values [SI] of the parameters that may schedule a controller, by name."""

    def play(self, variants: Sequence[V], loop: SimulatedLoop) -> Iterator[tuple[V, VariantRun]]:
        """Yield each variant and its run; raise NoSolutionError if one cannot be simulated."""

    def linear(self, variant: V, conditions: Vector) -> LoggedPlant | None:
        """Return the linear plant of a variant under conditions (n, 8); None if it has none."""

    def intervals(self, scenario: Scenario) -> Mapping[str, tuple[float, float]]:
        """Return the intervals [SI] of the parameters for which a controller must be verified.

        Friction has its value at the scenario's temperature. For a mechanism, only the interval of
        the drive's constant is known.
        """

    def described(self, variant: V) -> str:
        """Return the values of a variant with their units, for the log."""
