"""Proof of the certificate in a controller document, for the stored coefficients."""

from __future__ import annotations

from frictool.documents.certificate import Certificate, CertifiedWeights
from frictool.documents.controller import Controller
from frictool.errors import NoSolutionError
from frictool.verify.certificate_loop import CertificateLoop, SpeedFeedback
from frictool.verify.loop_wording import NOT_CERTIFIED
from frictool.verify.proved_bound import ProvedBound


def certified_loop(controller: Controller, weights: CertifiedWeights) -> CertificateLoop:
    """Return the closed loop to which the bounds in a document's certificate apply.

    The loop contains the computational delay, the lag of the drive, and the coefficients that run
    on the target hardware. Raises NoSolutionError if the loop feeds back the speed estimate of an
    observer.
    """
    return CertificateLoop(
        controller=controller.linear.discrete,
        controlled="position" if controller.structure == "position" else "speed",
        delay=controller.delay_samples,
        lag=controller.bench.actuator.loop_time_constant_s,
        period=controller.sample_period_s,
        weights=weights,
        sections=controller.linear.sos if controller.linear.form == "sos" else (),
        speed=_speed_feedback(controller),
    )


def _speed_feedback(controller: Controller) -> SpeedFeedback | None:
    if controller.structure == "position" or controller.linear.input == "eta":
        return None
    if controller.velocity.observer is not None:
        raise NoSolutionError(NOT_CERTIFIED)
    law = controller.position_law
    proportional = law is not None and law.kind == "proportional"
    return SpeedFeedback(controller.velocity, law.gain if law and proportional else 0.0)


def prove_document(controller: Controller, certificate: Certificate) -> tuple[ProvedBound, ...]:
    """Prove every bound of the certificate for the stored coefficients of the controller.

    Raises NoSolutionError if a bound is not proved, or if the certificate lacks a bound (norm or
    sensitivity) and states no reason.
    """
    quantities = ("sensitivity",) if controller.judged_by is None else ("norm", "sensitivity")
    for quantity in quantities:
        if (
            quantity
            not in {bound.of for bound in certificate.bounds} | certificate.not_proved.keys()
        ):
            raise NoSolutionError(
                f"{controller.name}: not proved: certificate.bounds has no bound of the "
                f"{quantity}, and certificate.not_proved gives no reason; "
                "run frictool synth again"
            )
    if not certificate.bounds:
        return ()
    from frictool.verify.zero_exclusion import prove  # loads numba

    try:
        return prove(certificate, certified_loop(controller, certificate.weights))
    except NoSolutionError as error:
        raise NoSolutionError(f"{controller.name}: {error}") from None
