"""Golden vectors: what the simulation's own controller returns on a sequence that visits everything it can do.

The sequence is drawn from a seed while the controller runs, so that it depends on nothing but the controller document. The position
answers as an axis in closed loop would at a glance: it follows the filtered reference with a lag and comes as counts of the encoder.
Phases wait for what they are there for (rest, the drive's limit) within a bound, so that a slow controller does not make them endless.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

from frictool.control.cascade import BRAKE, FILTERED, FILTERED_SPEED, LIMITED, MODE, REST, RUN, SPEED, control_step, initial_state
from frictool.control.packing import pack
from frictool.documents.controller import Controller
from frictool.errors import NoSolutionError

SEED = 1
PHASE, LONGEST = 1500, 20_000  # most samples that one phase waits; longer, up to the second, where the prefilter is slow
SETTLING = 15.0  # time constants of the prefilter
BANDS = 32.0  # amplitude in bands of the position law where the bench states no travel
LAG = 10.0  # samples in which the position follows the filtered reference

Row = tuple[float, float, float]


@dataclass(frozen=True)
class GoldenVectors:
    """Rows of reference, position [rad | m] and drive [A | V], and how many samples were spent in each mode and at the limit."""

    rows: tuple[Row, ...]
    run: int
    brake: int
    rest: int
    limited: int
    seed: int = SEED

    @property
    def samples(self) -> int:
        return len(self.rows)


class _Bench:
    """A controller, a position that follows it, and the rows so far."""

    def __init__(self, controller: Controller) -> None:
        travel = controller.bench.mechanics.travel
        law = controller.position_law
        self.low, self.high = (travel.low, travel.high) if travel else (0.0, BANDS * law.band)
        self.band, self.settled = law.band, 0.1 * law.settled_speed
        self.slow = 0.1 * law.rest_speed if law.action == "brake" else math.inf
        self.step = controller.bench.encoder.resolution
        self.random = random.Random(SEED)
        self.position = self.counted(0.9 * self.low + 0.1 * self.high)
        self.parameters = pack(controller)
        self.state = initial_state(self.parameters, self.position)
        self.patience = _settling_samples(controller)
        self.rows: list[Row] = []
        self.modes: list[tuple[float, float]] = []

    def counted(self, position: float) -> float:
        return math.floor(position / self.step) * self.step

    def at(self, fraction: float) -> float:
        """A position between both ends of the travel."""
        return self.low + fraction * (self.high - self.low)

    def sample(self, reference: float, jitter: int = 0) -> None:
        position = self.counted(self.position) + self.step * self.random.randint(-jitter, jitter)
        drive = control_step(self.parameters, self.state, reference, position)
        self.rows.append((reference, position, drive))
        self.modes.append((float(self.state[MODE]), float(self.state[LIMITED])))

    def follow(self, reference: float) -> None:
        """A move that ends at rest, the prefilter at rest as well: at the peak of its overshoot it only seems to be."""
        for _ in range(self.patience):
            self.sample(reference)
            self.position += (float(self.state[FILTERED]) - self.position) / LAG
            arrived = abs(self.state[FILTERED] - reference) <= 0.1 * self.band
            if self.state[MODE] == REST and arrived and abs(self.state[FILTERED_SPEED]) <= self.settled:
                break

    def shake(self, samples: int) -> None:
        """The axis follows a reference that it never reaches, and the encoder jitters."""
        reference = self.at(self.random.random())
        for _ in range(samples):
            self.sample(reference, jitter=2)
            self.position += (float(self.state[FILTERED]) - self.position) / LAG

    def push(self, bands: float) -> None:
        """The axis is pushed out of the band, held until its measured speed has died down, and falls back faster than the speed of rest."""
        reference, start = self.rows[-1][0], self.position
        self.position = start + bands * self.band
        for held in range(PHASE):
            self.sample(reference)
            if held >= 2 and abs(self.state[SPEED]) <= self.slow:
                break
        self.position = start
        for _ in range(60):
            self.sample(reference)

    def block(self, reference: float) -> None:
        """The axis is stuck until the drive has been at its limit for some samples."""
        limited = 0
        for _ in range(PHASE):
            self.sample(reference)
            limited += self.state[LIMITED] != 0.0
            if limited == 50:
                break


def _settling_samples(controller: Controller) -> int:
    """Samples in which a step's filtered reference settles, within PHASE and LONGEST."""
    if controller.prefilter is None:
        return PHASE
    damping = controller.prefilter.damping
    rate = controller.prefilter.natural_frequency_rad_s * min(damping, 0.5 / damping)  # of the slower pole, or less
    return math.ceil(min(max(SETTLING / (rate * controller.sample_period_s), PHASE), LONGEST))


def golden_vectors(controller: Controller) -> GoldenVectors:
    """The rows for a controller. Raises NoSolutionError where it leaves the range of numbers on them."""
    bench = _Bench(controller)
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
    if not all(math.isfinite(drive) for _, _, drive in bench.rows):
        raise NoSolutionError(
            f"{controller.name}: the drive leaves the range of numbers on the golden vectors; is a - l c of the anti-windup stable?"
        )
    modes = [mode for mode, _ in bench.modes]
    limited = sum(limit != 0.0 for _, limit in bench.modes)
    return GoldenVectors(tuple(bench.rows), modes.count(RUN), modes.count(BRAKE), modes.count(REST), limited)
