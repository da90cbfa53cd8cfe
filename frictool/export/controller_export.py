"""Export of a controller to a language, after verification with rounded coefficients."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from frictool.adapters.controller_composition import controller_program
from frictool.control.fixed_point import FixedPointOverflow
from frictool.documents.bench import Target
from frictool.documents.controller import Controller, Number
from frictool.documents.quantity import si_unit
from frictool.documents.writing import to_yaml
from frictool.errors import FrictoolError, NoSolutionError
from frictool.export.c99 import c_sources
from frictool.export.c_identifier import c_identifier
from frictool.export.cmsis import cmsis_arrays, cmsis_header
from frictool.export.coefficients import json_files, matlab_files
from frictool.export.controller_fmu import controller_fmu
from frictool.export.encoder_reading import reading_notes
from frictool.export.encoder_wrap import encoder_wrap
from frictool.export.export_origin import ExportOrigin
from frictool.export.golden_vectors import GoldenVectors, golden_vectors
from frictool.export.languages import CONTROLLER_LANGUAGES
from frictool.export.mode_coverage import visit_conditions
from frictool.export.rounded_loop import RoundedLoop, rounded_loop
from frictool.export.target_figures import TargetFigures, target_figures
from frictool.runtime.object_view import ResultView
from frictool.verify.recheck import recheck

Language = Literal["c", "json", "cmsis", "matlab", "fmu"]
COEFFICIENTS_ONLY = (
    "coefficients only: the operations, the limit of the drive and the guard of the inputs "
    "are in --lang c"
)


@dataclass(frozen=True, eq=False, repr=False)
class ExportResult(ResultView):
    """Files of an export with the verified properties.

    - `files`: contents of the files, by name
    - `vectors`: golden vectors; None if the language has none
    - `more`: additional lines for the text output
    - `warning`: warning about the wraps of the encoder; empty if there is none
    - `target`: code size and instruction count on the processor that the key `target` of bench.yaml
      names; None if the bench has no such key and no figures were requested
    """

    controller: Controller
    language: Language
    number: Number
    origin: ExportOrigin
    files: Mapping[str, str | bytes]
    loop: RoundedLoop
    vectors: GoldenVectors | None = None
    more: tuple[str, ...] = ()
    warning: str = ""
    target: TargetFigures | None = None

    def summary(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        loop, vectors = self.loop, self.vectors
        record: dict[str, Any] = {
            "files": list(self.files),
            "language": self.language,
            "number": self.number,
            "order": self.controller.linear.order,
            "sample_period_s": self.controller.sample_period_s,
            "sha256": self.origin.sha256,
            "rounded": {
                "modulus_margin": loop.modulus_margin,
                "at": loop.at,
                "norm": loop.norm,
                "norm_at": loop.norm_at or None,
            },
        }
        if vectors is not None:
            record["vectors"] = {"samples": vectors.samples, **vectors.visits}
            record["away_from_double"] = {
                "drive": vectors.away,
                "drive_rms": vectors.rms,
                "samples_in_another_mode": vectors.apart,
            }
        if self.target is not None:
            record["target"] = self.target.summary()
        return record

    @property
    def is_budget_unchecked(self) -> bool:
        """Return True if the controller's bench limits a figure that was not measured."""
        budget = self.controller.bench.target
        return self.target is not None and budget is not None and self.target.is_unchecked(budget)

    def lines(self) -> list[str]:
        """Return the result as lines of text."""
        norm = (
            "" if self.loop.norm is None else f", norm {self.loop.norm:.4g} at {self.loop.norm_at}"
        )
        return [
            f"{', '.join(self.files)}: {self.language}, {self.number}",
            f"verified with coefficients rounded to {self.number}: modulus margin "
            f"{self.loop.modulus_margin:.4f} at {self.loop.at}{norm}",
            *self.more,
            *([self.target.line()] if self.target is not None else []),
        ]


def default_number(language: Language) -> Number:
    """Return the default number format; CMSIS-DSP has no biquads in double."""
    return "float" if language == "cmsis" else "double"


def export(
    controller: Controller,
    language: Language = "c",
    number: Number | None = None,
    origin: ExportOrigin | None = None,
    report: bool = False,
) -> ExportResult:
    """Export a controller as code or coefficients.

    Parameters
    ----------
    controller : Controller
        The controller, which is verified again with rounded coefficients.
    language : {"c", "json", "cmsis", "matlab", "fmu"}
        Language of the files.
    number : {"double", "float", "q31", "q15"}, optional
        Number format; by default double, or float for cmsis.
    origin : ExportOrigin, optional
        Origin of the document; by default the digest of its YAML text.
    report : bool, optional
        True to measure C code even if the controller's bench has no `target`; the core is then the
        default of `Target`.

    Returns
    -------
    ExportResult
        `files` maps each file name to its content.

    Raises
    ------
    FrictoolError
        If the language or the number format does not exist.
    NoSolutionError
        If the loop with rounded coefficients cannot be verified, if the format cannot represent the
        controller, or if the C code exceeds a limit of `target` in the controller's bench.
    """
    for what, choice, allowed in (
        ("language", language, CONTROLLER_LANGUAGES),
        ("number", number, (*get_args(Number), None)),
    ):
        if choice not in allowed:
            raise FrictoolError(
                f"{what}: found {choice!r}; allowed: {', '.join(one for one in allowed if one)}"
            )
    known_origin = origin or ExportOrigin(
        hashlib.sha256(to_yaml(controller).encode()).hexdigest(),
        "frictool.export.export() in Python",
    )
    return export_controller(
        controller, language, number or default_number(language), known_origin, report
    )


