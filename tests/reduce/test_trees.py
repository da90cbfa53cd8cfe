"""Rigid trees at random: what is lumped has the energy and the power of the whole."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from frictool.adapters.mechanism.assembly import assemble
from frictool.documents.mechanism import Block, Gear, Link, Mechanism, Rack, Spring
from frictool.documents.quantity import Quantity
from frictool.reduce.block_resistance import resisting
from frictool.reduce.connections import connections, seen_from
from frictool.reduce.coordinate_change import from_source
from frictool.reduce.rigid_lumping import lump_rigid_links
from tests.support.small_mechanisms import coulomb, mechanism, rotor, slide

Q = Quantity
sizes = st.floats(0.1, 10.0)


@st.composite
def trees(draw: st.DrawFn) -> Mechanism:
    """2 to 6 blocks, each hung on an earlier one that turns by a gear or a rack; springs and
    friction on some."""
    blocks: dict[str, Block] = {"b0": rotor(draw(sizes))}
    links: dict[str, Link] = {}
    for k in range(1, draw(st.integers(2, 6))):
        turning = [name for name, block in blocks.items() if block.inertia is not None]
        parent = draw(st.sampled_from(turning))
        name, start = f"b{k}", draw(st.integers(-100, 100)) / 100.0
        if draw(st.booleans()):
            blocks[name] = Block(inertia=Q(draw(sizes), unit="kg m^2"), start=Q(start, unit="rad"))
            links[f"l{k}"] = Gear((parent, name), draw(sizes), internal=draw(st.booleans()))
        else:
            blocks[name] = Block(mass=Q(draw(sizes), unit="kg"), start=Q(start, unit="m"))
            links[f"l{k}"] = Rack(
                (parent, name), Q(draw(sizes), unit="m"), reversed=draw(st.booleans())
            )
        turns = blocks[name].inertia is not None
        links[f"s{k}"] = Spring(
            (name, "ground"), stiffness=Q(draw(sizes), unit="N m/rad" if turns else "N/m")
        )
        links[f"f{k}"] = coulomb(name, draw(sizes), "N m" if turns else "N")
    return mechanism(blocks, links, "b0", "b0", travel=(-1.0, 1.0))


@given(trees(), st.floats(-2.0, 2.0), st.floats(-1.0, 1.0))
def test_a_lumped_tree_has_the_energy_and_the_efforts_of_the_whole(
    whole: Mechanism, speed: float, place: float
) -> None:
    one, _ = lump_rigid_links(from_source(whole, "motor")[0], "b0")
    assert list(one.blocks) == ["b0"]
    before, after = assemble(whole), assemble(one)
    seen = seen_from(0, connections(before), before.blocks)
    kinetic = sum(
        0.5 * mass * (seen[k].ratio * speed) ** 2 for k, mass in enumerate(before.packed.inertia)
    )
    np.testing.assert_allclose(0.5 * after.packed.inertia[0] * speed**2, kinetic, rtol=1e-12)
    # virtual work: the effort at the root is that of every part times its ratio
    at = np.array([place])
    parts = {k: resisting(before, k, one.ratio * at + one.offset) for k, one in seen.items()}
    load = sum(seen[k].ratio * part.load[0] for k, part in parts.items())
    friction = sum(abs(seen[k].ratio) * part.friction[0] for k, part in parts.items())
    found = resisting(after, 0, at)
    scale = sum(abs(seen[k].ratio * part.load[0]) for k, part in parts.items()) + 1.0
    np.testing.assert_allclose(found.load[0], load, atol=1e-11 * scale)
    np.testing.assert_allclose(found.friction[0], friction, rtol=1e-12)


def test_a_gear_train_is_j_plus_r_squared_m() -> None:
    blocks = {"motor": rotor(3e-5), "wheel": rotor(2e-4), "table": slide(0.4)}
    links: dict[str, Link] = {
        "gear": Gear(("motor", "wheel"), 0.25),
        "rack": Rack(("wheel", "table"), Q(0.02, unit="m")),
    }
    one, told = lump_rigid_links(
        from_source(mechanism(blocks, links, "motor", "motor", (-1.0, 1.0)), "motor")[0], "motor"
    )
    assert one.blocks["motor"].inertia is not None
    np.testing.assert_allclose(
        one.blocks["motor"].inertia.value,
        3e-5 + 0.25**2 * 2e-4 + (0.25 * 0.02) ** 2 * 0.4,
        rtol=1e-14,
    )
    assert told.neglects == "nothing"
