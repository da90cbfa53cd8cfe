"""`frictool simulate --as-bench`: simulation of a test on the rig, with typical gains and noise."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from frictool.cli.console_output import note_temperature
from frictool.cli.output_files import command_line
from frictool.cli.simulate_mechanism import is_mechanism

if TYPE_CHECKING:
    from frictool.logs.log import Log


def as_bench_log(
    model: Path, test: Path, noise: float | None, seed: int | None, output: Path
) -> Log:
    """Simulate the test in the file `test` with the rig that `model` describes; return the log.

    Raises UsageError for a mechanism, because default gains exist for an axis only.
    """
    if is_mechanism(model):
        raise click.UsageError(
            "--as-bench needs a model of an axis; a mechanism needs --excitation."
        )
    from frictool.documents.bench import DRIVE_NOISE_SHARE
    from frictool.documents.model import Model
    from frictool.documents.provenance import provenance_of_command
    from frictool.documents.registry import load
    from frictool.simulate.as_bench import read_test
    from frictool.simulate.bench_experiment import bench_test
    from frictool.simulate.default_servo import default_servo, feedforward

    plant = load(model, Model)
    note_temperature(model, plant)
    bench = plant.bench
    excitation = read_test(test, bench)
    deviation = DRIVE_NOISE_SHARE * bench.actuator.limit.value if noise is None else noise
    words = {"--as-bench": True, "model": model, "test": test, "--drive-noise": noise}
    return bench_test(
        plant,
        excitation,
        default_servo(bench),
        deviation,
        seed or 0,
        provenance_of_command(
            command_line("simulate", words | {"--seed": seed, "-o": output}), [model, test]
        ),
        feedforward(bench, excitation),
    )
