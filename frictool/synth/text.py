"""What `synth` tells people of a controller."""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.documents.quantity import si_unit
from frictool.synth.disturbance import Disturbance


def text(controller: Controller, disturbance: Disturbance) -> str:
    return "\n".join([*_head(controller), *_vertices(controller), *_disturbance(disturbance, si_unit("effort", controller.axis))])


def _head(controller: Controller) -> list[str]:
    verified, law = controller.verified, controller.position_law
    asked = "" if verified.gamma_asked is None else f"gamma asked {verified.gamma_asked:.4g}, "
    lines = [
        f"{controller.name}: {controller.structure.replace('_', ' ')} by {controller.method} in {controller.domain} time, "
        f"order {len(controller.linear.discrete.a)}, {controller.sample_period_s * 1e3:g} ms, "
        f"{controller.delay_samples} sample(s) of delay; {asked}verified {verified.gamma_verified:.4g}"
    ]
    if law is not None:
        lines.append(f"position law: gain {law.gain:.4g} by {law.formula}, band {law.band:.4g}, {law.action}")
    return lines


def _vertices(controller: Controller) -> list[str]:
    verified = controller.verified
    delays = [check.delay_samples for check in verified.vertices[0].checks]
    lines = [
        "vertex  inertia    viscous    coulomb    constant   norm    sampled " + "  ".join(f"margin (delay {d})" for d in delays),
    ]
    for v in verified.vertices:
        margins = "  ".join(f"{check.modulus_margin:16.3f}" for check in v.checks)
        plant = f"{v.name:<7} {v.inertia:<10.4g} {v.viscous:<10.4g} {v.coulomb:<10.4g} {v.constant:<10.4g}"
        lines.append(f"{plant} {v.norm:<7.4g} {v.sampled_norm:<7.4g} {margins}")
    worst = min(vertex.modulus_margin for vertex in verified.vertices)
    lines.append(
        f"verified: stable at all {len(verified.vertices)} vertices, modulus margin {worst:.3f} >= {verified.modulus_margin_specified:g}"
    )
    return lines


def _disturbance(found: Disturbance, unit: str) -> list[str]:
    """What the loop was not designed for and has to bear."""
    if found.total == 0.0:
        return []
    parts = [f"{name} {value:.4g}" for name in ("offset", "gravity", "ripple") if (value := getattr(found, name))]
    share = f"{100.0 * found.total / found.available:.2g} % of the {found.available:.4g} {unit} at the drive's limit"
    lines = [f"disturbance: up to {' + '.join(parts)} {unit}, {share}; the plants of the polytope are without it, simulate plays it"]
    if found.total >= found.breakaway:
        lines.append(f"  the least breakaway, {found.breakaway:.4g} {unit}, does not hold it: with the drive off the axis may move")
    return lines
