"""Mechanisms with something changed at random: refused in one line, or put together, derived and
linearised with finite numbers."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from frictool.cli.mechanism_file import load_mechanism
from frictool.documents.yaml_scalars import Loader
from frictool.equations.derivation import derive
from frictool.equations.derivation_views import as_latex, as_text
from frictool.errors import FrictoolError
from frictool.plant.mechanism.linearisation import linearise
from tests.support.file_mutations import mutated

HERE = Path(__file__).parent
SAMPLES = (HERE / "golden" / "clutch.yaml", HERE.parent / "documents" / "golden" / "mechanism.yaml")
NUMBERS = (0, -1, 1, 2, 0.5, -0.25, 1e-300, 1e300, 1e-9, 1e9)
UNITS = (
    "m",
    "rad",
    "N",
    "N m",
    "mm",
    "deg",
    "kg",
    "kg m^2",
    "N/m",
    "N m/rad",
    "N s/m",
    "1",
    "A",
    "V",
    "N m/A",
    "s",
)
SEED = 4


def places(tree: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every key and index of the tree."""
    items = (
        tree.items()
        if isinstance(tree, dict)
        else enumerate(tree)
        if isinstance(tree, list)
        else ()
    )
    return [place for key, value in items for place in ((*path, key), *places(value, (*path, key)))]


def changed(tree: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """One or two places replaced, removed or filled with what stands elsewhere."""
    tree = copy.deepcopy(tree)
    for _ in range(int(rng.integers(1, 3))):
        known = places(tree)
        path = known[int(rng.integers(len(known)))]
        at: Any = tree
        for key in path[:-1]:
            at = at[key]
        here = at[path[-1]]
        if rng.random() < 0.15:
            del at[path[-1]]
        elif isinstance(here, float | int) and not isinstance(here, bool):
            at[path[-1]] = NUMBERS[int(rng.integers(len(NUMBERS)))]
        elif path[-1] == "unit":
            at[path[-1]] = UNITS[int(rng.integers(len(UNITS)))]
        elif isinstance(here, str):
            names = (
                [*tree["blocks"], "ground"] if isinstance(tree.get("blocks"), dict) else ["ground"]
            )
            at[path[-1]] = names[int(rng.integers(len(names)))]
        else:
            other: Any = tree
            for key in known[int(rng.integers(len(known)))]:
                other = other[key]
            at[path[-1]] = copy.deepcopy(other)
    return tree


def outcome(path: Path) -> str:
    """`refused` or `taken`; raises where it is neither."""
    try:
        document, mechanism = load_mechanism(path)
    except FrictoolError as error:
        said = str(error)
    else:
        said = ""
    if said:
        assert len(said.splitlines()) == 1
        assert said.startswith(str(path))
        return "refused"
    for part in mechanism.packed:
        for array in part if isinstance(part, tuple) else (part,):
            assert not np.any(np.isnan(array))
    derivation = derive(document, mechanism)
    assert as_text(derivation)
    assert as_latex(derivation)
    assert np.all(np.isfinite(linearise(mechanism).mass))
    return "taken"


def tally(count: int, folder: Path, sample: Path) -> dict[str, int]:
    """Return the number of each outcome, over trees and texts with something changed."""
    path = folder / "mechanism.yaml"
    text = sample.read_bytes()
    tree = yaml.load(text, Loader)
    found = {"refused": 0, "taken": 0}
    for index in range(count):
        rng = np.random.default_rng([SEED, index])
        path.write_bytes(
            mutated(text, rng)
            if index % 4 == 0
            else yaml.safe_dump(changed(tree, rng), sort_keys=False).encode()
        )
        found[outcome(path)] += 1
    return found


@pytest.mark.parametrize("count", [40, pytest.param(60, marks=pytest.mark.accept)])
@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.stem)
def test_changed_mechanisms_are_refused_in_one_line_or_taken(
    sample: Path, count: int, tmp_path: Path
) -> None:
    found = tally(count, tmp_path, sample)
    assert min(found.values()) > 2
