"""A made-up controller document whose `verified` is made true: the margins that its coefficients really give."""

from __future__ import annotations

import msgspec

from frictool.documents.controller import Controller
from frictool.plant.lti import Lti
from frictool.plant.polytope import PlantPoint
from frictool.verify.controller import loop_checks


def truthful(controller: Controller) -> Controller:
    """The same controller with every vertex's checks found again at no delay and at the bench's."""
    lag = controller.bench.actuator.loop_time_constant_s
    system = Lti.of(controller.linear.discrete, controller.sample_period_s)
    vertices = []
    for vertex in controller.verified.vertices:
        point = PlantPoint(vertex.name, vertex.inertia, vertex.viscous, vertex.coulomb, vertex.constant)
        checks = loop_checks(system, point, lag, (0, controller.delay_samples))
        vertices.append(msgspec.structs.replace(vertex, modulus_margin=checks[-1].modulus_margin, checks=checks))
    return msgspec.structs.replace(controller, verified=msgspec.structs.replace(controller.verified, vertices=tuple(vertices)))
