"""Synthetic controller document made consistent: margins and other forms fit its coefficients."""

from __future__ import annotations

import msgspec
from scipy import signal

from frictool.adapters.state_space import read_state_space, stored_state_space
from frictool.documents.bench import Bench
from frictool.documents.controller import Controller
from frictool.documents.quantity import Quantity
from frictool.plant.lti import inverse_tustin
from frictool.plant.parameter_box import enclosing_box
from frictool.plant.polytope import PlantPoint
from frictool.verify.document_check import loop_checks
from frictool.verify.feedback_loops import feedbacks_of
from frictool.verify.vertices import vertex_points


def truthful(controller: Controller) -> Controller:
    """Return the controller with the verified figures and forms recomputed from its coefficients.

    Each vertex is checked without delay and with the bench's delay. Sections and continuous form
    are computed from the coefficients.
    """
    lag = controller.bench.actuator.loop_time_constant_s
    system = read_state_space(controller.linear.discrete, controller.sample_period_s)
    vertices = []
    for vertex in controller.verified.vertices:
        point = PlantPoint(
            vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant
        )
        checks = loop_checks(feedbacks_of(controller), point, lag, (0, controller.delay_samples))
        vertices.append(
            msgspec.structs.replace(vertex, modulus_margin=checks[-1].modulus_margin, checks=checks)
        )
    sections = signal.zpk2sos(*signal.ss2zpk(system.a, system.b, system.c, system.d))
    linear = msgspec.structs.replace(
        controller.linear,
        continuous=stored_state_space(inverse_tustin(system)),
        sos=tuple(tuple(float(value) for value in row) for row in sections),
    )
    verified = msgspec.structs.replace(controller.verified, vertices=tuple(vertices))
    return msgspec.structs.replace(
        controller, linear=linear, verified=verified, bench=_within(controller)
    )


def _within(controller: Controller) -> Bench:
    """Return the bench with intervals that contain the vertices."""
    box = enclosing_box(vertex_points(controller))

    def held(name: str, quantity: Quantity) -> Quantity:
        low, high = box[name]
        return msgspec.structs.replace(quantity, value=0.5 * (low + high), low=low, high=high)

    bench = controller.bench
    mechanics = {
        name: held(name, getattr(bench.mechanics, name))
        for name in ("inertia", "viscous", "coulomb")
    }
    actuator = msgspec.structs.replace(
        bench.actuator, constant=held("constant", bench.actuator.constant)
    )
    return msgspec.structs.replace(
        bench, mechanics=msgspec.structs.replace(bench.mechanics, **mechanics), actuator=actuator
    )
