"""SLICOT's H-infinity synthesis (sb10ad) in a separate process with a time limit.

On some plants sb10ad does not return.

    python -m studies.references.slicot < plant.npz

prints {"info": ..., "gamma": ..., "seconds": ..., "a": ..., ...}.
"""

from __future__ import annotations

import importlib.util
import io
import json
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from frictool.plant.generalised_plant import GeneralisedPlant
from frictool.plant.lti import Lti

AVAILABLE = importlib.util.find_spec("ctrlsys") is not None
MISSING = "ctrlsys (SLICOT) is not installed"
FIRST_GAMMA, TOLERANCE = 1e3, 1e-5
BISECTION = 1
SAYS = {
    3: " (D12 has not full rank)",
    4: " (D21 has not full rank)",
    6: " (gamma too small)",
    12: " (no stabilising controller found)",
}


@dataclass(frozen=True)
class Slicot:
    """Result of SLICOT: `gamma` and `controller`, or None and the reason.

    seconds: time of the routine alone.
    """

    gamma: float | None
    controller: Lti | None
    reason: str = ""
    seconds: float = float("nan")


def slicot(plant: GeneralisedPlant, timeout: float, first: float = FIRST_GAMMA) -> Slicot:
    """Return sb10ad's optimum for a plant in continuous time, within `timeout` seconds."""
    sent = io.BytesIO()
    b, c = np.hstack([plant.b1, plant.b2]), np.vstack([plant.c1, plant.c2])
    d = np.block(
        [[plant.d11, plant.d12], [plant.d21, np.zeros((len(plant.c2), plant.b2.shape[1]))]]
    )
    np.savez(
        sent,
        a=plant.a,
        b=b,
        c=c,
        d=d,
        ports=np.array([plant.b2.shape[1], len(plant.c2)]),
        first=first,
    )
    try:
        ended = subprocess.run(
            [sys.executable, "-m", "studies.references.slicot"],
            input=sent.getvalue(),
            capture_output=True,
            timeout=timeout,
            cwd=Path(__file__).parents[2],
            check=False,
        )
    except subprocess.TimeoutExpired:
        return Slicot(None, None, f"did not return within {timeout:g} s")
    if ended.returncode:
        return Slicot(
            None, None, f"ended with code {ended.returncode}: {ended.stderr.decode()[-200:]}"
        )
    answer = json.loads(ended.stdout)
    info, seconds = answer["info"], answer["seconds"]
    if info != 0:
        return Slicot(None, None, f"info {info}{SAYS.get(info, '')}", seconds)
    n = len(plant.a)
    controller = Lti(
        np.array(answer["a"]).reshape(n, n),
        np.array(answer["b"]).reshape(n, -1),
        np.array(answer["c"]).reshape(-1, n),
        np.array(answer["d"]).reshape(d[:1, :1].shape),
        0.0,
    )
    return Slicot(answer["gamma"], controller, "", seconds)


def main() -> None:
    import ctrlsys

    given = np.load(io.BytesIO(sys.stdin.buffer.read()))
    a, b, c, d = (np.asfortranarray(given[name]) for name in "abcd")
    controls, measured = (int(count) for count in given["ports"])
    start = time.perf_counter()
    found = ctrlsys.sb10ad(
        BISECTION,
        len(a),
        b.shape[1],
        len(c),
        controls,
        measured,
        a,
        b,
        c,
        d,
        float(given["first"]),
        TOLERANCE,
        0.0,
    )
    seconds = time.perf_counter() - start
    controller = dict(zip("abcd", (np.asarray(part).tolist() for part in found[:4]), strict=True))
    json.dump(
        {"info": int(found[-1]), "gamma": float(found[8]), "seconds": seconds, **controller},
        sys.stdout,
    )


if __name__ == "__main__":
    main()
