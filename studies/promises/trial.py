"""Trial: the optimal test of a bench is simulated on a random actuator and identified."""

from __future__ import annotations

from dataclasses import dataclass

from frictool.documents.bench import DRIVE_NOISE_SHARE, Bench
from frictool.documents.model import Model
from frictool.identify.excite.excitation_sequence import ExcitationSequence
from frictool.identify.excite.precise_strokes import PreciseTest
from frictool.identify.from_logs import identify
from frictool.identify.identification import Identification, NothingIdentified
from frictool.simulate import play
from frictool.simulate.default_servo import default_servo, feedforward
from studies.promises.rigs import truth


@dataclass(frozen=True)
class TrialRow:
    """Outcome of one parameter in one trial (SI).

    - half_width: half width that `identify` reports; None if it refuses the parameter
    - promised, bound: half widths of the promise and of the Cramér-Rao bound
    - error: estimate minus true value
    - method: method that `auto` chose
    - duration: duration of the test [s]
    """

    rig: str
    seed: int
    parameter: str
    half_width: float | None
    promised: float
    bound: float
    error: float
    held: bool
    method: str
    duration: float


def trial(bench: Bench, test: PreciseTest, seed: int) -> list[TrialRow]:
    """Return a row for each parameter for which the test promises a half-width."""
    model = truth(bench, seed)
    result = identified(bench, model, test.sequence, seed)
    rows = []
    for name, promised in test.half_widths.items():
        found = result.identified.get(name)
        true = getattr(model.parameters, name).value
        rows.append(
            TrialRow(
                bench.name,
                seed,
                name,
                None if found is None else found.half_width,
                promised,
                test.bounds[name],
                float("nan") if found is None else found.value - true,
                found is not None and found.low <= true <= found.high,
                result.method,
                test.sequence.duration,
            )
        )
    return rows


def identified(
    bench: Bench, model: Model, sequence: ExcitationSequence, seed: int
) -> Identification:
    """Simulate a test on an axis, and return the identification of the log."""
    test = sequence.as_log("test")
    log = play(
        model,
        test,
        servo=default_servo(bench),
        drive_noise=DRIVE_NOISE_SHARE * bench.actuator.limit.value,
        seed=seed,
        forward=feedforward(bench, test),
    )
    try:
        return identify([log], bench).result
    except NothingIdentified as error:
        return error.result
