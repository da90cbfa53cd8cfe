"""Documents as linear systems (`plant.lti.Lti`): a controller, the axis around it, and the loop
that both close.

    eta ──▶ controller ──▶ drive ──▶ delay ──▶ axis ──▶ position            loop gain L: from eta to
                                                                            the position

The friction is left out but for its viscous part, as in the loops that are verified
(verify/feedback_loops.py).
"""

from __future__ import annotations

from frictool.documents.controller import Controller
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.lti import Lti, delay
from frictool.plant.polytope import PlantPoint
from frictool.plant.resonance_filter import resonance_filters
from frictool.verify.feedback_loops import running_form

ETA, DRIVE, POSITION = "eta", "drive", "position"
ASKED = "asked"  # the drive that the controller asks for; DRIVE is what flows, behind delay and lag


def as_linear_system(given: Lti | Model | Controller) -> Lti:
    """A controller as it runs, a model's axis, or the system that is given. Raises FrictoolError
    where it is none of the three."""
    _require(given, Model, Controller, Lti)
    if isinstance(given, Lti):
        return given
    return plant_system(given) if isinstance(given, Model) else controller_system(given)


def controller_system(controller: Controller) -> Lti:
    """The linear controller as it runs on the target, sampled: from eta (or the speed's error,
    linear.input) to the drive [A | V].

    Raises FrictoolError where it is none.
    """
    _require(controller, Controller)
    return running_form(controller.linear, controller.sample_period_s)


def plant_system(
    document: Model | Controller, vertex: str | None = None, *, sampled: bool = False
) -> Lti:
    """The axis from the commanded drive [A | V] to the position [rad | m], with the drive's lag and
    a model's resonances.

    Of a model: its nominal parameters. Of a controller: one of the vertices at which it was
    verified, by name. sampled: held at the bench's period, behind its delay; else in continuous
    time, without. Raises FrictoolError where there is no such vertex, or the document is neither.
    """
    _require(document, Model, Controller)
    bench = document.bench
    lag, period = bench.actuator.loop_time_constant_s, bench.sample_period_s if sampled else 0.0
    resonance = None if document.resonances is None else resonance_filters(document.resonances)[0]
    blocks = {"axis": linear_axis(_rates(document, vertex), lag, period, resonance)}
    if sampled:
        blocks["delay"] = DiagramBlock(delay(bench.delay_samples, period), (ASKED,), ("command",))
    sums: dict[str, dict[str, float]] = {
        "speed_reference": {},
        "friction": {},
        "uncertain_effort": {},
        POSITION: {ETA: -1.0},
    }
    return connect(blocks, sums, (ASKED if sampled else "command",), (POSITION,))


def loop_system(controller: Controller, vertex: str) -> Lti:
    """L(z), from eta to the position, at one vertex with the bench's delay, closed by -1; of a
    controller that is fed by eta.

    1/max |1/(1 + L)| is the vertex's modulus margin. Raises FrictoolError where there is no such
    vertex, the controller sees a speed, or it is none.
    """
    _require(controller, Controller)
    if controller.linear.input != "eta":
        raise FrictoolError(
            f"{controller.name}: its linear controller sees the speed and not eta; its loops are those of verify/effective.py"
        )
    blocks = {
        "controller": DiagramBlock(controller_system(controller), (ETA,), (ASKED,)),
        "plant": DiagramBlock(
            plant_system(controller, vertex, sampled=True), (ASKED,), (POSITION,)
        ),
    }
    return connect(blocks, {}, (ETA,), (POSITION,))


def _require(given: object, *kinds: type) -> None:
    """Raises FrictoolError where `given` is of none of the kinds: names are all that Python itself
    would tell."""
    if not isinstance(given, kinds):
        hint = (
            "; reduce it to a model first (frictool.reduce)" if isinstance(given, Mechanism) else ""
        )
        raise FrictoolError(
            f"found {type(given).__name__}; allowed: {', '.join(kind.__name__ for kind in kinds)}{hint}"
        )


def _rates(document: Model | Controller, vertex: str | None) -> AxisRates:
    if isinstance(document, Model):
        if vertex is not None:
            raise FrictoolError(
                f"{document.name}: a model has no vertex {vertex!r}; those are of a controller"
            )
        today = document.parameters
        point = PlantPoint(
            "model",
            today.inertia.value,
            today.viscous.value,
            today.coulomb.value,
            document.bench.actuator.constant.value,
        )
        return point.rates
    for one in document.verified.vertices:
        if one.name == vertex:
            return PlantPoint(one.name, one.inertia, one.viscous, one.coulomb, one.constant).rates
    names = ", ".join(one.name for one in document.verified.vertices)
    raise FrictoolError(f"{document.name}: there is no vertex {vertex!r}; allowed: {names}")
