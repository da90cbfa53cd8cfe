"""Chain of the steps of a reduction, from the whole mechanism to one inertia.

The result of each step is a mechanism that can be simulated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from frictool.adapters.mechanism.sources_and_sensors import controlled_names
from frictool.documents.mechanism import Mechanism
from frictool.errors import NoSolutionError
from frictool.plant.mechanism.element_error import ElementError
from frictool.reduce.backlash import play_figures
from frictool.reduce.compliance import compliant_links, stiffen_above
from frictool.reduce.coordinate_change import at_sensor, from_reference, from_source, sensor_frame
from frictool.reduce.coordinate_frame import CoordinateFrame
from frictool.reduce.link_losses import as_friction
from frictool.reduce.one_inertia import OneInertia, one_inertia
from frictool.reduce.resistance_step import as_resistance
from frictool.reduce.rigid_lumping import lump_rigid_links
from frictool.reduce.step_report import StepFigure, StepReport

Progress = Callable[[str], None]


@dataclass(frozen=True)
class ReductionStep:
    """Mechanism after a step, and the report of the step."""

    mechanism: Mechanism
    report: StepReport


@dataclass(frozen=True)
class ReductionChain:
    """Chain of the steps of a reduction.

    whole: mechanism before the first step.
    one: one-inertia model of the mechanism after the last step.
    source, sensor: names of the source and the sensor that the controller uses.
    kept: names of the links that are still compliant after the last step.
    play: three widths of each backlash: in the coordinates of its block, of the actuator and of the
    sensor.
    """

    whole: Mechanism
    steps: tuple[ReductionStep, ...]
    one: OneInertia
    source: str
    sensor: str
    kept: tuple[str, ...]
    play: tuple[StepFigure, ...]

    @property
    def last(self) -> Mechanism:
        """Return the mechanism after the last step; it still contains the kept resonances."""
        return self.steps[-1].mechanism


class ReductionStopped(NoSolutionError):
    """Error for an incomplete reduction.

    `steps`: steps that were completed before the error.
    """

    def __init__(self, message: str, steps: tuple[ReductionStep, ...]) -> None:
        super().__init__(message)
        self.steps = steps


def chain(
    whole: Mechanism,
    bandwidth: float | None,
    progress: Progress = lambda _: None,
    number: float | None = None,
) -> ReductionChain:
    """Reduce the mechanism `whole` step by step, without simulation.

    bandwidth: frequency [rad/s] above which resonances are removed; required if a link is
        compliant.
    number: angular wave number of the load's harmonic (residual_load.py); None if unknown.

    Raises ElementError if the mechanism is invalid or its sensor measures no position. Raises
    ReductionStopped, with the completed steps, if the mechanism has several independent motions,
    several commanded sources, a sensor behind backlash, or a load that no model.yaml can describe.
    """
    steps: list[ReductionStep] = []
    try:
        return _chain(whole, bandwidth, progress, steps, number)
    except NoSolutionError as error:
        raise ReductionStopped(str(error), tuple(steps)) from None


def _chain(
    whole: Mechanism,
    bandwidth: float | None,
    progress: Progress,
    steps: list[ReductionStep],
    number: float | None,
) -> ReductionChain:
    source, sensor = controlled_names(whole)
    _one_command(whole, source)
    if whole.sensors[sensor].measures != "position":
        raise ElementError(
            f"sensors.{sensor}.measures",
            f"found {whole.sensors[sensor].measures}; allowed: position, which a model.yaml needs; "
            "name a position sensor in the key `control`",
        )

    def take(result: tuple[Mechanism, StepReport]) -> Mechanism:
        steps.append(ReductionStep(*result))
        return result[0]

    progress("coordinates")
    now = take(from_source(whole, source))
    root = now.sources[source].on
    now = take(lump_rigid_links(now, root))
    root = now.sources[source].on
    if compliant_links(now):
        progress("compliance")
        if bandwidth is None:
            raise NoSolutionError(
                f"{whole.name} has compliant links: "
                f"{', '.join(one.name for one in compliant_links(now))}; "
                "give a bandwidth, which determines the resonances to keep"
            )
        now = take(stiffen_above(now, root, bandwidth))
    progress("losses")
    now, report, reflected = as_friction(now, root, whole)
    steps.append(ReductionStep(now, report))
    progress("curves")
    now = take(as_resistance(now))
    there = sensor_frame(whole, source, sensor)
    if (there.ratio, there.offset) != (1.0, 0.0):
        now = take(at_sensor(now, whole, source, sensor))
    root = now.sources[source].on
    one = one_inertia(
        now,
        source,
        sensor,
        reflected,
        1.0 if there.ratio > 0.0 else -1.0,
        _turns(whole, source, there),
        number,
    )
    if one.play.before_sensor > 0.0:
        unit = "rad" if now.blocks[root].inertia is not None else "m"
        names = ", ".join(one.play.hiding)
        raise NoSolutionError(
            f"sensors.{sensor}: {one.play.before_sensor:.4g} {unit} of backlash ({names}) lie "
            f"between sensor and {source}; allowed: none; move "
            "the sensor, or simulate the mechanism"
        )
    kept = tuple(link.name for link in compliant_links(now))
    play = play_figures(whole, whole.sources[source].on, whole.sensors[sensor].on)
    return ReductionChain(whole, tuple(steps), one, source, sensor, kept, play)


def _turns(whole: Mechanism, source: str, there: CoordinateFrame) -> tuple[float, ...]:
    here = from_reference(whole, source)
    frames = [here.frame(name) for name in here.assembled.blocks]
    return tuple(abs(frame.ratio / there.ratio) for frame in frames if frame.block_axis == "rotary")


def _one_command(whole: Mechanism, source: str) -> None:
    others = [
        name for name, one in whole.sources.items() if name != source and one.drive != "effort"
    ]
    if others:
        raise NoSolutionError(
            f"{whole.name}: {source} and {', '.join(others)} are commanded; a one-inertia model "
            f"has one command; remove every source except {source}, or make its effort constant"
        )
