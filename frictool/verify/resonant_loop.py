"""Check of loops with resonant links, at every vertex and for each stored resonance filter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from frictool.adapters.resonance_filter import resonance_filters
from frictool.documents.resonances import Resonances
from frictool.errors import NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import smallest
from frictool.verify.feedback_loops import FeedbackLoop, open_loop
from frictool.verify.hinf_norm import norm, spectral_radius
from frictool.verify.margins import sensitivity


@dataclass(frozen=True)
class ResonantCheck:
    """Worst spectral radius and modulus margin over all loops, vertices and resonance filters.

    `where` names loop and vertex of the worst margin.
    """

    spectral_radius: float
    modulus_margin: float
    where: str


def resonant_check(
    loops: Sequence[FeedbackLoop],
    points: Sequence[PlantPoint],
    lag: float,
    delay_samples: int,
    resonances: Resonances,
) -> ResonantCheck:
    """Return the worst spectral radius and margin of all loops, plants and resonance filters.

    An unstable loop has the margin 0.

    - lag: time constant of the drive [s]
    - delay_samples: computational delay [samples]
    """
    radii, margins, peaks = [], [], []
    for loop in loops:
        for point in points:
            for end, resonance in zip(
                ("", ", resonances low", ", resonances high"),
                resonance_filters(resonances),
                strict=False,
            ):
                closed = sensitivity(open_loop(loop, point.rates, lag, delay_samples, resonance))
                radii.append(spectral_radius(closed.a))
                margins.append(1.0 / norm(closed)[0] if radii[-1] < 1.0 else 0.0)
                peaks.append(f"{loop.name} at vertex {point.name}{end}")
    margin, at = smallest(margins)
    return ResonantCheck(max(radii), margin, peaks[at])


def require_margin(
    check: ResonantCheck, resonances: Resonances, required: float, name: str = ""
) -> None:
    """Raise NoSolutionError if a loop with resonances is unstable or has too small a margin."""
    slowest = min(
        (one.rad_s for one in resonances.poles),
        default=min(resonances.real_poles_rad_s, default=0.0),
    )
    links = ", ".join(resonances.links)
    condition = f"with the resonance of {links} at {slowest:.4g} rad/s, {check.where}"
    before = f"{name}: not verified: " if name else "not verified: "
    if check.spectral_radius >= 1.0:
        raise NoSolutionError(
            f"{before}{condition}: the loop is unstable "
            f"(spectral radius {check.spectral_radius:.6g}); lower weights.bandwidth_rad_s, or "
            f"stiffen {links}"
        )
    if check.modulus_margin < required:
        raise NoSolutionError(
            f"{before}{condition}: the modulus margin is {check.modulus_margin:.4g}, below the "
            f"specified {required:g}; lower weights.bandwidth_rad_s, or stiffen {links}"
        )
