"""Mechanisms for tests, written as a user writes them."""

from __future__ import annotations

from pathlib import Path

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.mechanism import Mechanism
from frictool.documents.registry import load
from frictool.plant.mechanism.assembled_mechanism import AssembledMechanism

# a motor with a reducer, a cart on a rack in a slideway, a spring to the frame: most kinds of
# elements, one a line
TRAIN = """\
format: mechanism/1
name: train
blocks:
  motor: {inertia: {value: 2.0e-5, unit: kg m^2}}
  shaft: {inertia: {value: 3.0e-4, unit: kg m^2}}
  cart: {mass: {value: 500, unit: g}}
links:
  reducer: {kind: gear, between: [motor, shaft], ratio: 0.25, efficiency: 0.9}
  rack: {kind: rack, between: [shaft, cart], radius: {value: 10, unit: mm}, backlash: {width: {value: 0.2, unit: mm}}}
  spring: {kind: spring, between: [cart, ground], stiffness: {value: 2, unit: N/mm}, preload: {value: 10, unit: N}}
  bearing: {kind: friction, on: motor, law: coulomb, parameters: {coulomb: {value: 5, unit: mN m}}}
  ends: {kind: stop, on: cart, low: {value: -5, unit: mm}, high: {value: 40, unit: mm}, restitution: 0.3}
sources:
  drive: {on: motor, drive: current, constant: {value: 20, unit: mN m/A}, limit: {value: 10, unit: A}}
sensors:
  encoder: {on: motor, counts_per_revolution: 500}
"""  # noqa: E501  # a link or a source on one line


def document(text: str, folder: Path) -> Mechanism:
    """The document of this text."""
    path = folder / "mechanism.yaml"
    path.write_text(text)
    return load(path, Mechanism)


def assembled(text: str, folder: Path) -> AssembledMechanism:
    """The mechanism of this text."""
    return assemble(document(text, folder))
