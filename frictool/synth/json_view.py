"""JSON output of `synth --json`."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import msgspec

from frictool.documents.controller import Controller, Vertex
from frictool.synth.design import SynthesisResult
from frictool.synth.load_disturbance import LoadDisturbance
from frictool.synth.weight_relaxation import Trade


def json_view(result: SynthesisResult, disturbance: LoadDisturbance) -> dict[str, Any]:
    """Return the result of a synthesis as JSON data.

    disturbance: largest load of the model.
    """
    controller = result.controller
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
        "order": controller.linear.order,
        "modulus_margin": verified.modulus_margin,
        "position_law": None
        if law is None
        else {"gain": law.gain, "formula": law.formula, "kind": law.kind},
        "profile": msgspec.to_builtins(controller.profile),
        "feedforward": msgspec.to_builtins(controller.feedforward),
        "velocity": msgspec.to_builtins(controller.velocity),
        "limiter": msgspec.to_builtins(controller.limiter),
        "friction_compensation": msgspec.to_builtins(controller.friction_compensation),
        "form": controller.linear.form,
        "margins": msgspec.to_builtins(verified.margins),
        "count_drive": verified.count_drive,
        "rounded": msgspec.to_builtins(verified.rounded),
        "robustness": msgspec.to_builtins(verified.robustness),
        "certificate": _certificate(result),
        "schedule": _schedule(controller),
        "vertices": [_vertex(vertex) for vertex in verified.vertices],
        "derived_weights": [asdict(weight) for weight in result.derived],
        "relaxed": _trade(result.trade),
        "notes": list(result.notes),
        "disturbance": asdict(disturbance) if disturbance.total else None,
    }


def _certificate(result: SynthesisResult) -> dict[str, Any] | None:
    certificate = result.controller.certificate
    if certificate is None:
        return None
    return {
        "box": msgspec.to_builtins(certificate.box),
        "proved": [asdict(bound) for bound in result.proved],
        "rest": msgspec.to_builtins(certificate.rest),
        "cycle": msgspec.to_builtins(certificate.cycle),
    }


def _schedule(controller: Controller) -> dict[str, Any] | None:
    schedule = controller.schedule
    if schedule is None:
        return None
    return {**msgspec.to_builtins(schedule), "corners": len(schedule.corners)}


def _trade(trade: Trade | None) -> dict[str, Any] | None:
    if trade is None:
        return None
    return {
        "why": trade.why,
        "chosen": asdict(trade.chosen),
        "start": asdict(trade.start),
        "curve": [asdict(point) for point in trade.curve],
    }


def _vertex(vertex: Vertex) -> dict[str, Any]:
    view = msgspec.to_builtins(vertex)
    checks, order = view.pop("checks"), ("delay_samples", "modulus_margin", "spectral_radius")
    return {**view, "by_delay": [{key: check[key] for key in order} for check in checks]}
