"""What `frictool export` writes and tells: the files of a language, from a controller that was verified again in the number format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from frictool.control.composition import controller_program
from frictool.control.fixed_point import DoesNotFit
from frictool.documents.controller import Controller, Number
from frictool.documents.quantity import si_unit
from frictool.errors import NoSolutionError
from frictool.export.c99 import c_sources
from frictool.export.origin import Origin
from frictool.export.rounded_loop import RoundedLoop, rounded_loop
from frictool.export.vectors import GoldenVectors, golden_vectors
from frictool.export.visits import visits_of
from frictool.verify.controller import recheck


@dataclass(frozen=True)
class Exported:
    """files: name -> text. vectors: None where the language has none."""

    controller: Controller
    language: str
    number: Number
    origin: Origin
    files: dict[str, str]
    loop: RoundedLoop
    vectors: GoldenVectors | None
    visited: dict[str, str]

    def summary(self) -> dict[str, Any]:
        """The machine's view."""
        loop, vectors = self.loop, self.vectors
        found: dict[str, Any] = {
            "files": list(self.files),
            "language": self.language,
            "number": self.number,
            "order": len(self.controller.linear.discrete.a),
            "sample_period_s": self.controller.sample_period_s,
            "sha256": self.origin.sha256,
            "rounded": {"modulus_margin": loop.modulus_margin, "at": loop.at, "norm": loop.norm, "norm_at": loop.norm_at or None},
        }
        if vectors is not None:
            found["vectors"] = {"samples": vectors.samples, **vectors.visits}
            found["away_from_double"] = {"drive": vectors.away, "drive_rms": vectors.rms, "samples_in_another_mode": vectors.apart}
        return found

    def told(self) -> list[str]:
        """The same for people."""
        loop, vectors = self.loop, self.vectors
        norm = "" if loop.norm is None else f", norm {loop.norm:.4g} at {loop.norm_at}"
        lines = [
            f"{', '.join(self.files)}: {self.language}, {self.number}",
            f"verified with coefficients rounded to {self.number}: modulus margin {loop.modulus_margin:.4f} at {loop.at}{norm}",
        ]
        if vectors is not None:
            counted = ", ".join(f"{count} {self.visited[name]}" for name, count in vectors.visits.items())
            lines.append(f"golden vectors: {vectors.samples} samples, {counted}")
            if self.number != "double":
                unit = si_unit(self.controller.drive, self.controller.axis)
                apart = f"; {vectors.apart} samples are in another mode" if vectors.apart else ""
                lines.append(
                    f"rounding of the signals: the drive is {vectors.away:.3g} {unit} away from double's at most, {vectors.rms:.3g} rms{apart}"
                )
        return lines


def exported(controller: Controller, language: str, number: Number, origin: Origin) -> Exported:
    """Raises NoSolutionError where the document is not what it says, the rounded loop is not verified, or the format cannot hold it."""
    recheck(controller)
    loop = rounded_loop(controller, number)
    program = controller_program(controller)
    try:
        vectors = golden_vectors(controller, program, number)
        files = c_sources(controller, program, number, vectors, loop, origin)
    except DoesNotFit as error:
        bounds = "a travel and a top speed in the bench bound what is measured" if "no bounds" in str(error) else "rescale the units"
        raise NoSolutionError(f"{controller.name}: {number} cannot be scaled: {error}; {bounds}, or use --number float") from None
    visited = {name: visit.text for name, visit in visits_of(program).items()}
    return Exported(controller, language, number, origin, files, loop, vectors, visited)
