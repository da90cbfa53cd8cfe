"""Verification of a controller whose speed is estimated by an observer.

    controller.yaml, observer.yaml -> velocity: {source: observer, observer: ...}
    -> loops at the vertices -> a controller document

If the linear controller uses the speed, the stored norms and margins do not apply to the loop with
the observer. The margins are then computed again, for a slipping axis. Values that cannot be
computed with an observer (norms, certificate, robustness) are removed. If the linear controller
uses only the position (eta or the position error), its loop is unchanged, and only the virtual
friction is checked.
"""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from frictool.adapters.controller_composition import uses_speed
from frictool.documents.certificate import Certificate
from frictool.documents.controller import Controller, Velocity, Vertex
from frictool.documents.digests import changed_blocks, with_digests
from frictool.documents.observer import Observer
from frictool.errors import FrictoolError, NoSolutionError
from frictool.plant.polytope import PlantPoint
from frictool.presentation.tie_rule import smallest
from frictool.runtime.object_view import ResultView
from frictool.verify.document_check import check_feedback, limiter_brake
from frictool.verify.loop_values import LinearLoops, loops_of
from frictool.verify.loop_wording import NOT_CERTIFIED, delay_words
from frictool.verify.observer_loop import check_observer
from frictool.verify.speed_loop import is_required
from frictool.verify.vertices import vertex_points

# blocks of the controller that the observer replaces
REPLACED = ("velocity", "verified", "certificate")
SAME = 1e-9  # relative tolerance of numbers that two benches state for one rig


@dataclass(frozen=True, eq=False, repr=False)
class ObservedController(ResultView):
    """Controller with an observer, and the modulus margins at the worst vertex.

    - before, after: margins of the speed loop without and with the observer; None if no linear loop
      feeds back the speed
    - at: name of the vertex at which the margin with the observer is smallest
    """

    controller: Controller
    before: float | None = None
    after: float | None = None
    at: str = ""

    @property
    def specified(self) -> float:
        """Return the modulus margin that the controller document specifies."""
        return self.controller.verified.modulus_margin_specified

    def lines(self) -> list[str]:
        """Return the result as lines of text."""
        if self.after is None or self.before is None:
            return [
                "velocity from the observer; the linear loop feeds back the position and is "
                "unchanged"
            ]
        line = (
            f"velocity from the observer: modulus margin {self.after:.3f} at vertex {self.at} with "
            f"the observer, {self.before:.3f} without the observer"
        )
        return [line] + (
            [f"below the {self.specified:g} that was specified"]
            if self.after < self.specified
            else []
        )


def with_observer(
    controller: Controller, observer: Observer, margin: float | None = None
) -> ObservedController:
    """Return the controller with the speed estimate of an observer.

    Parameters
    ----------
    controller : Controller
        Verified controller document.
    observer : Observer
        Observer document of the same rig.
    margin : float, optional
        Modulus margin that replaces the specified margin.

    Returns
    -------
    ObservedController
        Merged document and its margins.

    Raises
    ------
    FrictoolError
        If controller and observer belong to different rigs, or if the controller uses no speed.
    NoSolutionError
        If a loop is unstable at a vertex with at least one of the checked delays.
    """
    _of_one_rig(controller, observer)
    check_observer(observer)
    if not uses_speed(controller):
        raise FrictoolError(
            f"the controller {controller.name!r} uses no speed; allowed: a controller with one "
            "of: input speed_error, brake, energy limiter, virtual friction, friction compensation "
            "by the measured speed"
        )
    merged = msgspec.structs.replace(
        controller, velocity=Velocity(source="observer", observer=observer)
    )
    if margin is not None:
        merged = msgspec.structs.replace(
            merged,
            verified=msgspec.structs.replace(merged.verified, modulus_margin_specified=margin),
        )
    _brake(merged)
    if controller.linear.input != "speed_error" or controller.structure == "position":
        return ObservedController(_digested(merged, controller))
    loops = loops_of(merged, vertex_points(merged))
    vertices = tuple(_vertex(merged, loops, point) for point in loops.points)
    margin_with_it, at = smallest(vertex.modulus_margin for vertex in vertices)
    verified = msgspec.structs.replace(
        merged.verified,
        gamma_asked=None,
        gamma_verified=1.0 / margin_with_it,
        vertices=vertices,
        count_drive=loops.count_drive(),
        rounded=(),
        margins=loops.margins(),
        robustness=None,
    )
    merged = _digested(
        msgspec.structs.replace(merged, verified=verified, certificate=_certificate(controller)),
        controller,
    )
    before = controller.verified.modulus_margin
    return ObservedController(merged, before, margin_with_it, vertices[at].name)


