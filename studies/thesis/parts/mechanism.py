"""Chapter 2: the exhaustive clutch with figures 2.12 to 2.14."""

from __future__ import annotations

import numpy as np

from frictool.documents.mechanism import Mechanism
from frictool.documents.registry import load
from studies.clutch.mechanism_figures import figures, forces
from studies.clutch.rig import CLUTCH
from studies.thesis.results import Part


def mechanism() -> Part:
    """Return the part with figures 2.12 to 2.14 and the condition of self-locking (2.27)."""
    part, found = Part(), forces(load(CLUTCH / "mechanism.yaml", Mechanism))
    springs, cart, rotor = figures(found)
    share = np.abs(found.clutch - found.compensation) / found.friction
    forward, backward = found.rotor
    part.add("section_2_2", {"irreversible": "yes" if float(share.max()) < 1.0 else "no"})
    part.say(
        "section_2_2",
        f"The springs leave at most {100 * share.max():.0f} % of the slideway's friction (2.27).",
    )
    plausible = (
        "The data of springs and profile are assumed: the thesis draws them and prints no number."
    )
    part.draw(
        "2.12",
        f"{plausible} The compensation follows the clutch to within {100 * share.max():.0f} % of "
        "mu_c F_s1.",
        springs,
    )
    part.draw(
        "2.13",
        "Forward and backward (2.28). The resistance opposes the motion everywhere, as (2.27) "
        "requires.",
        cart,
    )
    part.draw(
        "2.14",
        f"Forward {forward.min():.3f} to {forward.max():.3f} N m, backward {backward.min():.3f} "
        f"to {backward.max():.3f} N m; "
        "crosses: (4.42) with the coefficients of table 4.7.",
        rotor,
    )
    return part
