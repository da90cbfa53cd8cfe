"""Log files of synthetic clutches, for tests of commands that read logs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from frictool.documents.model import Model
from frictool.documents.writing import to_yaml
from frictool.logs.canonical.mcap_format import write_mcap
from frictool.logs.canonical.mcap_layout import StreamHeader
from frictool.logs.canonical.mcap_writer import CanonicalWriter, write_streams
from frictool.logs.canonical.sample_chunks import chunked
from frictool.logs.log import Log, Stream
from frictool.logs.stream_source import SampleBlock
from studies.rigs.clutch_fleet import NOISE, Unit, believed, run, steps

UNITS = {"position": "rad", "current": "A", "effort": "N m", "velocity": "rad/s"}
CONSTANT = 13.4e-3  # N m/A
MINUTE = 60_000  # samples
PLACES = (30.0, 0.0, 50.0, 20.0)  # rad, successive targets


def model_file(folder: Path, model: Model | None = None) -> Path:
    """Write a model, by default `believed()`, and return its path."""
    path = folder / "model.yaml"
    path.write_text(to_yaml(model or believed()), encoding="utf-8")
    return path


def log_of(
    unit: Unit, seed: int, seconds: float = 8.0, noise: float = NOISE, **metadata: dict[str, str]
) -> Log:
    """Return the log of a clutch along `seconds` of steps, with the simulation's true velocity."""
    played = run(unit, steps(seconds), seed, noise=noise)
    piece = played.pieces[0]
    signals = {
        "position": piece.position,
        "current": piece.effort / CONSTANT,
        "effort": piece.effort,
        "velocity": played.velocity,
    }
    return Log(
        (Stream("/axis", piece.time, signals, UNITS),), {"log": {"kind": "simulated"}, **metadata}
    )


def save(log: Log, path: Path) -> Path:
    """Write a canonical log."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as stream:
        write_mcap(log, stream)
    return path


def cut(path: Path, share: float = 0.6) -> Path:
    """Shorten a file to its first part."""
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    return path


def repeated(log: Log, times: int, pause: float = 1.0) -> Log:
    """Return a log `times` times in succession, with gaps of `pause` seconds."""
    (stream,) = log.streams
    length = float(stream.time[-1]) + pause
    time = np.concatenate([stream.time + k * length for k in range(times)])
    signals = {name: np.tile(values, times) for name, values in stream.signals.items()}
    return Log((Stream(stream.topic, time, signals, stream.units),), log.metadata)


def long_log(path: Path, minutes: int, hold: float, wear: float) -> None:
    """Write a log of a clutch at 1 kHz with position and current, and a move every `hold` s.

    Every minute is equal to the first.
    """
    held = round(1e3 * hold)
    (piece,) = run(Unit(wear=wear), np.repeat(np.resize(PLACES, MINUTE // held), held), 0).pieces
    signals = (piece.position, piece.effort / CONSTANT)

    def pieces() -> Iterator[SampleBlock]:
        for minute in range(minutes):
            yield SampleBlock((minute * MINUTE + np.arange(MINUTE)) * 1_000_000, signals)

    with path.open("wb") as stream:
        head = StreamHeader("/axis", ("position", "current"), (UNITS["position"], UNITS["current"]))
        write_streams(CanonicalWriter(stream, (head,), {}), [chunked(pieces())])