def _digested(merged: Controller, source: Controller) -> Controller:
    """Return the document with new digests of the blocks that the observer changes.

    A block that was changed before, after its verification, keeps its old digest, so that this
    change remains visible.
    """
    if not source.verified.digests:
        return merged
    changed = changed_blocks(source)
    return with_digests(
        merged, *(block for block in REPLACED if block == "velocity" or block not in changed)
    )


def _certificate(controller: Controller) -> Certificate | None:
    if controller.certificate is None:
        return None
    return msgspec.structs.replace(
        controller.certificate, bounds=(), not_proved={"sensitivity": NOT_CERTIFIED}
    )


def _of_one_rig(controller: Controller, observer: Observer) -> None:
    mine, theirs = controller.bench, observer.bench
    pairs: dict[str, tuple[str | float, str | float]] = {
        "axis": (controller.axis, observer.axis),
        "sample_period_s": (controller.sample_period_s, observer.sample_period_s),
        "encoder's step": (mine.encoder.resolution, theirs.encoder.resolution),
        "drive": (controller.drive, theirs.actuator.drive),
        "actuator's constant": (mine.actuator.constant.value, theirs.actuator.constant.value),
        "loop_time_constant_s": (
            mine.actuator.loop_time_constant_s,
            theirs.actuator.loop_time_constant_s,
        ),
        "delay_samples": (controller.delay_samples, theirs.delay_samples),
    }
    for name, (controller_value, observer_value) in pairs.items():
        same = (
            controller_value == observer_value
            if isinstance(controller_value, str) or isinstance(observer_value, str)
            else abs(controller_value - observer_value) <= SAME * abs(controller_value)
        )
        if not same:
            shown = [
                f"{value:.9g}" if isinstance(value, float) else str(value)
                for value in (observer_value, controller_value)
            ]
            raise FrictoolError(
                f"the observer {observer.name} belongs to another rig: its {name} is "
                f"{shown[0]}, {controller.name} has {shown[1]}; design an observer from the "
                "model of the controller"
            )


def _vertex(controller: Controller, loops: LinearLoops, point: PlantPoint) -> Vertex:
    vertex = loops.vertex(point)
    for check in vertex.checks:
        if check.spectral_radius >= 1.0 and is_required(
            check.delay_samples, controller.delay_samples
        ):
            _refuse(
                controller, vertex, check.delay_samples, check.spectral_radius, "the sampled loop"
            )
    return vertex


def _brake(controller: Controller) -> None:
    bench = controller.bench.actuator
    brake = limiter_brake(
        controller.limiter, controller.velocity, bench.constant.value, controller.sample_period_s
    )
    for one in brake:
        for vertex, point in zip(
            controller.verified.vertices, vertex_points(controller), strict=True
        ):
            for check in vertex.checks:
                if not is_required(check.delay_samples, controller.delay_samples):
                    continue
                brake_check = check_feedback(
                    one, point.rates, bench.loop_time_constant_s, check.delay_samples
                )
                if not brake_check.stable:
                    _refuse(
                        controller,
                        vertex,
                        check.delay_samples,
                        brake_check.spectral_radius,
                        "the limiter's virtual friction at rest",
                    )


def _refuse(controller: Controller, vertex: Vertex, delay: int, radius: float, what: str) -> None:
    raise NoSolutionError(
        f"{controller.name}: with the observer {what} is unstable at "
        f"vertex {vertex.name} with {delay_words(delay)} "
        f"(spectral radius {radius:.4f}); try another observer --bandwidth, or a slower controller"
    )
