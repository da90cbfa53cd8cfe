"""Writer of streams as NumPy arrays, which `np.load(file)["position"]` returns.

If a log has several streams, the name of an array begins with the name of the stream, for example
`axis_force.position`. Units and metadata records are stored as arrays of text.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from typing import BinaryIO

import numpy as np
from numpy.lib import format as npy

from frictool.logs.canonical.mcap_writer import Notes
from frictool.logs.conversion import OutgoingStream, flat_names

UNITS, NOTES = "units", "notes"  # arrays: names and units (n, 2); metadata records as JSON
START = (1980, 1, 1, 0, 0, 0)  # date of every member, the earliest that a zip archive can state


def write(streams: Sequence[OutgoingStream], notes: Notes, target: BinaryIO) -> None:
    """Write all streams, one after the other, then the units and the metadata records `notes`."""
    units = []
    with zipfile.ZipFile(target, "w") as archive:
        for stream, key in zip(streams, flat_names(streams), strict=True):
            prefix = f"{key}." if len(streams) > 1 else ""
            for name, unit, column in zip(stream.names, stream.units, stream.whole(), strict=True):
                units.append((prefix + name, unit))
                _put(archive, prefix + name, column)
        _put(archive, UNITS, np.array(units))
        _put(archive, NOTES, np.array(json.dumps(notes, ensure_ascii=False)))


def _put(
    archive: zipfile.ZipFile, name: str, array: np.ndarray[tuple[int, ...], np.dtype[np.generic]]
) -> None:
    with archive.open(zipfile.ZipInfo(f"{name}.npy", START), "w", force_zip64=True) as member:
        npy.write_array(member, array, version=(1, 0), allow_pickle=False)
