"""A test of `frictool.identify.excite` played to a model as its bench would play it."""

from __future__ import annotations

from frictool.documents.model import Model
from frictool.documents.provenance import Provenance, provenance_of_call
from frictool.engine.servo import PositionServo
from frictool.errors import LogError
from frictool.logs.log import Log
from frictool.simulate.bench_experiment import bench_test, is_ramps

AT_REST = PositionServo(0.0, 0.0, 0.0, 0.0)


def play(
    model: Model,
    test: Log,
    *,
    servo: PositionServo | None = None,
    drive_noise: float = 0.0,
    seed: int = 0,
    provenance: Provenance | None = None,
) -> Log:
    """What the bench would have logged of `test` (`Sequence.as_log`): ramps by their rule, a
    reference under `servo`.

    servo: the bench's own position loop, from position to effort, which a reference needs.
    drive_noise: standard deviation of the measured drive [A | V]. Raises LogError where the test is
    not of this bench, NoSolutionError where it cannot be simulated.
    """
    if servo is None and not is_ramps(test):
        raise LogError(
            test.source,
            "is a reference, which no drive follows by itself; give the servo that runs on the bench",
        )
    origin = provenance or provenance_of_call("frictool.simulate.play", model=model)
    return bench_test(model, test, servo or AT_REST, drive_noise, seed, origin)
