"""Poles and zeros of the resonances that a reduction keeps.

The transfer function from the effort to the measured position is H(s)/(M s^2), with the mass or
inertia M of the whole mechanism. At frequencies far below the resonances, H is 1. Loads and
friction against the frame are left out, because the one-inertia model contains them.
"""

from __future__ import annotations

import msgspec
import numpy as np
import scipy

from frictool.documents.mechanism import GROUND, Cam, FrictionOf, Mechanism, Spring, Stop
from frictool.documents.resonances import Oscillation, Resonances
from frictool.plant.lti import Lti
from frictool.plant.mechanism.linearisation import linearise
from frictool.reduce.assembly_cache import assemble_cached
from frictool.reduce.compliance import compliant_links

FAR = 1e4  # modulus above which a zero counts as infinite, relative to the fastest pole
HIDDEN = 1e-6  # relative distance below which a pole and a zero cancel


def resonances(mechanism: Mechanism, source: str, sensor: str) -> Resonances | None:
    """Return the resonances from `source` to `sensor`; None if all links are rigid."""
    kept = compliant_links(mechanism)
    if not kept:
        return None
    free = msgspec.structs.replace(
        mechanism, links={name: link for name, link in mechanism.links.items() if _between(link)}
    )
    system = linearise(assemble_cached(free)).transfer(source, sensor)
    poles, zeros = _without_hidden(_poles(system), _zeros(system))
    return Resonances(
        poles=_pairs(poles),
        links=tuple(one.name for one in kept),
        zeros=_pairs(zeros),
        real_poles_rad_s=_reals(poles),
        real_zeros_rad_s=_reals(zeros),
    )


def _between(link: object) -> bool:
    if isinstance(link, Spring):
        return GROUND not in link.between
    return not isinstance(link, Cam | Stop | FrictionOf)


def _poles(system: Lti) -> list[complex]:
    values = sorted(np.linalg.eigvals(system.a), key=abs)
    return [complex(value) for value in values[2:]]


def _zeros(system: Lti) -> list[complex]:
    n = system.order
    fastest = float(np.max(np.abs(np.linalg.eigvals(system.a))))
    count = n // 2
    scale = np.concatenate([np.ones(count), np.full(count, fastest)])  # positions, then speeds
    a = system.a * scale[None, :] / scale[:, None] / fastest
    b = system.b / scale[:, None]
    c = system.c * scale[None, :]
    pencil = np.block(
        [
            [a, b / max(float(np.max(np.abs(b))), 1e-300)],
            [c / float(np.max(np.abs(c))), np.zeros((1, 1))],
        ]
    )
    unit = np.zeros((n + 1, n + 1))
    unit[:n, :n] = np.eye(n)
    values = scipy.linalg.eigvals(pencil, unit)
    return [complex(value) * fastest for value in values if np.isfinite(value) and abs(value) < FAR]


def _without_hidden(
    poles: list[complex], zeros: list[complex]
) -> tuple[list[complex], list[complex]]:
    """Remove equal poles and zeros, which belong to modes that are not excited or not measured."""
    left = list(zeros)
    seen = []
    for pole in poles:
        same = [k for k, zero in enumerate(left) if abs(zero - pole) < HIDDEN * abs(pole)]
        if same:
            del left[same[0]]
        else:
            seen.append(pole)
    return seen, left


def _pairs(roots: list[complex]) -> tuple[Oscillation, ...]:
    upper = sorted((root for root in roots if root.imag > 1e-9 * abs(root)), key=abs)
    return tuple(Oscillation(abs(root), -root.real / abs(root)) for root in upper)


def _reals(roots: list[complex]) -> tuple[float, ...]:
    return tuple(sorted(-root.real for root in roots if abs(root.imag) <= 1e-9 * abs(root)))
