"""Equations derived from descriptions: the clutch's golden text, the screw's and the gear's from
the thesis, every dimension checked."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.mathtext import MathTextParser

from frictool.adapters.mechanism.assembly import assemble
from frictool.cli.main import group
from frictool.documents.mechanism import Block, Coupling, Link, Mechanism, Rack, Source
from frictool.documents.quantity import Quantity
from frictool.documents.registry import load
from frictool.equations.derivation import Derivation, derive
from frictool.equations.derivation_views import as_latex
from frictool.equations.dimension_check import check_equation, check_sum
from frictool.equations.expression import Equation, Term, symbol
from frictool.plant.mechanism.element_error import ElementError
from frictool.plant.mechanism.linearisation import linearise
from tests.support.mechanism_documents import TRAIN, document

HERE = Path(__file__).parent / "golden"
EVERY_KEY = Path(__file__).parents[1] / "documents" / "golden" / "mechanism.yaml"


def derived(text: str, folder: Path) -> Derivation:
    read = document(text, folder)
    return derive(read, assemble(read))


def section(derivation: Derivation, title: str) -> list[str]:
    return [line.text for found, lines in derivation.sections if found == title for line in lines]


def test_the_clutchs_equations_as_printed() -> None:
    run = CliRunner().invoke(group, ["equations", str(HERE / "clutch.yaml"), "--explain"])
    assert run.exit_code == 0
    assert run.output == (HERE / "clutch.txt").read_text()
    plain = CliRunner().invoke(group, ["equations", str(HERE / "clutch.yaml")])
    assert "(2." in run.output
    assert "(2." not in plain.output


def test_the_machines_view_names_the_element_of_every_term() -> None:
    run = CliRunner().invoke(group, ["equations", str(HERE / "clutch.yaml"), "--json"])
    found = json.loads(run.output)
    bodies = next(part["lines"] for part in found["sections"] if part["title"] == "Free bodies")
    assert [(term["text"], term["element"]) for term in bodies[0]["terms"]] == [
        ("K_motor i_motor", "sources.motor"),
        ("-F_brushes", "links.brushes"),
        ("-p_rack lambda_rack", "links.rack"),
    ]
    assert found["terms_checked"] > 50
    assert {
        "symbol": "J_rotor",
        "value": 1.32e-5,
        "low": 1.11e-5,
        "high": 1.53e-5,
    }.items() <= found["parameters"][-3].items()


@pytest.mark.parametrize(
    "path", [pytest.param(HERE / "clutch.yaml", marks=pytest.mark.accept), EVERY_KEY]
)
def test_every_formula_is_latex(path: Path) -> None:
    """As matplotlib's parser of mathematics reads it; the fragment has as many braces of each
    kind."""
    read = load(path, Mechanism)
    derivation = derive(read, assemble(read))
    parser = MathTextParser("path")
    for formula in {line.latex for _, lines in derivation.sections for line in lines}:
        parser.parse(f"${formula}$")
    fragment = as_latex(derivation)
    assert fragment.count("{") == fragment.count("}")
    assert (
        fragment.count(r"\begin{align*}")
        == fragment.count(r"\end{align*}")
        == len(derivation.sections)
    )


def test_the_gear_of_the_thesis(tmp_path: Path) -> None:
    """(2.3) with its sign read as in (2.4), and J_A + (r^2/eta) J_B where A drives."""
    text = """\
