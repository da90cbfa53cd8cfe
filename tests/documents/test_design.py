"""What a design asks of a method that does not do it is refused, and not passed over."""

from __future__ import annotations

from pathlib import Path

import pytest

from frictool.documents.design import READ_BY, Design
from frictool.documents.registry import load
from frictool.errors import DocumentError

ROOT = Path(__file__).parents[2] / "configs"
BASE = "format: design/1\nname: a\naxis: rotary\nstructure: position\nweights: {}\n"
ASKED = {
    "schedule": "schedule: [inertia]",
    "vertices": "vertices: first_order",
    "frozen_at": "frozen_at: identified",
    "scheduled": "scheduled: true",
    "grid": "grid: {degree: 1}",
    "channel_effort": "channel_effort: 0.003",
    "poles": "poles: {decay_rad_s: 3}",
    "pole_bound_rad_s": "pole_bound_rad_s: 1000",
    "recentring": "recentring: 1.05",
    "ease": "ease: 2",
}
METHODS = ("lpv", "lft", "lft_lpv", "lpv_grid", "minimax", "rst")


def _design(folder: Path, *lines: str) -> Design:
    path = folder / "design.yaml"
    path.write_text(BASE + "\n".join(lines) + "\n")
    return load(path, Design)


@pytest.mark.parametrize("key", READ_BY)
@pytest.mark.parametrize("method", METHODS)
def test_a_key_that_the_method_does_not_read_is_refused(tmp_path: Path, key: str, method: str) -> None:
    lines = (f"method: {method}", ASKED[key])
    if method in READ_BY[key]:
        assert _design(tmp_path, *lines).method == method
    else:
        with pytest.raises(DocumentError, match=rf"{key} is for methods? .*, and method is {method}; leave it out"):
            _design(tmp_path, *lines)


def test_the_trade_reads_the_schedule_of_its_inequalities(tmp_path: Path) -> None:
    assert _design(tmp_path, "method: minimax", "relax: auto", ASKED["schedule"], ASKED["recentring"]).schedule == ("inertia",)
    with pytest.raises(DocumentError, match="poles is for methods"):
        _design(tmp_path, "method: minimax", "relax: auto", ASKED["poles"])


def test_a_schedule_of_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DocumentError, match="schedule: found a list of 0; allowed: 1 to 5"):
        _design(tmp_path, "method: lpv", "schedule: []")


def test_the_rigs_ask_for_nothing_in_vain() -> None:
    paths = [*ROOT.glob("*/designs/*.yaml"), *ROOT.glob("*/refused/*.yaml")]
    assert len(paths) > 6
    for path in paths:
        load(path, Design)