def export_controller(
    controller: Controller,
    language: Language,
    number: Number,
    origin: ExportOrigin,
    report: bool = False,
) -> ExportResult:
    """Export a controller; `origin` and the other parameters are as in `export`.

    Raises the errors of `export`, and NoSolutionError if the document is inconsistent.
    """
    recheck(controller)
    try:
        result = {"c": _c, "json": _json, "cmsis": _cmsis, "matlab": _matlab, "fmu": _fmu}[
            language
        ](controller, number, origin)
    except FixedPointOverflow as error:
        raise NoSolutionError(
            f"{controller.name}: cannot be scaled to {number}: {error}; "
            f"{_remedy(controller, error)}"
        ) from None
    if (wrap := encoder_wrap(controller)) is not None:
        called = c_identifier(controller.name)
        remedy = f"; {called}_unwrap in {called}.h removes the wraps" if language == "c" else ""
        result = replace(
            result, more=(*result.more, wrap.requirement + remedy), warning=wrap.warning
        )
    notes = (f"{subject}: {note}" for subject, note in reading_notes(controller).items())
    result = replace(result, more=(*result.more, *notes))
    has_target = controller.bench.target is not None
    return _measured(result) if language == "c" and (report or has_target) else result


def _measured(result: ExportResult) -> ExportResult:
    controller = result.controller
    target = controller.bench.target or Target()
    kind = "int32_t" if result.number == "q31" else result.number
    figures = target_figures(
        c_identifier(controller.name),
        {name: str(text) for name, text in result.files.items()},
        controller_program(controller),
        kind,
        target,
    )
    if over := figures.over_budget(target):
        raise NoSolutionError(
            f"{controller.name}: the code in {result.number} exceeds the budget of its bench: "
            f"{'; '.join(over)}; try another --number, or a design of a lower order"
        )
    return replace(result, target=figures)


def _remedy(controller: Controller, error: FixedPointOverflow) -> str:
    if "no bounds" not in str(error):
        return "rescale the units, or use --number float"
    if controller.schedule is not None:
        return (
            "the states of a scheduled controller have no proved bound; use --number float, or "
            "remove scheduled from the design"
        )
    return (
        "give travel and top_speed in bench.yaml, which bound the measured values, or use --number "
        "float"
    )


def _c(controller: Controller, number: Number, origin: ExportOrigin) -> ExportResult:
    if number == "q15":
        raise NoSolutionError(
            f"{controller.name}: --lang c has no q15, which would save no instructions against "
            "q31; allowed: double, float, q31"
        )
    loop = rounded_loop(controller, number)
    program = controller_program(controller)
    vectors = golden_vectors(controller, program, number)
    files = c_sources(controller, program, number, vectors, loop, origin)
    visits = visit_conditions(program)
    counted = ", ".join(f"{count} {visits[name].text}" for name, count in vectors.visits.items())
    more = [f"golden vectors: {vectors.samples} samples, {counted}"]
    if number != "double":
        unit = si_unit(controller.drive, controller.axis)
        apart = (
            f"; the mode differs at {vectors.apart} sample{'s' * (vectors.apart > 1)}"
            if vectors.apart
            else ""
        )
        more.append(
            "rounding of the signals: the drive differs from that in double precision by up to "
            f"{vectors.away:.3g} {unit}, {vectors.rms:.3g} rms{apart}"
        )
    return ExportResult(controller, "c", number, origin, files, loop, vectors, tuple(more))


def _fmu(controller: Controller, number: Number, origin: ExportOrigin) -> ExportResult:
    result = _c(controller, number, origin)
    sources = {name: str(text) for name, text in result.files.items()}
    files = controller_fmu(controller, controller_program(controller), number, sources, origin)
    period = (
        f"one sample every {controller.sample_period_s:g} s; the drive is computed from the "
        "inputs at the start of a step"
    )
    return replace(result, language="fmu", files=files, more=(*result.more, period))


def _json(controller: Controller, number: Number, origin: ExportOrigin) -> ExportResult:
    loop = rounded_loop(controller, number)
    return ExportResult(
        controller,
        "json",
        number,
        origin,
        json_files(controller, number, loop, origin),
        loop,
        None,
        (COEFFICIENTS_ONLY,),
    )


def _matlab(controller: Controller, number: Number, origin: ExportOrigin) -> ExportResult:
    loop = rounded_loop(controller, number)
    return ExportResult(
        controller,
        "matlab",
        number,
        origin,
        matlab_files(controller, number, loop, origin),
        loop,
        None,
        (COEFFICIENTS_ONLY,),
    )


def _cmsis(controller: Controller, number: Number, origin: ExportOrigin) -> ExportResult:
    if number == "double":
        raise NoSolutionError(
            f"{controller.name}: CMSIS-DSP's direct form I biquads have no double format; use "
            "--number float, q31 or q15"
        )
    arrays = cmsis_arrays(controller, number)
    loop = rounded_loop(controller, number, arrays.linear)
    files = cmsis_header(controller, number, arrays, loop.modulus_margin, origin)
    more = [
        "linear controller only: the prefilter, the position law, the limits, the "
        "anti-windup and the guard of the inputs are in --lang c"
    ]
    if number != "float":
        unit = si_unit(controller.drive, controller.axis)
        more.append(
            f"rounding of the signals moves the drive by at most {arrays.biquads.noise:.3g} {unit}"
        )
    return ExportResult(controller, "cmsis", number, origin, files, loop, None, tuple(more))