format: mechanism/1
name: gear
blocks: {A: {inertia: {value: 0.02, unit: kg m^2}}, B: {inertia: {value: 0.3, unit: kg m^2}}}
links: {pair: {kind: gear, between: [A, B], ratio: 0.4, efficiency: 0.8}}
sources: {A: {on: A, drive: effort}}
"""
    gear = derived(text, tmp_path)
    assert section(gear, "Free bodies") == [
        "J_A omega_A' = u_A - p_pair lambda_pair",
        "J_B omega_B' = lambda_pair",
    ]
    assert section(gear, "Links") == [
        "theta_B = -r_pair theta_A",
        "omega_B = -r_pair omega_A",
        "p_pair = -r_pair/eta_pair",
        "p_pair = -r_pair eta_back_pair",
    ]
    assert section(gear, "Forces of rigid links eliminated") == [
        "(J_A - p_pair r_pair J_B) omega_A' = u_A"
    ]
    soft = text.replace(
        "efficiency: 0.8",
        "compliance: {stiffness: {value: 5, unit: N m/rad}, damping: {value: 1, unit: N m s/rad}}",
    )
    yielding = derived(soft, tmp_path)
    assert section(yielding, "Links") == ["e_pair = theta_B + r_pair theta_A"]
    assert section(yielding, "Efforts") == [
        "lambda_pair = -k_pair e_pair - d_pair e_pair'"
    ]  # u_B of (2.5)
    assert section(yielding, "Free bodies")[0] == "J_A omega_A' = u_A + r_pair lambda_pair"


@pytest.mark.parametrize(
    ("mu", "relation"),
    [
        (0.1, "back-drivable: mu = 0.1 < tan(alpha) = 0.20271"),
        (0.3, "self-locking, nut cannot drive screw"),
    ],
)
def test_the_screw_of_the_thesis(mu: float, relation: str, tmp_path: Path) -> None:
    """(2.15): M' = J + M r^2 tan(alpha)^2, and the friction of (2.12) as printed."""
    text = f"""\
format: mechanism/1
name: screw
blocks: {{screw: {{inertia: {{value: 1e-4, unit: kg m^2}}}}, nut: {{mass: {{value: 0.5,
  unit: kg}}}}}}
links:
  thread: {{kind: screw, between: [screw, nut], radius: {{value: 5, unit: mm}},
    lead_angle: {{value: 0.2, unit: rad}},
    friction_coefficient: {mu}, friction_form: thesis}}
  spring: {{kind: spring, between: [nut, ground], stiffness: {{value: 8, unit: N/mm}}}}
sources: {{motor: {{on: screw, drive: effort}}}}
"""
    screw = derived(text, tmp_path)
    assert section(screw, "Forces of rigid links eliminated") == [
        "(J_screw + R_thread^2 tan(alpha_thread)^2 m_nut) omega_screw' = u_motor - W_thread - "
        "R_thread tan(alpha_thread) F_spring"
    ]
    assert (
        "W_thread = mu_thread |R_thread lambda_thread - u_screw tan(alpha_thread)| "
        "sign(omega_screw)" in section(screw, "Links")
    )
    assert relation in screw.directions[0]
    exact = derived(text.replace(", friction_form: thesis", ""), tmp_path)
    assert "p_thread = R_thread tan(alpha_thread + atan(mu_thread))" in section(exact, "Links")
    rest = (
        "screw, nut stay at rest while u_motor - p_thread F_spring = 0 for some p_thread "
        "between its values in both directions of power"
    )
    assert section(exact, "Modes") == [rest]
    assert section(screw, "Modes") == [
        "screw, nut stay at rest while |u_motor - R_thread tan(alpha_thread) F_spring| <= "
        "|W_thread|",
    ]
    assert relation in exact.directions[0]


@settings(max_examples=20, deadline=None)
@given(
    ratios=st.lists(st.floats(0.1, 5.0), min_size=1, max_size=6),
    inertias=st.lists(st.floats(1e-5, 1.0), min_size=7, max_size=7),
    parents=st.lists(st.integers(0, 5), min_size=6, max_size=6),
    turned=st.lists(st.booleans(), min_size=6, max_size=6),
    driven=st.integers(0, 6),
)
def test_the_lumped_inertia_of_a_train_is_that_of_the_arrays(
    tmp_path_factory: pytest.TempPathFactory,
    ratios: list[float],
    inertias: list[float],
    parents: list[int],
    turned: list[bool],
    driven: int,
) -> None:
    """J + sum of r^2 J from the formula's own values, from the groups of the assembly and from the
    linearised mechanism."""
    count = len(ratios) + 1
    blocks = ", ".join(
        f"b{i}: {{inertia: {{value: {inertias[i]!r}, unit: kg m^2}}}}" for i in range(count)
    )
    links = []
    for i, ratio in enumerate(ratios):
        pair = (f"b{min(parents[i], i)}", f"b{i + 1}")
        ends = ", ".join(pair[::-1] if turned[i] else pair)
        links.append(f"g{i}: {{kind: gear, between: [{ends}], ratio: {ratio!r}}}")
    on = f"b{min(driven, count - 1)}"
    text = (
        f"format: mechanism/1\nname: train\nblocks: {{{blocks}}}\nlinks: {{{', '.join(links)}}}\n"
    )
    text += f"sources: {{m: {{on: {on}, drive: effort}}}}\n"
    read = document(text, tmp_path_factory.mktemp("train"))
    mechanism = assemble(read)
    (lumped,) = next(
        lines
        for title, lines in derive(read, mechanism).sections
        if title == "Forces of rigid links eliminated"
    )
    assert isinstance(lumped, Equation)
    assert lumped.of.text == f"omega_{on}'"
    (group_of_all,) = mechanism.groups
    seen = group_of_all.inertia / group_of_all.ratios[mechanism.blocks.index(on)] ** 2
    assert sum(term.number for term in lumped.coefficients) == pytest.approx(seen, rel=1e-9)
    linear = linearise(mechanism)
    assert linear.mass[0, 0] / linear.moves[mechanism.blocks.index(on), 0] ** 2 == pytest.approx(
        seen, rel=1e-9
    )
    assert np.all(mechanism.packed.inertia > 0.0)


