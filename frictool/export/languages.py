"""Languages of `frictool export`, with one record for each kind of exported document."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

DocumentKind = Literal["controller", "model"]


@dataclass(frozen=True)
class ExportLanguage:
    """One value of `--lang` for one kind of document.

    - name: value of `--lang`
    - document: kind of document that is exported
    - text: description of the written files, for the help
    - options: options of the command that this language reads, besides `--lang` and `--output`
    """

    name: str
    document: DocumentKind
    text: str
    options: tuple[str, ...] = ()


LANGUAGES: tuple[ExportLanguage, ...] = (
    ExportLanguage(
        "c",
        "controller",
        "C99: NAME.h and NAME.c for the target; NAME_vectors.h and NAME_selftest.c to check it",
        ("number", "report"),
    ),
    ExportLanguage(
        "json",
        "controller",
        "NAME.json: every coefficient as the number format stores it, and the sign conventions",
        ("number",),
    ),
    ExportLanguage(
        "cmsis",
        "controller",
        "NAME_cmsis.h: the linear controller as biquads for CMSIS-DSP, in float, q31 or q15",
        ("number",),
    ),
    ExportLanguage(
        "matlab",
        "controller",
        "NAME.mat: a, b, c, d, sos, Ts and the blocks' parameters, for MATLAB and Simulink",
        ("number",),
    ),
    ExportLanguage(
        "fmu",
        "controller",
        "NAME.fmu: FMI 3.0 co-simulation unit with the C code inside, in double or float",
        ("number",),
    ),
    ExportLanguage(
        "fmu",
        "model",
        "NAME.fmu: FMI 3.0 co-simulation unit of the axis with exact stick, backlash and encoder",
        ("without",),
    ),
    ExportLanguage(
        "urdf",
        "model",
        "URDF or SDF of --into with the damping and friction of one joint, as a copy or in place",
        ("into", "joint", "in_place", "without"),
    ),
    ExportLanguage(
        "table",
        "model",
        "NAME_*.csv: friction against speed, with a band, and against position; tables for drives",
        ("without",),
    ),
    ExportLanguage(
        "mjcf",
        "model",
        "NAME.xml for MuJoCo, and NAME_ranges.json with the intervals for domain randomisation",
        ("without", "check"),
    ),
)
LANGUAGE_NAMES = tuple(dict.fromkeys(one.name for one in LANGUAGES))
CONTROLLER_LANGUAGES = tuple(one.name for one in LANGUAGES if one.document == "controller")
MODEL_LANGUAGES = tuple(one.name for one in LANGUAGES if one.document == "model")
