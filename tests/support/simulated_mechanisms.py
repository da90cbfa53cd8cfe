"""Mechanisms for tests of `simulate`: the clutch's one inertia as a single block, and a motor with
a geared load behind a backlash."""

from __future__ import annotations

from pathlib import Path

import msgspec

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.mechanism import Mechanism
from frictool.documents.model import Model
from frictool.documents.registry import load
from frictool.simulate.mechanism_plant import MechanismPlant
from studies.rigs.clutch_model import ROOT, clutch_model
from tests.support.mechanism_text import mechanism

CLUTCH = ROOT / "configs/clutch/mechanism.yaml"

ONE_BLOCK = """\
format: mechanism/1
name: one block
blocks:
  rotor: {inertia: {value: 1.32e-5, unit: kg m^2}}
links:
  bearing:
    kind: friction
    on: rotor
    law: svc
    parameters:
      coulomb: {value: 0.099, unit: N m}
      breakaway: {value: 0.1089, unit: N m}
      viscous: {value: 3.81e-4, unit: N m s/rad}
  ends: {kind: stop, on: rotor, low: {value: 0, unit: rad}, high: {value: 63, unit: rad}}
sources:
  motor: {on: rotor, drive: current, constant: {value: 13.4e-3, unit: N m/A}, limit: {value: 50, unit: A}, loop_time_constant_s: 0.003}
sensors:
  encoder: {on: rotor, counts_per_revolution: 56}
"""  # noqa: E501  # a link or a source on one line

GEARED = """\
format: mechanism/1
name: geared
blocks:
  rotor: {inertia: {value: 1.2e-5, low: 1.1e-5, high: 1.3e-5, unit: kg m^2}}
  Load: {inertia: {value: 5e-6, unit: kg m^2}}
links:
  bearing:
    kind: friction
    on: rotor
    law: svc
    parameters:
      coulomb: {value: 0.04, low: 0.03, high: 0.05, unit: N m}
      breakaway: {value: 0.044, low: 0.032, high: 0.052, unit: N m}
      viscous: {value: 2e-4, unit: N m s/rad}
  plain: {kind: friction, on: Load, law: coulomb, parameters: {coulomb: {value: 0.03, unit: N m}}}
  pair:
    kind: gear
    between: [rotor, Load]
    ratio: 0.5
    efficiency: 0.9
    backlash: {width: {value: 1, unit: rad}, at: rotor}
sources:
  motor: {on: rotor, drive: current, constant: {value: 13.4e-3, unit: N m/A}, limit: {value: 50, unit: A}, loop_time_constant_s: 0.003}
  hand: {on: Load, drive: effort}
sensors:
  encoder: {on: rotor, counts_per_revolution: 56}
  dial: {on: Load}
control: {source: motor, sensor: encoder}
"""  # noqa: E501  # a link or a source on one line

FREE_MASS = """\
format: mechanism/1
name: free mass
blocks:
  sled: {mass: {value: 2, unit: kg}}
sources:
  push: {on: sled, drive: effort}
sensors:
  ruler: {on: sled}
"""


def plant_of(text: str) -> MechanismPlant:
    """The mechanism that the text describes, as a controller's plant."""
    document = mechanism(text)
    return MechanismPlant(document, assemble(document))


def clutch() -> MechanismPlant:
    """The exhaustive clutch."""
    document = load(CLUTCH, Mechanism)
    return MechanismPlant(document, assemble(document))


def one_axis() -> Model:
    """The model of ONE_BLOCK: no backlash."""
    model = clutch_model()
    mechanics = msgspec.structs.replace(model.bench.mechanics, backlash=None, backlash_coulomb=None)
    return msgspec.structs.replace(
        model, bench=msgspec.structs.replace(model.bench, mechanics=mechanics)
    )


def write_text(folder: Path, name: str, text: str) -> Path:
    """A file of a test."""
    path = folder / name
    path.write_text(text)
    return path
