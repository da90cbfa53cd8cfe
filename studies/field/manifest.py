"""Manifest of the field benchmark: machines, their records, and published values."""

from __future__ import annotations

from pathlib import Path

import msgspec

HERE = Path(__file__).parent
NAME = "manifest.yaml"


class Machine(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Machine of a manifest.

    - bench: file of the bench, in the folder of the manifest or in its folder `benches`
    - records: lists of files or patterns below the data folder; the files of a list are fitted
      together
    - parts: number of equal parts in time into which each record is divided
    - refused: files that an identification must refuse
    - published: parameter -> published value (SI)
    """

    name: str
    bench: str
    source: str
    records: list[list[str]]
    parts: int = 1
    refused: tuple[str, ...] = ()
    published: dict[str, float] = msgspec.field(default_factory=dict)


class Manifest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Machines of the benchmark."""

    machines: list[Machine]


def read_manifest(folder: Path) -> tuple[Manifest, Path]:
    """Return the manifest of the data folder or, without one, of this package, and its folder."""
    home = folder if (folder / NAME).is_file() else HERE
    return msgspec.yaml.decode((home / NAME).read_bytes(), type=Manifest), home


def bench_path(machine: Machine, home: Path) -> Path:
    """Return the path of a machine's bench."""
    beside = home / machine.bench
    return beside if beside.is_file() else home / "benches" / machine.bench


def files_of(patterns: list[str], folder: Path) -> list[Path]:
    """Return the sorted files that match the patterns below a folder."""
    return sorted({path for pattern in patterns for path in folder.glob(pattern)})
