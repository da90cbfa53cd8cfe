"""The printed equations are those that the simulation moves: terms evaluated along a run against
the accelerations seen there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from frictool.adapters.mechanism.assembly import assemble
from frictool.engine.mechanism.open_loop_run import run
from frictool.engine.mechanism.preparation import prepare
from frictool.engine.mechanism.state import rest
from frictool.engine.status_codes import OK
from frictool.equations.derivation import derive
from frictool.equations.expression import Equation, Term
from tests.support.mechanism_documents import TRAIN, document

# lossy and lossless rigid links, yielding ones, a spring, friction over the position, a cam: a
# motor that goes on forward
MOVING = """\
format: mechanism/1
name: moving
blocks:
  motor: {inertia: {value: 2.0e-5, unit: kg m^2}}
  shaft: {inertia: {value: 3.0e-4, unit: kg m^2}, start: {value: 0.3, unit: rad}}
  pulley: {inertia: {value: 1.0e-3, unit: kg m^2}}
  cart: {mass: {value: 0.5, unit: kg}, start: {value: 2, unit: mm}}
  slave: {mass: {value: 0.2, unit: kg}}
links:
  reducer: {kind: gear, between: [motor, shaft], ratio: 0.25, efficiency: 0.9}
  belt: {kind: belt, between: [shaft, pulley], radius_a: {value: 2, unit: cm}, radius_b: {value: 5,
    unit: cm},
    compliance: {stiffness: {value: 5, unit: N/mm}, damping: {value: 20, unit: N s/m}}}
  rack: {kind: rack, between: [pulley, cart], radius: {value: 3, unit: cm}, reversed: true}
  hydraulics: {kind: hydraulic, between: [cart, slave], area_a: {value: 3, unit: cm^2},
    area_b: {value: 5, unit: cm^2},
    compliance: {stiffness: {value: 40, unit: N/mm}, damping: {value: 60, unit: N s/m}}}
  spring: {kind: spring, between: [slave, ground], stiffness: {value: 0.3, unit: N/mm},
    preload: {value: 2, unit: N}}
  disc: {kind: spring, between: [cart, ground], damping: {value: 3, unit: N s/m},
    force: {position: {values: [-3, 10, 60], unit: mm}, value: {values: [0, 4, 30], unit: N}}}
  slideway: {kind: friction, on: cart, law: stribeck, parameters: {coulomb: {value: 2, unit: N},
    breakaway: {value: 3, unit: N},
    stribeck_velocity: {value: 20, unit: mm/s}, viscous: {value: 5, unit: N s/m}},
    level: {position: {values: [0, 60], unit: mm}, factor: [0.9, 1.5]}}
  bearing: {kind: friction, on: motor, law: coulomb, parameters: {coulomb: {value: 5, unit: mN m}}}
sources:
  drive: {on: motor, drive: current, constant: {value: 50, unit: mN m/A}, limit: {value: 10,
    unit: A}}
  weight: {on: slave, drive: effort, effort: {value: 1.5, unit: N}}
