"""Export of a model to simulators and drives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from frictool.documents.model import Model
from frictool.export.axis_fmu import axis_fmu
from frictool.export.export_origin import ExportOrigin
from frictool.export.friction_table import table_files
from frictool.export.languages import MODEL_LANGUAGES
from frictool.export.mjcf import mjcf_files
from frictool.export.mjcf_check import MjcfCheck, mjcf_check
from frictool.export.urdf import urdf_files
from frictool.logs.log import Log


@dataclass(frozen=True)
class ModelExportSettings:
    """Options of the export of a model.

    - without: features of the model to leave out (`model_features.py`)
    - into: robot description in which the joint's values are written
    - joint: name of the joint in `into`; None if the file has only one joint of the axis's type
    - check: log whose effort drives the comparison of the exported MJCF file with the model
    """

    without: frozenset[str] = frozenset()
    into: Path | None = None
    joint: str | None = None
    check: Log | None = None


@dataclass(frozen=True)
class ModelExport:
    """Files of an exported model (contents by name), and notes on these files."""

    language: str
    origin: ExportOrigin
    files: Mapping[str, str | bytes]
    notes: tuple[str, ...]
    check: MjcfCheck | None = None

    def summary(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        record: dict[str, Any] = {
            "files": list(self.files),
            "language": self.language,
            "sha256": self.origin.sha256,
            "notes": list(self.notes),
        }
        return record if self.check is None else record | {"check": self.check.as_json()}

    def lines(self) -> list[str]:
        """Return the result as lines of text."""
        checked = self.check.lines() if self.check is not None else []
        return [f"{', '.join(self.files)}: {self.language}", *self.notes, *checked]


def export_model(
    model: Model, language: str, settings: ModelExportSettings, origin: ExportOrigin
) -> ModelExport:
    """Export a model to a simulator or a drive; return the files, and notes on the files.

    - language: name of a language for models (`languages.py`)
    - origin: origin of the model's document

    Raises NoSolutionError if the language cannot represent a feature of the model that is not left
    out. Raises InputFileError if a file of the settings does not fit the model.
    """
    assert language in MODEL_LANGUAGES
    files, notes = WRITERS[language](model, settings, origin)
    check = None
    if settings.check is not None:
        check = mjcf_check(model, str(next(iter(files.values()))), settings.check)
    return ModelExport(language, origin, files, tuple(notes), check)


Files = tuple[Mapping[str, str | bytes], list[str]]
Writer = Callable[[Model, ModelExportSettings, ExportOrigin], Files]


def _urdf(model: Model, settings: ModelExportSettings, _: ExportOrigin) -> Files:
    assert settings.into is not None
    return urdf_files(model, settings.into, settings.joint, settings.without)


WRITERS: dict[str, Writer] = {
    "urdf": _urdf,
    "table": lambda model, settings, origin: table_files(model, origin, settings.without),
    "fmu": lambda model, settings, origin: axis_fmu(model, origin, settings.without),
    "mjcf": lambda model, settings, origin: mjcf_files(model, origin, settings.without),
}
