"""Golden vectors: what the simulation's own controller returns on a sequence that visits everything
it can do.

The sequence is drawn from a seed while the controller runs, so that it depends on nothing but the
controller document and the number format. The position answers as an axis in closed loop would at a
glance: it follows the filtered reference with a lag and comes as counts of the encoder. Phases wait
for what they are there for (rest, release, the drive's limit) within a bound, so that a slow
controller does not make them endless. At the end inputs are lost: for as long as they are held, and
once for longer, which sets the fault. The same inputs go to the program in double as well: how far
its drive is away is what the format's rounding costs.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass

from frictool.control.compiled_program import (
    FIXED,
    FLOAT,
    CompiledProgram,
    compile_program,
    control_step,
    copy_program,
    read,
    start_at,
)
from frictool.control.fixed_point_kernel import from_real
from frictool.control.number_format import machine_in
from frictool.control.program import Program
from frictool.documents.controller import Controller, Number
from frictool.errors import NoSolutionError
from frictool.export.mode_coverage import visit_conditions

SEED = 1
PHASE, LONGEST = (
    1500,
    20_000,
)  # most samples that one phase waits; longer, up to the second, where the prefilter is slow
SETTLING = 15.0  # time constants of the prefilter
BANDS = 32.0  # amplitude in bands of the position law where the bench states no travel
COUNTS = 8.0  # of the encoder, where the controller has no band
LAG = 10.0  # samples in which the position follows the filtered reference
FASTER = 3.0  # than the speed of rest, at which the axis falls back into the band
BEYOND = 0.1  # of a scheduled parameter's range, by which it is set outside

Row = tuple[float, ...]


@dataclass(frozen=True)
class GoldenVectors:
    """columns: reference, position [rad | m], perhaps velocity, scheduled parameters, then the
    drive [A | V]; rows of them as the format holds them, in SI. visits: samples in each mode and at
    each limit. away: how far the drive was from the program's in double at most while both were in
    the same mode, and rms; apart: samples in which they were not. An input that is no number is NaN
    or an infinity. fault_from: the row from which on the fault is set; restart: the row before
    which the controller is started anew at its position.
    """

    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    visits: dict[str, int]
    away: float
    rms: float
    apart: int
    fault_from: int
    restart: int
    seed: int = SEED

    @property
    def start(self) -> float:
        """The position at which the controller starts, that of the first row."""
        return self.rows[0][self.columns.index("position")]

    @property
    def samples(self) -> int:
        return len(self.rows)


class _VectorSequence:
    """A controller, a position that follows it, and the rows so far."""

    def __init__(self, controller: Controller, program: Program, number: Number) -> None:
        self.program = program
        self.new = machine_in(program, number), compile_program(program)
        self.hold_samples = controller.measurement_hold_samples
        self.places = {name: index for index, name in reversed(program.names.items())}
        self.visits = visit_conditions(program)
        self.step = controller.bench.encoder.resolution
        law, limiter = controller.position_law, controller.limiter
        own = law.band if law is not None else limiter.band if limiter is not None else 0.0
        self.band = own or COUNTS * self.step
        travel = controller.bench.mechanics.travel
        self.low, self.high = (travel.low, travel.high) if travel else (0.0, BANDS * self.band)
        self.settled, self.slow = _speeds(controller, self.band)
        rest = law.rest_speed if law is not None else 0.0
        self.returning = FASTER * rest * controller.sample_period_s  # way in a sample, after a push
        self.random = random.Random(SEED)
        self.period = controller.sample_period_s
        self.position = self.counted(0.9 * self.low + 0.1 * self.high)
        self.before = self.position
        self.start()
        self.held = [node for node in program.states.values() if node.index not in program.updates]
        self.inputs = [*program.inputs.values(), *self.held]
        self.patience = _settling_samples(controller)
        self.rows: list[Row] = []
        self.counts = dict.fromkeys(self.visits, 0)
        self.differences: list[float] = []
        self.apart = 0

    def start(self) -> None:
        """Start both machines anew, at rest at the position."""
        self.machine, self.double = (copy_program(one) for one in self.new)
        for running in (self.machine, self.double):
            start_at(running, self.counted(self.position))

    def counted(self, position: float) -> float:
        return math.floor(position / self.step) * self.step

    def at(self, fraction: float) -> float:
        """A position between both ends of the travel."""
        return self.low + fraction * (self.high - self.low)

    def now(self, name: str, otherwise: float) -> float:
        """A named value at the last sample."""
        return read(self.machine, self.places[name]) if name in self.places else otherwise

    def sample(
        self, reference: float, jitter: int = 0, lost: Mapping[str, float] | None = None
    ) -> None:
        """Run one sample; `lost`: inputs, by name, in place of which something comes that is no
        number."""
        position = self.counted(self.position) + self.step * self.random.randint(-jitter, jitter)
        velocity = (position - self.before) / self.period
        self.before = position
        inputs = {"reference": reference, "position": position, "velocity": velocity} | dict(
            lost or {}
        )
        output = self.program.output
        assert output is not None
        control_step(self.machine, inputs["reference"], inputs["position"], inputs["velocity"])
        given = [read(self.machine, node.index) for node in self.inputs]
        drive = read(self.machine, output.index)
        self.rows.append((*given, drive))
        asked = dict(zip(self.program.inputs, given, strict=False))
        other = control_step(
            self.double, asked["reference"], asked["position"], asked.get("velocity", 0.0)
        )
        seen = [
            {name for name, visit in self.visits.items() if visit.made(one)}
            for one in (self.machine, self.double)
        ]
        for name in seen[0]:
            self.counts[name] += 1
        if seen[0] == seen[1]:
            self.differences.append(abs(drive - other))
        else:
            self.apart += 1

    def schedule(self) -> None:
        """Other values of the scheduled parameters, some beyond their range."""
        for node in self.held:
            width = node.high - node.low
            value = self.random.uniform(node.low - BEYOND * width, node.high + BEYOND * width)
            for running in (self.machine, self.double):
                put(running, node.index, value)

    def moved(self, reference: float) -> None:
        self.position += (self.now("filtered", reference) - self.position) / LAG

    def follow(self, reference: float) -> None:
        """A move that ends at rest, the prefilter at rest as well: at the peak of its overshoot it
        only seems to be."""
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
        """The axis follows a reference that it never reaches, and the encoder jitters."""
        self.schedule()
        reference = self.at(self.random.random())
        for _ in range(samples):
            self.sample(reference, jitter=2)
            self.moved(reference)

    def push(self, bands: float) -> None:
        """The axis is pushed out of the band, held until its measured speed has died down, and
        falls back faster than the speed of rest."""
        reference, start = self.rows[-1][0], self.position
        self.position = start + bands * self.band
        for held in range(PHASE):
            self.sample(reference)
            if held >= 2 and abs(self.now("speed", 0.0)) <= self.slow:
                break
        away = self.position - start
        steps = math.ceil(abs(away) / self.returning) if self.returning > 0.0 else 1
        for step in range(min(steps, PHASE)):
            self.position = start + away * (1.0 - (step + 1) / min(steps, PHASE))
            self.sample(reference)
        for _ in range(60):
            self.sample(reference)

    def block(self, reference: float) -> None:
        """The axis is stuck until the drive has been at its limit for some samples."""
        limited = 0
        for _ in range(PHASE):
            self.sample(reference)
            limited += self.visits["limited"].made(self.machine)
            if limited == 50:
                break

    def lose(self, reference: float, samples: int) -> None:
        """Lose inputs for so many samples in a row, each time another one, while the axis moves
        on."""
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


def put(running: CompiledProgram, place: int, value: float) -> None:
    """Sets a state of a running program: what the caller holds."""
    if running.number == FIXED:
        running.word[place] = from_real(running.formats[place], value)
    else:
        (running.single if running.number == FLOAT else running.real)[place] = value


def _speeds(controller: Controller, band: float) -> tuple[float, float]:
    """Below which the prefilter counts as settled, and the measured speed as died down."""
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
    """Samples in which a step's filtered reference settles, within PHASE and LONGEST."""
    if controller.prefilter is None:
        return PHASE
    damping = controller.prefilter.damping
    rate = controller.prefilter.natural_frequency_rad_s * min(
        damping, 0.5 / damping
    )  # of the slower pole, or less
    return math.ceil(min(max(SETTLING / (rate * controller.sample_period_s), PHASE), LONGEST))


def _losses(bench: _VectorSequence) -> tuple[int, int]:
    """Lose inputs for as long as they are held, then for one sample more; start anew. Returns the
    rows of fault and restart."""
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


def golden_vectors(controller: Controller, program: Program, number: Number) -> GoldenVectors:
    """The rows for a controller's program in a number format.

    Raises NoSolutionError where it leaves the range of numbers on them, DoesNotFit where fixed
    point cannot be scaled.
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
    if not all(math.isfinite(row[-1]) for row in bench.rows):
        raise NoSolutionError(
            f"{controller.name}: the drive leaves the range of numbers on the golden vectors; is a - l c of the anti-windup stable?"
        )
    away = max(bench.differences, default=0.0)
    rms = math.sqrt(
        math.fsum(one * one for one in bench.differences) / max(len(bench.differences), 1)
    )
    columns = (
        *program.inputs,
        *(program.names[node.index] for node in bench.held),
        controller.drive,
    )
    return GoldenVectors(
        columns, tuple(bench.rows), bench.counts, away, rms, bench.apart, fault_from, restart
    )
