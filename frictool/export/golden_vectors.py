"""Golden vectors: response of the simulation's controller to inputs that visit all modes.

The sequence is generated from a seed while the controller runs. The sequence depends on the
controller document and the number format only. The position roughly imitates an axis in closed
loop: it follows the filtered reference with a lag, and the encoder quantises it. A phase that waits
for rest, for a released drive or for the drive's limit ends after a bounded number of samples. At
the end, inputs become invalid: several times for the longest time without a fault, then for one
sample longer, which sets the fault.

The program in double precision runs with the same inputs. The difference between its drive and the
drive in the number format shows the effect of rounding.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from frictool.adapters.controller_composition import profile_limits
from frictool.control.compiled_program import (
    FIXED,
    FLOAT,
    CompiledProgram,
    compile_program,
    put,
    read,
)
from frictool.control.fixed_point_kernel import from_real, to_real
from frictool.control.jerk_limited_profile import duration
from frictool.control.number_format import machine_in
from frictool.control.program import Program
from frictool.control.supervision import CommandName, SupervisedProgram
from frictool.documents.controller import Controller, ProgramNumber
from frictool.errors import NoSolutionError
from frictool.export.mode_coverage import visit_conditions

SEED = 1
# largest length of a phase [samples], for a fast and for a slow prefilter
PHASE, LONGEST = 1500, 20_000
SETTLING = 15.0  # settling time of the prefilter, in time constants
BANDS = 32.0  # range of the position [bands of the position law], if the bench has no travel
COUNTS = 8.0  # width [encoder counts] assumed for the band of a controller without a band
LAG = 10.0  # samples, lag of the position behind the filtered reference
FASTER = 3.0  # speed of the return into the band, relative to the rest speed of the position law
DISABLED = 20  # samples between the commands disable and enable; these samples count as no mode
BEYOND = 0.1  # excess of a scheduled parameter beyond its range, relative to the range

Row = tuple[float, ...]


@dataclass(frozen=True)
class GoldenVectors:
    """Rows of inputs and outputs of a controller.

    `columns`: reference, position [rad | m], velocity if used, scheduled parameters, and drive [A |
        V].
    `rows`: values of the columns in SI, as the number format represents them; an invalid input is
        NaN or infinite.
    `visits`: number of samples in each mode and at each limit.
    `away`, `rms`: largest and rms difference between the drive in the number format and the drive
        in double, over the samples at which both programs are in the same mode.
    `apart`: number of samples at which the two programs are in different modes.
    `fault_from`: first row with the fault.
    `restart`: row before which the controller is started again, at the position of this row.
    `commands`: for each command of control/supervision.py, the row before which the command is
        first given. `disable` and `enable` are also given just after `fault`, because they must not
        end the fault.
    """

    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    visits: dict[str, int]
    away: float
    rms: float
    apart: int
    fault_from: int
    restart: int
    commands: Mapping[str, int]
    seed: int = SEED

    @property
    def start(self) -> float:
        """Return the position in the first row, at which the controller starts [rad | m]."""
        return self.rows[0][self.columns.index("position")]

    @property
    def samples(self) -> int:
        """Return the number of samples."""
        return len(self.rows)


class _VectorSequence:
    def __init__(self, controller: Controller, program: Program, number: ProgramNumber) -> None:
        self.program = program
        self.formatted = SupervisedProgram(program, machine_in(program, number))
        self.in_double = SupervisedProgram(program, compile_program(program))
        self.commands: dict[str, int] = {}
        self.hold_samples = controller.measurement_hold_samples
        self.indices = {name: index for index, name in reversed(program.names.items())}
        self.visits = visit_conditions(program)
        self.step = controller.bench.encoder.resolution
        law, limiter = controller.position_law, controller.limiter
        band = law.band if law is not None else limiter.band if limiter is not None else 0.0
        self.band = band or COUNTS * self.step
        travel = controller.bench.mechanics.travel
        self.low, self.high = (travel.low, travel.high) if travel else (0.0, BANDS * self.band)
        self.settled, self.slow = _speeds(controller, self.band)
        rest = law.rest_speed if law is not None else 0.0
        # distance per sample of the return after a push
        self.returning = FASTER * rest * controller.sample_period_s
        self.random = random.Random(SEED)
        self.period = controller.sample_period_s
        self.position = self.counted(0.9 * self.low + 0.1 * self.high)
        self.before = self.position
        self.start()
        self.inputs = [*program.inputs.values(), *program.constant_states]
        self.patience = _settling_samples(controller)
        self.rows: list[Row] = []
        self.counts = dict.fromkeys(self.visits, 0)
        self.differences: list[float] = []
        self.apart = 0

    def start(self) -> None:
        for one in self.both:
            one.start(self.counted(self.position))

    @property
    def both(self) -> tuple[SupervisedProgram, SupervisedProgram]:
        return self.formatted, self.in_double

    @property
    def machine(self) -> CompiledProgram:
        return self.formatted.machine

    def command(self, name: CommandName) -> None:
        position = self.counted(self.position)
        for one in self.both:
            one.command(name, position)
        self.commands.setdefault(name, len(self.rows))

    def counted(self, position: float) -> float:
        return math.floor(position / self.step) * self.step

    def at(self, fraction: float) -> float:
        return self.low + fraction * (self.high - self.low)

    def now(self, name: str, otherwise: float) -> float:
        return read(self.machine, self.indices[name]) if name in self.indices else otherwise

    def sample(
        self, reference: float, jitter: int = 0, lost: Mapping[str, float] | None = None
    ) -> None:
        position = self.counted(self.position) + self.step * self.random.randint(-jitter, jitter)
        velocity = (position - self.before) / self.period
        self.before = position
        inputs = {"reference": reference, "position": position, "velocity": velocity} | dict(
            lost or {}
        )
        output = self.program.output
        assert output is not None
        given = inputs["reference"], inputs["position"], inputs["velocity"]
        drive = self.formatted.step(*given)
        readings = [read(self.machine, node.index) for node in self.inputs]
        readings[list(self.program.inputs).index("reference")] = self.in_format(given[0])
        self.rows.append((*readings, drive))
        values = dict(zip(self.program.inputs, readings, strict=False))
        other = self.in_double.step(
            values["reference"], values["position"], values.get("velocity", 0.0)
        )
        if self.formatted.disabled:
            return
        seen = [
            {name for name, visit in self.visits.items() if visit.made(one.machine)}
            for one in self.both
        ]
        for name in seen[0]:
            self.counts[name] += 1
        if seen[0] == seen[1]:
            self.differences.append(abs(drive - other))
        else:
            self.apart += 1

    def in_format(self, reference: float) -> float:
        if self.machine.number == FIXED:
            form = self.machine.formats[self.machine.ports[0]]
            return float(to_real(form, from_real(form, reference)))
        return float(np.float32(reference)) if self.machine.number == FLOAT else reference

    def schedule(self) -> None:
        """Set the scheduled parameters to random values, some beyond their range."""
        for node in self.program.constant_states:
            width = node.high - node.low
            value = self.random.uniform(node.low - BEYOND * width, node.high + BEYOND * width)
            for one in self.both:
                put(one.machine, node.index, value)

    def moved(self, reference: float) -> None:
        self.position += (self.now("filtered", reference) - self.position) / LAG

    def follow(self, reference: float) -> None:
        """Move to a reference until axis and prefilter are at rest."""
        self.schedule()
        rests = [visit for name, visit in self.visits.items() if name in ("rest", "released")]
        for _ in range(self.patience):
            self.sample(reference)
            self.moved(reference)
            arrived = abs(self.now("filtered", reference) - reference) <= 0.1 * self.band
            still = (
                abs(self.now("filtered_speed", 0.0)) <= self.settled
                and abs(self.position - reference) <= self.band
            )
            if arrived and still and all(visit.made(self.machine) for visit in rests):
                break

    def shake(self, samples: int) -> None:
        """Follow a reference that is never reached, while the measured position jitters."""
        self.schedule()
        reference = self.at(self.random.random())
        for _ in range(samples):
            self.sample(reference, jitter=2)
            self.moved(reference)

    def push(self, bands: float) -> None:
        """Push the axis out of the band in which the controller sets the drive to 0, and back.

        `bands`: distance of the push, relative to the band's half-width. The return begins when the
        measured speed has decayed. The return speed is higher than the rest speed of the position
        law.
        """
        reference = self.rows[-1][0]
        start = self.position
        self.position = start + bands * self.band
        for count in range(PHASE):
            self.sample(reference)
            if count >= 2 and abs(self.now("speed", 0.0)) <= self.slow:
                break
        away = self.position - start
        steps = math.ceil(abs(away) / self.returning) if self.returning > 0.0 else 1
        for step in range(min(steps, PHASE)):
            self.position = start + away * (1.0 - (step + 1) / min(steps, PHASE))
            self.sample(reference)
        for _ in range(60):
            self.sample(reference)

    def block(self, reference: float) -> None:
        """Keep the axis still until the drive has been limited at 50 samples, or PHASE samples."""
        limited = 0
        for _ in range(PHASE):
            self.sample(reference)
            limited += self.visits["limited"].made(self.machine)
            if limited == 50:
                break

    def lose(self, reference: float, samples: int) -> None:
        """Run samples with one invalid input each; the kinds of invalid inputs rotate."""
        kinds: list[dict[str, float]] = [
            {"position": math.nan},
            {"position": math.inf},
            {"reference": math.nan},
            {"velocity": -math.inf},
        ]
        losses = [kind for kind in kinds if kind.keys() <= self.program.inputs.keys()]
        for index in range(samples):
            self.sample(reference, lost=losses[index % len(losses)])
            self.moved(reference)

    def move(self, reference: float, samples: int) -> None:
        for _ in range(samples):
            self.sample(reference)
            self.moved(reference)


def _speeds(controller: Controller, band: float) -> tuple[float, float]:
    law, limiter = controller.position_law, controller.limiter
    stated = (
        law.settled_speed
        if law is not None
        else limiter.settled_speed
        if limiter is not None
        else None
    )
    slow = 0.1 * law.rest_speed if law is not None and law.action == "brake" else math.inf
    return 0.1 * stated if stated is not None else band, slow


def _settling_samples(controller: Controller) -> int:
    if controller.profile is not None:
        travel = controller.bench.mechanics.travel
        distance = 0.0 if travel is None else travel.high - travel.low
        period = controller.sample_period_s
        least = duration(distance, profile_limits(controller.profile), period)
        return math.ceil(min(max(2.0 * least / period, PHASE), LONGEST))
    if controller.prefilter is None:
        return PHASE
    damping = controller.prefilter.damping
    # at most the rate of the slower pole
    rate = controller.prefilter.natural_frequency_rad_s * min(damping, 0.5 / damping)
    return math.ceil(min(max(SETTLING / (rate * controller.sample_period_s), PHASE), LONGEST))


def _losses(bench: _VectorSequence) -> tuple[int, int]:
    for fraction in (0.6, 0.3, 0.8):
        bench.move(bench.at(fraction), 30)
        bench.lose(bench.at(fraction), bench.hold_samples)
    bench.move(bench.at(0.8), 30)
    bench.lose(bench.at(0.8), bench.hold_samples + 1)
    fault_from = len(bench.rows) - 1
    bench.move(bench.at(0.2), 30)
    restart = len(bench.rows)
    bench.start()
    bench.follow(bench.at(0.4))
    return fault_from, restart


def _commands(bench: _VectorSequence) -> None:
    """Give each command of a supervisor once, while the axis moves.

    While the command `hold` acts, the reference changes and becomes invalid.
    """
    bench.move(bench.at(0.7), 40)
    bench.command("hold")
    bench.move(bench.at(0.2), 40)
    for _ in range(bench.hold_samples + 2):
        bench.sample(bench.at(0.2), lost={"reference": math.nan})
    bench.command("follow")
    bench.move(bench.at(0.2), 40)
    bench.command("disable")
    bench.move(bench.at(0.8), DISABLED)
    bench.command("enable")
    bench.move(bench.at(0.8), 40)
    bench.command("fault")
    for name in ("disable", "enable"):
        bench.command(name)
    bench.move(bench.at(0.8), 20)
    bench.command("reset")
    bench.follow(bench.at(0.3))


def golden_vectors(
    controller: Controller, program: Program, number: ProgramNumber
) -> GoldenVectors:
    """Return the golden vectors of a controller's program in a number format.

    Raises NoSolutionError if the drive overflows, and FixedPointOverflow if the program cannot be
    scaled to fixed point.
    """
    bench = _VectorSequence(controller, program, number)
    for _ in range(5):
        bench.sample(bench.position)
    for fraction, push in ((0.9, 3.0), (0.2, -3.0)):
        bench.follow(bench.at(fraction))
        bench.push(push)
    for fraction in (0.8, 0.1):
        bench.block(bench.at(fraction))
        bench.follow(bench.at(fraction))
    for _ in range(10):
        bench.shake(60)
    bench.follow(bench.at(0.5))
    fault_from, restart = _losses(bench)
    _commands(bench)
    if not all(math.isfinite(row[-1]) for row in bench.rows):
        raise NoSolutionError(
            f"{controller.name}: the drive overflows on the golden vectors; check that the "
            "matrix a - l c of the anti-windup is stable"
        )
    away = max(bench.differences, default=0.0)
    rms = math.sqrt(
        math.fsum(one * one for one in bench.differences) / max(len(bench.differences), 1)
    )
    columns = (
        *program.inputs,
        *(program.names[node.index] for node in program.constant_states),
        controller.drive,
    )
    return GoldenVectors(
        columns,
        tuple(bench.rows),
        bench.counts,
        away,
        rms,
        bench.apart,
        fault_from,
        restart,
        bench.commands,
    )
