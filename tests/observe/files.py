"""Logs of made-up clutches as files, for tests of the commands that read them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.log import Log, Stream
from tests.observe.fleet import Unit, believed, run, steps

UNITS = {"position": "rad", "current": "A", "effort": "N m", "velocity": "rad/s"}
CONSTANT = 13.4e-3  # N m/A


def model_file(folder: Path) -> Path:
    """The model that the clutches are believed to have."""
    path = folder / "model.yaml"
    path.write_text(to_yaml(believed()), encoding="utf-8")
    return path


def log_of(unit: Unit, seed: int, seconds: float = 8.0, **metadata: dict[str, str]) -> Log:
    """What a clutch would have logged of `seconds` of steps, with what only a simulation knows."""
    played = run(unit, steps(seconds), seed)
    piece = played.pieces[0]
    signals = {"position": piece.position, "current": piece.effort / CONSTANT, "effort": piece.effort, "velocity": played.velocity}
    return Log((Stream("/axis", piece.time, signals, UNITS),), {"log": {"kind": "simulated"}, **metadata})


def save(log: Log, path: Path) -> Path:
    """Writes a canonical log."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as stream:
        write_mcap(log, stream)
    return path


def cut(path: Path, share: float = 0.6) -> Path:
    """Leaves the first part of a file."""
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    return path


def repeated(log: Log, times: int, pause: float = 1.0) -> Log:
    """The same again and again, with a gap of `pause` seconds in between."""
    (stream,) = log.streams
    length = float(stream.time[-1]) + pause
    time = np.concatenate([stream.time + k * length for k in range(times)])
    signals = {name: np.tile(values, times) for name, values in stream.signals.items()}
    return Log((Stream(stream.topic, time, signals, stream.units),), log.metadata)
