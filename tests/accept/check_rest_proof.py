"""Axes that the engine releases in the proved set of two controllers stop inside the band and stay.

python -m tests.accept build/accept.json "rest proof: released axes"
"""

from __future__ import annotations

from typing import Any

from frictool.verify.rest_proof import prove_rest
from tests.support.certified_controllers import Named, certified
from tests.support.released_axes import furthest_release

RELEASES = 2000  # of each controller
NAMES: tuple[Named, ...] = ("speed", "fast")


def releases_axes() -> dict[str, Any]:
    """Passed where no released axis leaves the band, and one uses more than half of it."""
    furthest = {}
    for name in NAMES:
        controller = certified(name)
        assert controller.certificate is not None
        proof = prove_rest(controller, controller.certificate)
        assert proof is not None
        furthest[name] = furthest_release(controller, proof, RELEASES)
    return {"passed": all(0.5 < one < 1.0 for one in furthest.values()), **furthest}


CHECKS = {"rest proof: released axes": releases_axes}
