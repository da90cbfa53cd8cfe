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
    """Plant with the parameters of one variant of a scenario."""

    @property
    def name(self) -> str:
        """Return the name of the variant; empty for the nominal plant."""

    @property
    def values(self) -> Mapping[str, float]:
        """Return the parameter values [SI] that differ from the nominal plant, by name."""

    @property
    def topic(self) -> str:
        """Return the topic of the stream that logs the simulation of this variant."""


V = TypeVar("V", bound=PlantVariant)


class VariedParameter(NamedTuple):
    """Range and nominal value of a plant's parameter in SI; low == high if there is no range.

    - label: name of the parameter in messages
    - least: lower limit, as (name of another parameter, factor), or None. The limit is the factor
      times the value of the other parameter. The lower limit of a breakaway friction is the Coulomb
      friction
    - ratio: range of the parameter divided by its lower limit, or None

    A random value is drawn from the part of the range above the lower limit. If `ratio` is present,
    this ratio is drawn instead; low and high are then the smallest and the largest possible values.
    A parameter with a lower limit but without a range keeps its ratio to the lower limit.
    """

    low: float
    high: float
    nominal: float
    unit: str
    label: str
    least: tuple[str, float] | None = None
    ratio: tuple[float, float] | None = None


class VariantRun(NamedTuple):
    """Result of the simulation of one variant.

    `record` (n, 7): signals of the controlled axis, with the columns of engine/closed_loop.py.
    `streams`, `metadata`: other streams and metadata records of the log.
    """

    record: Vector
    streams: tuple[Stream, ...] = ()
    warnings: tuple[str, ...] = ()
    metadata: Mapping[str, dict[str, str]] = {}


class SimulatedLoop(NamedTuple):
    """Controller, reference and conditions, which are the same for all variants of the plant.

    - program: controller as a program of nodes
    - running: `program` in the number format of the simulation
    - code: machine code of `running`; None if its number format has no machine code
    - target: compiled C code that is used instead of `program`, or None
    - start, reference: initial position and reference (n,) [rad | m]
    - conditions: disturbances, drifts and sensor faults (n, 8)
      (engine/disturbances_and_faults.py)
    - scheduled: one mapping for each variant, from the node index of a scheduled parameter in
      `program` to its value
    - progress: function that receives the completed and the total number of variants, or of samples
      if a mechanism has a single variant
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
    """Interface of a simulated plant, which is a single axis or a mechanism."""

    @property
    def name(self) -> str:
        """Return the name of the plant's document."""

    @property
    def rig(self) -> Rig:
        """Return drive, encoder, timing and travel."""

    @property
    def width(self) -> float:
        """Return the amount of data that the plant logs per sample, relative to a single axis."""

    def check(
        self, controller: Controller | None, scenario: Scenario, names: DocumentNames
    ) -> None:
        """Raise DocumentError if the scenario uses a feature that this plant does not support."""

    def count(self, controller: Controller, scenario: Scenario) -> int:
        """Return the number of variants, including the nominal plant."""

    def variants(self, controller: Controller, scenario: Scenario, owner: str) -> list[V]:
        """Return the plants of a scenario: the nominal plant, then the other variants.

        For `variants: given`, the result is only the plant with the values under `given`. `owner`
        is the name of the document in messages. Raises FrictoolError if a plant's parameters are
        out of range, or if plants must be drawn but no parameter has a range.
        """

    def ranges(self) -> Mapping[str, VariedParameter]:
        """Return the parameters that the key `given` of a scenario can set, by name."""

    def known(self, variant: V) -> Mapping[str, float]:
        """Return the values [SI] of the parameters by which a controller can schedule gains."""

    def play(self, variants: Sequence[V], loop: SimulatedLoop) -> Iterator[tuple[V, VariantRun]]:
        """Simulate each variant; yield the variant and its result.

        Raises NoSolutionError if a variant cannot be simulated.
        """

    def linear(self, variant: V, conditions: Vector) -> LoggedPlant | None:
        """Return a variant's linear plant for stability margins; None for a mechanism."""

    def intervals(self, scenario: Scenario) -> Mapping[str, tuple[float, float]]:
        """Return the parameter intervals [SI] for which a controller must be verified.

        The intervals of friction apply to the scenario's temperature. For a mechanism, only the
        interval of the drive's constant is known.
        """

    def described(self, variant: V) -> str:
        """Return the parameter values of a variant with their units as text, for the log."""