"""
DISC, LEVEL = ((-0.003, 0.01, 0.06), (0.0, 4.0, 30.0)), ((0.0, 0.06), (0.9, 1.5))


def evaluated(terms: tuple[Term, ...], known: dict[str, float]) -> float:
    """The sum, with what has no value of its own looked up by its text."""
    total = 0.0
    for term in terms:
        product = float(term.sign)
        for atom, power in term.factors:
            product *= (known[atom.text] if atom.value is None else atom.value) ** power
        total += product
    return total


def test_the_terms_add_up_to_the_accelerations_of_the_simulation(tmp_path: Path) -> None:
    from scipy.interpolate import PchipInterpolator

    read = document(MOVING, tmp_path)
    mechanism = assemble(read)
    machine = prepare(mechanism.packed)
    state = rest(mechanism.packed, machine, mechanism.start)
    period, samples = 1e-5, 10_000
    moved = run(machine, state, np.tile([4.0, 0.0], (samples, 1)), period)
    assert moved.status == OK
    lines = dict(derive(read, mechanism).sections)
    disc, level = PchipInterpolator(*DISC), PchipInterpolator(*LEVEL)
    for at in (2000, 5000, 9000):
        speeds = moved.speeds[:, at]
        assert np.all(speeds[:2] * np.array([1.0, -1.0]) > 0.0)
        slope = (
            moved.speeds[:, at - 2]
            - 8 * moved.speeds[:, at - 1]
            + 8 * moved.speeds[:, at + 1]
            - moved.speeds[:, at + 2]
        ) / (12 * period)
        known = {"i_drive": 4.0, "u_weight": 0.0}
        for name, kind, q, v in zip(
            mechanism.blocks, mechanism.kinds, moved.positions[:, at], speeds, strict=True
        ):
            place, rate = ("theta", "omega") if kind == "rotary" else ("x", "v")
            known |= {
                f"{place}_{name}": q,
                f"{rate}_{name}": v,
                f"sign({rate}_{name})": math.copysign(1.0, v),
            }
        for equation in lines[
            "Links"
        ]:  # what is stretched, and how fast; p of the reducer, which the motor drives
            assert isinstance(equation, Equation)
            if equation.of.text not in known:
                known[equation.of.text] = evaluated(equation.right, known)
        known["e_spring"], known["e_disc"] = known["x_slave"], known["x_cart"]
        rates = {
            "e_belt'": ("omega_pulley", "omega_shaft", 0.4),
            "e_hydraulics'": ("v_slave", "v_cart", 0.6),
        }
        known |= {name: known[b] - ratio * known[a] for name, (b, a, ratio) in rates.items()}
        known |= {
            "e_spring'": known["v_slave"],
            "e_disc'": known["v_cart"],
            "curve_disc(e_disc)": float(disc(known["x_cart"])),
        }
        known["level_slideway(x_cart)"] = float(level(known["x_cart"]))
        known["(Fs_slideway - Fc_slideway)"] = 1.0
        known["exp(-|v_cart/v_s_slideway|^delta_slideway)"] = math.exp(
            -((known["v_cart"] / 0.02) ** 2)
        )
        for equation in lines["Efforts"]:
            assert isinstance(equation, Equation)
            known.setdefault(equation.of.text, evaluated(equation.right, known))
        accelerations = {
            f"{rate}'": value
            for rate, value in zip(
                [n for n in known if n.startswith(("omega_", "v_"))], slope, strict=False
            )
        }
        checked = set()
        for equation in (*lines["Forces of rigid links eliminated"], *lines["Free bodies"][-1:]):
            assert isinstance(equation, Equation)
            right = evaluated(equation.right, known)
            left = evaluated(equation.coefficients, known) * accelerations[equation.of.text]
            largest = max(abs(evaluated((term,), known)) for term in equation.right)
            assert left == pytest.approx(right, abs=2e-6 * largest), equation.text
            checked.add(equation.of.text)
        assert checked == {"omega_motor'", "omega_pulley'", "v_slave'"}
        # that the motor drives is so: lambda of its reducer from the shaft's free body, with the
        # direction of its speed
        shaft = lines["Free bodies"][1]
        assert isinstance(shaft, Equation)
        others = tuple(term for term in shaft.right if "lambda_reducer" not in term.text)
        force = evaluated(shaft.coefficients, known) * accelerations["omega_shaft'"] - evaluated(
            others, known
        )
        assert force * known["omega_shaft"] > 0.0


def test_blocks_without_mass_move_as_those_with_hardly_any(tmp_path: Path) -> None:
    """The massless cart of (2.24)-(2.25), behind a massless shaft: also where the spring's force is
    0 and nothing acts there."""
    rigid = TRAIN.replace(", backlash: {width: {value: 0.2, unit: mm}}", "")
    assert rigid != TRAIN
    ends = []
    for shaft, cart in (("1.0e-12", "1.0e-9"), ("0", "0")):
        text = rigid.replace("3.0e-4", shaft).replace(
            "value: 500, unit: g", f"value: {cart}, unit: kg"
        )
        mechanism = assemble(document(text, tmp_path))
        machine = prepare(mechanism.packed)
        moved = run(
            machine, rest(mechanism.packed, machine, mechanism.start), np.full((300, 1), 0.1), 1e-3
        )
        assert moved.status == OK
        assert np.ptp(moved.positions[0]) > 1.5
        ends.append(moved.positions)
    assert ends[1] == pytest.approx(ends[0], abs=1e-5)
