"""What `synth --json` tells: the machine's view of a controller."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from frictool.documents.controller import Controller, Vertex
from frictool.synth.disturbance import Disturbance


def machine(controller: Controller, disturbance: Disturbance) -> dict[str, Any]:
    verified, law = controller.verified, controller.position_law
    return {
        "name": controller.name,
        "structure": controller.structure,
        "method": controller.method,
        "gamma": verified.gamma_asked,
        "gamma_verified": verified.gamma_verified,
        "domain": controller.domain,
        "sample_period_s": controller.sample_period_s,
        "delay_samples": controller.delay_samples,
        "order": len(controller.linear.discrete.a),
        "modulus_margin": min(vertex.modulus_margin for vertex in verified.vertices),
        "position_law": None if law is None else {"gain": law.gain, "formula": law.formula},
        "vertices": [_vertex(vertex) for vertex in verified.vertices],
        "disturbance": asdict(disturbance) if disturbance.total else None,
    }


def _vertex(vertex: Vertex) -> dict[str, Any]:
    return {
        "name": vertex.name,
        "inertia": vertex.inertia,
        "viscous": vertex.viscous,
        "coulomb": vertex.coulomb,
        "constant": vertex.constant,
        "norm": vertex.norm,
        "sampled_norm": vertex.sampled_norm,
        "modulus_margin": vertex.modulus_margin,
        "stable": vertex.stable,
        "by_delay": [
            {"delay_samples": c.delay_samples, "modulus_margin": c.modulus_margin, "spectral_radius": c.spectral_radius}
            for c in vertex.checks
        ],
    }
