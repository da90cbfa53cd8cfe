"""Linear systems of a model or a controller document.

    eta ──▶ controller ──▶ drive ──▶ delay ──▶ axis ──▶ position

The loop gain L is the transfer from eta, the position error, to the position. The axis has
viscous friction only, as in the verified loops (verify/feedback_loops.py).
"""

from __future__ import annotations

from frictool.adapters.resonance_filter import resonance_filters
from frictool.documents.controller import Controller
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.errors import FrictoolError
from frictool.plant.block_diagram import DiagramBlock, connect
from frictool.plant.linear_axis import AxisRates, linear_axis
from frictool.plant.lti import Lti, delay
from frictool.plant.polytope import PlantPoint
from frictool.verify.feedback_loops import running_form

ETA, DRIVE, POSITION = "eta", "drive", "position"
REQUESTED = "requested"  # drive commanded by the controller; DRIVE is the drive after delay and lag


def as_linear_system(system: Lti | Model | Controller) -> Lti:
    """Return the linear system of a controller or model; an Lti is returned unchanged.

    Raises FrictoolError for any other type.
    """
    _require(system, Model, Controller, Lti)
    if isinstance(system, Lti):
        return system
    return plant_system(system) if isinstance(system, Model) else controller_system(system)


def controller_system(controller: Controller) -> Lti:
    """Return the sampled linear system of a controller, as it runs on the target.

    Parameters
    ----------
    controller : Controller
        Controller document.

    Returns
    -------
    Lti
        System sampled at `sample_period_s`, with one input and one output. The input is the
        position error eta, or the speed error if `linear.input` says so; the output is the drive [A
        | V].

    Raises
    ------
    FrictoolError
        If `controller` is not a controller document.
    """
    _require(controller, Controller)
    return running_form(controller.linear, controller.sample_period_s)


def plant_system(
    document: Model | Controller, vertex: str | None = None, *, sampled: bool = False
) -> Lti:
    """Return the linear system from the commanded drive [A | V] to the position [rad | m].

    The system includes the lag of the drive and the resonances of the document.

    Parameters
    ----------
    document : Model or Controller
        A model is used with its nominal parameters, a controller with the plant of one vertex.
    vertex : str, optional
        Name of the vertex; required for a controller, not allowed for a model.
    sampled : bool
        True: sampled by zero-order hold, with the sample period [s] and the delay in bench.yaml.
        False: continuous time, without the delay.

    Returns
    -------
    Lti
        System with one input and one output.

    Raises
    ------
    FrictoolError
        If the vertex does not exist, or `document` is neither a model nor a controller.
    """
    _require(document, Model, Controller)
    bench = document.bench
    lag = bench.actuator.loop_time_constant_s
    period = bench.sample_period_s if sampled else 0.0
    resonance = None if document.resonances is None else resonance_filters(document.resonances)[0]
    blocks = {"axis": linear_axis(_rates(document, vertex), lag, period, resonance)}
    if sampled:
        blocks["delay"] = DiagramBlock(
            delay(bench.delay_samples, period), (REQUESTED,), ("command",)
        )
    sums: dict[str, dict[str, float]] = {
        "speed_reference": {},
        "friction": {},
        "uncertain_effort": {},
        POSITION: {ETA: -1.0},
    }
    return connect(blocks, sums, (REQUESTED if sampled else "command",), (POSITION,))


def loop_system(controller: Controller, vertex: str) -> Lti:
    """Return the loop gain L(z) from the error eta to the position at one vertex, with the delay.

    The feedback is negative: 1/max |1/(1 + L)| is the modulus margin of the vertex.

    Parameters
    ----------
    controller : Controller
        Controller document with a linear controller whose input is the position error eta.
    vertex : str
        Name of a vertex in the controller's verification.

    Returns
    -------
    Lti
        System with one input and one output, sampled at the controller's period [s].

    Raises
    ------
    FrictoolError
        If the vertex does not exist, the input of the linear controller is a speed, or `controller`
        is not a controller document.
    """
    _require(controller, Controller)
    if controller.linear.input != "eta":
        raise FrictoolError(
            f"{controller.name}: the input of the linear controller is a speed; loop_system needs "
            "the input eta, a position error"
        )
    blocks = {
        "controller": DiagramBlock(controller_system(controller), (ETA,), (REQUESTED,)),
        "plant": DiagramBlock(
            plant_system(controller, vertex, sampled=True), (REQUESTED,), (POSITION,)
        ),
    }
    return connect(blocks, {}, (ETA,), (POSITION,))


def _require(document: object, *kinds: type) -> None:
    if not isinstance(document, kinds):
        hint = (
            "; reduce it to a model first (frictool.reduce)"
            if isinstance(document, Mechanism)
            else ""
        )
        raise FrictoolError(
            f"found {type(document).__name__}; allowed: "
            f"{', '.join(kind.__name__ for kind in kinds)}{hint}"
        )


def _rates(document: Model | Controller, vertex: str | None) -> AxisRates:
    if isinstance(document, Model):
        if vertex is not None:
            raise FrictoolError(
                f"{document.name}: a model has no vertex {vertex!r}; only a controller has vertices"
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
