"""A controller document against its own claims: every vertex rebuilt from the stored coefficients, none of the stored figures believed."""

from __future__ import annotations

import numpy as np

from frictool.documents.controller import Controller, DelayCheck
from frictool.errors import NoSolutionError
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.verify.speed_loop import check_loop
from frictool.verify.stored_forms import check_forms

AGREEMENT = 1e-6  # relative, between a stored margin and the one found again


def loop_checks(system: Lti, point: PlantPoint, lag: float, delays: tuple[int, ...]) -> tuple[DelayCheck, ...]:
    """The sampled loop at one vertex with each number of samples of delay, as a document stores it."""
    found = (check_loop(system, point.rates, lag, delay) for delay in delays)
    return tuple(DelayCheck(check.delay_samples, check.spectral_radius, check.modulus_margin) for check in found)


def recheck(controller: Controller) -> None:
    """Raises NoSolutionError where the coefficients do not give what `verified` says of them, at some vertex and delay; where the stored
    forms are not of one controller; or where the document is not of its own bench."""
    _of_its_bench(controller)
    try:
        _vertices(controller)
        check_forms(controller)
    except (ValueError, np.linalg.LinAlgError, FloatingPointError) as error:  # coefficients near the end of the range of numbers
        raise NoSolutionError(f"{controller.name}: not verified: the loop cannot be evaluated ({error}); synthesise it anew") from None


def _of_its_bench(controller: Controller) -> None:
    bench = controller.bench
    pairs = {
        "axis": (controller.axis, bench.axis),
        "drive": (controller.drive, bench.actuator.drive),
        "drive_limit": (controller.drive_limit, bench.actuator.limit.value),
        "sample_period_s": (controller.sample_period_s, bench.sample_period_s),
        "delay_samples": (controller.delay_samples, bench.delay_samples),
    }
    for key, (found, has) in pairs.items():
        if found != has:
            raise NoSolutionError(f"{controller.name}: not verified: {key}: found {found}, but its bench has {has}; synthesise it anew")


def _vertices(controller: Controller) -> None:
    lag = controller.bench.actuator.loop_time_constant_s
    system = Lti.of(controller.linear.discrete, controller.sample_period_s)
    if not controller.verified.vertices:
        raise NoSolutionError(f"{controller.name}: not verified: the controller names no vertex; synthesise it anew")
    for vertex in controller.verified.vertices:
        point = PlantPoint(vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant)
        delays = tuple(check.delay_samples for check in vertex.checks)
        if controller.delay_samples not in delays:
            raise NoSolutionError(
                f"{controller.name}: not verified: vertex {vertex.name} has no check at the bench's delay; synthesise it anew"
            )
        for stored, found in zip(vertex.checks, loop_checks(system, point, lag, delays), strict=True):
            stated = [stored.modulus_margin]
            if stored.delay_samples == controller.delay_samples:
                stated.append(vertex.modulus_margin)
            _compare(f"{controller.name}: not verified: at vertex {vertex.name}", stated, found)
        if vertex.modulus_margin < controller.verified.modulus_margin_specified:
            raise NoSolutionError(
                f"{controller.name}: not verified: at vertex {vertex.name} the modulus margin is {vertex.modulus_margin:.6g}, specified "
                f"{controller.verified.modulus_margin_specified:g}; synthesise it anew"
            )


def _compare(where: str, stated: list[float], found: DelayCheck) -> None:
    if found.spectral_radius >= 1.0:
        raise NoSolutionError(
            f"{where} the loop of the stored coefficients is unstable with {found.delay_samples} samples of delay "
            f"(spectral radius {found.spectral_radius:.6g}); synthesise it anew"
        )
    for margin in stated:
        if abs(found.modulus_margin - margin) > AGREEMENT * margin:
            raise NoSolutionError(
                f"{where} the stored coefficients give a modulus margin of {found.modulus_margin:.6g} with {found.delay_samples} samples "
                f"of delay, the document says {margin:.6g}; synthesise it anew"
            )