def test_a_term_of_another_dimension_is_refused(tmp_path: Path) -> None:
    """Units that only a program can get wrong: the check is by the units of the quantities, not by
    the kinds of the blocks."""
    read = document(TRAIN, tmp_path)
    mechanism = assemble(read)
    rack = read.links["rack"]
    assert isinstance(rack, Rack)
    wrong = msgspec.structs.replace(
        read,
        links={
            **read.links,
            "rack": msgspec.structs.replace(rack, radius=Quantity(0.01, unit="m^2")),
        },
    )
    with pytest.raises(
        ElementError,
        match=r"the term r_rack theta_shaft of e_rack = .* \[length\]\^2; allowed: the dimension "
        "of m,",
    ) as caught:
        derive(wrong, mechanism)
    assert caught.value.key == "links.rack"
    heavy = {
        **read.blocks,
        "cart": msgspec.structs.replace(read.blocks["cart"], mass=Quantity(0.5, unit="kg m")),
    }
    with pytest.raises(ElementError, match="m_cart v_cart'"):
        derive(msgspec.structs.replace(read, blocks=heavy), mechanism)


def test_the_check_counts_and_refuses() -> None:
    force, mass, speed = symbol("f", "f", "N"), symbol("m", "m", "kg"), symbol("a", "a", "m/s^2")
    newton = Equation((mass,), speed.factors[0][0], (force, mass.times(speed).negative()), "N")
    assert check_equation(newton) == 3
    assert check_sum([force, Term(((*force.factors[0],),))], "kg m/s^2") == 2
    with pytest.raises(ElementError, match=r"the term m of m a = m has the dimension \[mass\]"):
        check_equation(Equation((mass,), speed.factors[0][0], (mass,), "N"))


def test_products_cancel_and_numbers_add() -> None:
    r, j = symbol("r", "r", "", 0.5), symbol("J", "J", "kg m^2", 3.0)
    q, f = symbol("q", "q").factors[0][0], symbol("f", "f")
    assert r.times(r).times(j).text == "r^2 J"
    assert r.times(r.inverse()) == Term()
    equation = Equation((j, r.times(r).times(j)), q, (f, r.times(f), j.negative()), "")
    assert equation.text == "(J + r^2 J) q = f + r f - J"
    assert equation.numbers == "3.75 q = 1.5 f - 3"


def test_a_train_longer_than_calls_nest() -> None:
    deepest = sys.getrecursionlimit()
    sys.setrecursionlimit(400)
    try:
        _derive_train(420)
    finally:
        sys.setrecursionlimit(deepest)


def _derive_train(count: int) -> None:
    blocks = {f"b{k}": Block(inertia=Quantity(k + 1.0, unit="kg m^2")) for k in range(count)}
    links: dict[str, Link] = {f"c{k}": Coupling((f"b{k}", f"b{k + 1}")) for k in range(count - 1)}
    long = Mechanism(
        "mechanism/1", "long", blocks, links=links, sources={"push": Source("b0", "effort")}
    )
    (lumped,) = [
        line
        for title, lines in derive(long, assemble(long)).sections
        if "eliminated" in title
        for line in lines
    ]
    assert isinstance(lumped, Equation)
    assert lumped.numbers.split()[0] == f"{count * (count + 1) // 2}"
